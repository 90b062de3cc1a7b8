"""How the runs of a study are laid out for people, and kept as a table of rows."""

import csv
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...servo import ServoStatus
from ..experiment import cell
from .engine import FALSE_DEG, N_SIGMA, N_SIGMA_COVERED, NEAR_DEG, Run, Summary, arrives
from .intervals import Interval
from .measures import HEADINGS

# columns of a table: fields of `Run`; those of NEEDED stand in every table
NEEDED = {name: name for name in ("case", "run", "servo", "motions", "status", "error_deg", "expected_deg", "E_px2")}
NEEDED["run"] = "number"
COLUMNS = NEEDED | {name: name for name in ("transfer", "reason", "travel_deg", "cpu_s", "ended", "kept")}
ERRORS = "joint_errors_deg"


def lay_out(found: Sequence[Summary]) -> str:
    """Lay out summaries for people: shares, then motions and errors, then what the cases measure beside."""
    several = len({row.servo for row in found}) > 1, len({row.transfer for row in found}) > 1
    names = [", ".join([row.case, *([row.transfer] if several[1] else []), *([row.servo] if several[0] else [])])
             for row in found]  # fmt: skip
    blocks = [
        f"share of runs in % (95 % confidence interval); false: of claims, more than {FALSE_DEG:g}° and more than "
        f"{N_SIGMA:g} expected errors off",
        _table(names, [_shares(row) for row in found]),
        "median (95 % confidence interval) and 95th percentile of steps and of the worst joint's error; rms errors; "
        "expected: of claims, by the learner; travel and CPU: median of a run",
        _table(names, [_figures(row) for row in found]),
    ]
    if any(row.less for row in found):
        blocks += [
            f"beside {found[0].servo}, from the same draws: difference of shares, medians of differences",
            _table(names, [_differences(row) for row in found]),
        ]
    return "\n".join(
        [*blocks, "how runs end, and what the cases measure", _table(names, [_measures(row) for row in found])]
    )


def _shares(row: Summary) -> dict[str, object]:
    tenths = lambda share: share and share.with_tenths
    return {
        "as promised": row.kept,
        **{f"≤{limit:g}°": share for limit, share in row.within.items()},
        "claimed": row.claimed,
        "false": tenths(row.false),
        f"off >{FALSE_DEG:g}°": tenths(row.beyond),
        f"≤{N_SIGMA_COVERED:g} expected": tenths(row.covered),
        "no end": row.unended if row.unended.count else None,
    }


def _figures(row: Summary) -> dict[str, object]:
    degrees = lambda value: None if value is None else f"{value:.2f}°"
    return {
        "steps": row.motions.text(0),
        "95 % of steps": row.motions_95.text(0),
        "most": row.motions_most,
        "error": row.error_deg.text(2, "°"),
        "95 % of errors": row.error_95_deg.text(2, "°"),
        "rms": degrees(row.rms_deg),
        "of claims": degrees(row.claims_rms_deg),
        "expected": degrees(row.expected_deg),
        "travel": None if math.isnan(row.travel_deg) else f"{row.travel_deg:.0f}°",
        "CPU": None if math.isnan(row.cpu_s) else f"{1e3 * row.cpu_s:.1f} ms",
    }


def _differences(row: Summary) -> dict[str, object]:
    less = row.less
    return {
        f"≤{NEAR_DEG:g}°, more": less and less.near.percentage_points,
        "error less": less and less.error_deg.text(1, "°"),
        "steps less": less and less.motions.text(0),
    }


def _measures(row: Summary) -> dict[str, object]:
    words = lambda counts: ", ".join(f"{count} {word}" for word, count in counts.items()) or None
    texts = {HEADINGS.get(name, name.replace("_", " ")): _text(value) for name, value in row.measures.items()}
    return {**texts, "reasons": words(row.reasons), "ends": words(row.statuses)}


def _text(value: object) -> str:
    return value.text(2) if isinstance(value, Interval) else f"{value:.3g}" if isinstance(value, float) else str(value)


def _table(names: Sequence[str], rows: Sequence[dict[str, object]]) -> str:
    """Lay out cells by heading, as wide as they need; a dash stands for None, a column of them is left out."""
    heads = [head for head in dict.fromkeys(head for row in rows for head in row) if any(row.get(head) for row in rows)]
    cells = [[head.strip() for head in heads]]
    cells += [["–" if row.get(head) is None else str(row[head]) for head in heads] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells)]
    first = max(map(len, names))
    return "\n".join(
        f"  {name:<{first}}" + "".join(f"  {cell:>{width}}" for cell, width in zip(line, widths))
        for name, line in zip(["", *names], cells)
    )


def write_runs(runs: Sequence[Run], path: Path) -> None:
    """Write a CSV file, a row for each run, measures as columns of their own. Raises OSError."""
    measures = dict.fromkeys(name for run in runs for name in run.measures)
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow([*COLUMNS, ERRORS, *measures])
        for run in runs:
            known = [getattr(run, name) for name in COLUMNS.values()]
            errors = ";".join(map(cell, run.errors_deg))
            rows.writerow([*map(cell, known), errors, *(cell(run.measures.get(name)) for name in measures)])


def read_runs(path: Path) -> list[Run]:
    """Read what `write_runs` has written. Raises OSError, or ValueError that names the line."""
    with path.open(newline="", encoding="utf-8") as file:
        lines = csv.DictReader(file)
        if not set(NEEDED) <= set(lines.fieldnames or ()):
            raise ValueError(
                f"{path}: is no table of runs that --csv has written: it lacks columns of {','.join(NEEDED)}"
            )
        runs = []
        for line in lines:
            try:
                runs.append(_run(line))
            except (TypeError, ValueError) as error:
                raise ValueError(f"{path}: line {lines.line_num}: {error}") from None
    if not runs:
        raise ValueError(f"{path}: holds no runs")
    return runs


def _run(line: dict[str, str]) -> Run:
    """A row as a run; what an earlier table lacks is unknown."""
    said: dict[str, Any] = {name: line.get(name, "") for name in ("case", "transfer", "servo", "reason")}
    said |= {name: float(line.get(name) or "nan") for name in ("expected_deg", "E_px2", "travel_deg", "cpu_s")}
    run = Run(
        **said,
        number=int(line["run"]),
        motions=int(line["motions"]),
        status=ServoStatus(line["status"]),
        errors_deg=tuple(map(float, (line.get(ERRORS) or line["error_deg"]).split(";"))),
        ended=line.get("ended", "1") == "1",
        kept=False,
        measures={name: float(value) for name, value in line.items() if value and name not in (*COLUMNS, ERRORS)},
    )
    return replace(run, kept=line["kept"] == "1" if "kept" in line else arrives(run))
