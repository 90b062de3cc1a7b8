"""What every front end says of a run, and in which colour: the status alone decides, from assets/verdicts.json.

The lab's modules read the same file.
"""

from collections.abc import Mapping
from functools import cache
from math import isfinite

import msgspec

from ..assets import ROOT
from .status import ServoStatus

ANY_JOINT = "every joint"  # where it is not known which joint the points do not show


class Verdict(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How a status is told.

    Parameters
    ----------
    label
        Two or three words.
    says
        One or two sentences, with places for `Verdict.sentence` to fill.
    dot
        Colour of the mark beside it: none, blue, green, amber, red or grey. Green is a claim with evidence.
    """

    label: str
    says: str
    dot: str

    def sentence(
        self, steps: int, E: float, seen: int = 0, joints: str = ANY_JOINT, std_error_deg: float | None = None
    ) -> str:
        """Return the sentence for one run.

        Parameters
        ----------
        steps
            That were made.
        E
            px², NaN if there is none.
        seen
            Points that all four pictures show.
        joints
            Names of those that the points do not show.
        std_error_deg
            What the learner expects to be off, of its worst joint; None if it does not say, inf if it cannot.
        """
        says = self.says
        if std_error_deg is None or not isfinite(std_error_deg):
            std_error_deg = None
            says = says.split(" It expects", 1)[0]
        return says.format(
            steps=f"{steps} {'step' if steps == 1 else 'steps'}",
            differ=f"{E**0.5:.{0 if E >= 100 else 1}f} px" if E >= 0 else "–",
            seen=seen,
            joints=joints,
            off="" if std_error_deg is None else f"{max(std_error_deg, 0.1):.{0 if std_error_deg >= 10 else 1}f}°",
        )


@cache
def verdicts() -> Mapping[ServoStatus, Verdict]:
    """Return the verdict of each status."""
    return msgspec.json.decode(ROOT.joinpath("verdicts.json").read_bytes(), type=dict[ServoStatus, Verdict])


def verdict(status: ServoStatus) -> Verdict:
    """Return the verdict of a status."""
    return verdicts()[status]
