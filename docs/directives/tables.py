"""Tables of pages: rows computed from what commands of `viewimit bench` have printed, kept in docs/measured."""

import json
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from viewimit.experiments.bench.engine import Summary, summarise
from viewimit.experiments.bench.intervals import Share
from viewimit.experiments.bench.report import read_runs

MEASURED = Path(__file__).parents[1] / "measured"
COMPARISON = Path(__file__).parents[1] / "comparison.csv"


class Table:
    """A table, as an example of a page shows it. Cells and heads are HTML."""

    def __init__(self, rows: Iterable[Sequence[object]], heads: Sequence[str]):
        self.rows, self.heads = rows, heads

    def _repr_html_(self) -> str:
        line = lambda kind, cells: "<tr>" + "".join(f"<{kind}>{cell}</{kind}>" for cell in cells) + "</tr>"
        return (
            f'<table class="docutils">{line("th", self.heads)}{"".join(line("td", row) for row in self.rows)}</table>'
        )


def measured(name: str) -> list[dict[str, Any]]:
    """Return what a benchmark found, in the file NAME.json. Shares are `Share`s."""
    printed = json.loads((MEASURED / f"{name}.json").read_text("utf-8"), object_hook=_with_shares)
    return printed[printed["options"]["benchmark"]]


def _with_shares(found: dict[str, Any]) -> Any:
    return Share(**found) if found.keys() == Share.__dataclass_fields__.keys() else found


@cache
def compared() -> dict[tuple[str, str], Summary]:
    """Return the comparison of all servo laws, by case and law."""
    return {(cell.case, cell.servo): cell for cell in summarise(read_runs(COMPARISON), {})}
