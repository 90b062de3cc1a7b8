"""Colours, lines and words that the figures share: Okabe and Ito's colours, each role with a line of its own too."""

from collections.abc import Iterable, Sequence

from ...servo import SERVOS
from ...transfer import TRANSFERS

LEARNER, DEMONSTRATOR, RECOVERED, RESIDUAL = "#0072b2", "#8a5a00", "#007f5c", "#d55e00"
MARK = {"marker": "D", "color": "#e69f00", "markeredgecolor": DEMONSTRATOR, "linestyle": "none"}
DASHED = (0, (5, 4))
OF_SERVOS = (RESIDUAL, LEARNER, RECOVERED, "#b0508a", "#56b4e9")
OF_TRANSFERS = (LEARNER, RECOVERED, "#b0508a", RESIDUAL, "#56b4e9")
STYLE = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#dde1e7",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "savefig.dpi": 150,
    "svg.hashsalt": "viewimit",  # the same file from the same data
}


def of_transfer(name: str) -> tuple[str, str]:
    """Its title, and a colour of its own."""
    return TRANSFERS[name].title, _in_turn(name, TRANSFERS, OF_TRANSFERS)


def of_servo(name: str) -> tuple[str, str]:
    return SERVOS[name].title, _in_turn(name, SERVOS, OF_SERVOS)


def _in_turn(name: str, names: Iterable[str], colours: Sequence[str]) -> str:
    return colours[list(names).index(name) % len(colours)]


def angle_name(joint: int) -> str:
    return f"$\\theta_{joint}$"


def in_degrees(theta_deg) -> str:
    return "(" + ", ".join(f"{angle:.1f}°" for angle in theta_deg).replace("-", "−") + ")"
