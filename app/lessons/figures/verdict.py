"""What the learner says of itself when it has come to rest, and what is true."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from viewimit.drawing import svg
from viewimit.drawing.lessons import verdict
from viewimit.drawing.lessons.verdict import draw_verdict
from viewimit.estimation.views import Pairs
from viewimit.loop.snapshot import Snapshot
from viewimit.servo import ServoStatus

from ..joint_names import joint_names
from ..measures.exchange import least_as_seen, named, true_pairs
from ..measures.rest import last
from ..stage import Stage
from .figure_kind import FigureKind

ELSE = {
    ServoStatus.CONVERGED: "I have arrived.",
    ServoStatus.SETTLED: "I rest where E is least, and do not know whether I have arrived.",
    ServoStatus.NO_PROGRESS: "I have found nothing lower, and have not arrived.",
    ServoStatus.TOO_FEW_POINTS: "I see too few points.",
}


def _verdict(stage: Stage, layers: Collection[str], small: bool) -> str:
    moment = last(stage)
    if not layers:
        return ""
    if moment is None:
        return '<p class="vi-waits">the learner is on its way …</p>'
    names = joint_names(stage.session.scene)
    return draw_verdict(_says(stage, moment, names), _truth(stage, moment, names), layers)


def _says(stage: Stage, moment: Snapshot, names: Sequence[str]) -> list[str]:
    """Of what it knows itself."""
    E = f"{svg.short_E(moment.E)} px²".replace("<", "below")
    known, ending = moment.certificate, ELSE.get(moment.status, f"I have stopped after {moment.motion} motions.")
    pairs = named(stage)
    if pairs:
        before = f"{svg.short(least_as_seen(stage))} px²"
        told = f"As I saw them E never fell below {before}; with them changed back it is {E}."
        return [f"Something does not fit: {_of(pairs)} seem to be swapped.", told, ending]
    untold = [] if known is None else known.reportable_joints(moment.status)
    if untold:
        joints = " and ".join(names[k] for k in untold)
        told = f"E is {E} after {moment.motion} motions, and it does not rise when that joint turns."
        return [f"I cannot tell the {joints}.", told, "I do not say that I have arrived."]
    return [ending, f"E is {E} after {moment.motion} motions."]


def _truth(stage: Stage, moment: Snapshot, names: Sequence[str]) -> list[str]:
    off = np.degrees(np.abs(moment.theta - moment.theta_demo))
    k = int(off.argmax())
    words = [f"{svg.number(off[k], 1)}° off, at the {names[k]}."]
    if true_pairs(stage):
        words.append(f"Swapped are {_of(true_pairs(stage))}.")
    return words


def _of(pairs: Pairs) -> str:
    return "points " + ", ".join(f"{i} and {j}" for i, j in pairs)


FIGURES: Mapping[str, FigureKind] = {"verdict": FigureKind(_verdict, verdict.LAYERS, works=("races",))}
