"""The live diagnosis: one state, one sentence. Only what the learner itself knows goes into it."""

from collections.abc import Sequence

import numpy as np

from ..geometry.affine import MIN_POINTS
from ..servo.gradient import GradientState
from ..servo.trust_region import CERTAIN
from ..session import MAX_HISTORY
from ..snapshot import Snapshot
from . import svg
from .metrics import AMBER, CONDITION, FLATNESS, RED

TREND = 4  # motions over which the change of E is averaged
TITLES = {
    "ready": "Ready",
    "paused": "Paused",
    "moving": "Moving",
    "converged": "Converged",
    "ill-conditioned": "Ill-conditioned",
    "stalled": "Stalled",
    "stopped": "Stopped",
    "message": "Note",
    "recording": "Recording",
    "replaying": "Replaying",
}
ILL = {"epipolar": "epipolar lines nearly parallel, E may mislead"}
FLAT = "the points nearly lie in a plane, E may mislead"
DOT = (
    '<circle cx="11" cy="11" r="10" fill="var(--{0})" fill-opacity=".28"/>'
    '<circle cx="11" cy="11" r="6" fill="var(--{0})"/>'
)
DIAMOND = (
    '<path d="M11 1l10 10-10 10-10-10z" fill="var(--demonstrator)" fill-opacity=".28"/>'
    '<path d="M11 4.5l6.5 6.5-6.5 6.5-6.5-6.5z" class="vi-amber"/>'
)
SQUARE = (
    '<rect x="1.5" y="1.5" width="19" height="19" rx="4" fill="var(--stopped)" fill-opacity=".28"/>'
    '<rect x="5.5" y="5.5" width="11" height="11" rx="1.5" class="vi-red"/>'
)
RING = '<circle cx="11" cy="11" r="5.5" fill="none" stroke="var(--secondary)" stroke-width="2"/>'
PLAY = (
    '<circle cx="11" cy="11" r="10" fill="var(--demonstrator)" fill-opacity=".28"/>'
    '<path d="M8 5.5v11l9-5.5z" class="vi-amber"/>'
)
SHAPES = {
    "moving": DOT.format("learner"),
    "converged": DOT.format("recovered"),
    "ill-conditioned": DIAMOND,
    "stalled": DIAMOND,
    "stopped": SQUARE,
    "recording": DOT.format("stopped"),
    "replaying": PLAY,
}


def describe(snapshot: Snapshot, previous: Sequence[Snapshot] = (), playing: bool = True) -> tuple[str, str]:
    """State and sentence. previous: the snapshots before this one, the latest last."""
    used, E = int(snapshot.usable.sum()), f"E {svg.short(snapshot.E)} px²"
    if snapshot.transfer is None:
        seen = f"only {used} points are" if used != 1 else "only 1 point is"
        if used == 0:
            seen = "no point is"
        return "stopped", f"{seen} seen in all images; at least {MIN_POINTS} non-coplanar points are needed."
    if snapshot.status == "stopped":
        return "stopped", f"{E} after {MAX_HISTORY} motions, the most that are made; reset to go on."
    condition = float(snapshot.transfer.condition)
    gauge = f"{CONDITION.get(snapshot.settings.transfer, FLATNESS)} {svg.number(condition, 0)}"
    if snapshot.flatness >= RED > condition:
        return "ill-conditioned", f"σ₁/σ₃ {svg.number(snapshot.flatness, 0)}: {FLAT}; {E}."
    if condition >= RED:
        return "ill-conditioned", f"{gauge}, far too high: {ILL.get(snapshot.settings.transfer, FLAT)}; {E}."
    if condition >= AMBER:
        return "ill-conditioned", f"{gauge}: {ILL.get(snapshot.settings.transfer, FLAT)}; {E}."
    if snapshot.status == "converged":
        return "converged", f"{E} after {_motions(snapshot.motion)}; {_rest(snapshot)}."
    if isinstance(snapshot.servo_state, GradientState) and snapshot.status == "stalled":
        return (
            "stalled",
            f"{E} after {_motions(snapshot.motion)}; not lower for {snapshot.servo_state.since_best} motions.",
        )
    if snapshot.status == "stalled":
        return "stalled", f"{E} after {_motions(snapshot.motion)}, and it no longer falls; move an arm or reset."
    if snapshot.motion == 0:
        return "ready", f"{E}; press space, or drag the demonstrator."
    trend = _trend(snapshot, previous)
    state = "moving" if playing else "paused"
    if snapshot.probe and playing:
        return state, f"{E}; a probing motion, to learn how the images move."
    return state, f"{E}{trend}; transfer well conditioned."


def draw_status(state: str, sentence: str) -> str:
    """The pill over the scene."""
    return (
        f'<div class="vi-status" role="status"><svg width="22" height="22" viewBox="0 0 22 22">'
        f"{SHAPES.get(state, RING)}</svg><span><b>{TITLES[state]}</b> · {svg.escape(sentence)}</span></div>"
    )


def _trend(snapshot: Snapshot, previous: Sequence[Snapshot]) -> str:
    """Change of E a motion, over the last motions that were no probes."""
    recent = [s for s in previous[-TREND:] if not s.probe and s.E > 0 and s.motion < snapshot.motion]
    if not recent or not snapshot.E > 0:
        return ""
    first = recent[0]
    share = (snapshot.E / first.E) ** (1 / (snapshot.motion - first.motion)) - 1
    text = svg.number(100 * share, 0)
    return f", {text if share < 0 else '+' + text} % a motion"


def _rest(snapshot: Snapshot) -> str:
    if snapshot.expected_error:
        return f"the images' noise leaves about {svg.short(float(np.degrees(snapshot.expected_error)))}°"
    if snapshot.settings.servo == "trust-region":
        return f"E leaves no room for {np.degrees(CERTAIN):.1g}°"
    if snapshot.settings.servo == "broyden":
        return "next step under 0.1°"
    return "E no longer falls"


def _motions(count: int) -> str:
    return "1 motion" if count == 1 else f"{count} motions"
