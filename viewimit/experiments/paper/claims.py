"""What the paper says beside what is found here, and how far apart they may be: all tolerances, with their reasons."""

from dataclasses import dataclass

from ...disturbances import ImageDisturbance
from ...settings import Settings, disturbances

PAPER = Settings()  # the scene and transfer that the tolerances are about
PAPER_DEMONSTRATOR_DEG = (45.0, -90.0)


@dataclass(frozen=True)
class Claim:
    """One line of the table, in words. holds: None where nothing is claimed, or not of these settings."""

    name: str
    paper: str
    here: str
    tolerance: str
    holds: bool | None


@dataclass(frozen=True)
class Tolerance:
    value: float
    reason: str


TOLERANCES = {
    "minimum": Tolerance(
        5.0, "degrees a joint: the paper's own minimum is 4° off; the offset is the affine camera's, and the scene's"
    ),
    "minimum on pictures": Tolerance(
        10.0, "degrees a joint: one step of the grid; the affine camera's offset is smaller, detection adds to it"
    ),
    "minima": Tolerance(1, "the paper shows one"),
    "basin": Tolerance(0.99, "share of starts that run downhill to it: 'almost convex'"),
    "near": Tolerance(3.0, "degrees: the bias of E's minimum is up to 3° over the range"),
    "E at rest": Tolerance(0.05, "px² above E's least value, which the affine camera keeps from 0"),
    "starts": Tolerance(
        0.8, "share of starts: the law has no excitation or first covariance in print, and these were chosen for it"
    ),
    "image": Tolerance(1.0, "px: the width of a drawn line in images of 640 x 240"),
    "joints": Tolerance(1.0, "degrees: the bias of E's minimum in this scene"),
    "hand": Tolerance(10.0, "mm: what 1° makes of an arm's 0.6 m from shoulder to hand"),
    "before": Tolerance(10.0, "times farther off: a transfer fitted in another posture carries its conflict along"),
}


class Claims(list[Claim]):
    """Claims about a run with these settings; a condition is judged only where the tolerances are about them."""

    def __init__(self, settings: Settings, judged: bool = True):
        super().__init__()
        same = judged and all(
            getattr(settings, name) == getattr(PAPER, name)
            for name in ("scene", "robot", "points", "transfer", *disturbances(ImageDisturbance))
        )
        self._judged = same and settings.demonstrator_deg in (None, PAPER_DEMONSTRATOR_DEG)

    def add(self, name: str, paper: str, here: str, tolerance: str = "–", condition=None) -> None:
        judged = self._judged and condition is not None
        self.append(Claim(name, paper, here, tolerance, bool(condition) if judged else None))


def in_degrees(theta_deg) -> str:
    return "(" + ", ".join(f"{angle:.1f}°" for angle in theta_deg).replace("-", "−") + ")"


def table(claims: list[Claim]) -> str:
    """For people."""
    marks = {True: "pass", False: "MISS", None: "–"}
    rows = [("", "paper", "here", "tolerance", "")]
    rows += [(claim.name, claim.paper, claim.here, claim.tolerance, marks[claim.holds]) for claim in claims]
    widths = [max(len(row[k]) for row in rows) for k in range(5)]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)
