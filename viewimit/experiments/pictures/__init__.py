"""Figures of the experiments, by matplotlib, as SVG and PNG. The same data give the same file."""

from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from . import fig7, fig8, fig9, fig10
from .style import STYLE

DRAWINGS = {"fig7": fig7.figures, "fig8": fig8.figures, "fig9": fig9.figures, "fig10": fig10.figures}


def draw(name: str, result, folder: Path) -> list[Path]:
    """All figures of an experiment → their files."""
    written: list[Path] = []
    if name not in DRAWINGS:  # an experiment without such figures
        return written
    with rc_context(STYLE):
        figures: dict[str, Figure] = DRAWINGS[name](result)
        for part, figure in figures.items():
            for suffix, metadata in ((".svg", {"Date": None}), (".png", {"Software": None})):
                written.append(folder / f"{'-'.join(filter(None, (name, part)))}{suffix}")
                figure.savefig(written[-1], metadata=metadata)
    return written
