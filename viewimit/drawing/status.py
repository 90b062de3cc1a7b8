"""The live diagnosis: one state, one sentence. Only what the learner itself knows goes into it."""

from collections.abc import Sequence

import numpy as np

from ..geometry.affine import MIN_POINTS
from ..history import MAX_HISTORY
from ..servo import SERVOS
from ..snapshot import Snapshot
from ..transfer import TRANSFERS
from ..transfer.transfer import FLAT, FLATNESS
from . import svg
from .metrics import AMBER, RED

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
    "see-through": "See-through arm",
}
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
AIM = (
    '<circle cx="11" cy="11" r="6" fill="none" stroke="var(--ink)" stroke-width="2"/>'
    '<path d="M0 11h8m6 0h8M11 0v8m0 6v8" fill="none" stroke="var(--ink)" stroke-width="2"/>'
)
SHAPES = {
    "moving": DOT.format("learner"),
    "converged": DOT.format("recovered"),
    "ill-conditioned": DIAMOND,
    "stalled": DIAMOND,
    "stopped": SQUARE,
    "recording": DOT.format("stopped"),
    "replaying": PLAY,
    "see-through": AIM,
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
    method = TRANSFERS[snapshot.settings.transfer]
    gauge = f"{method.condition_name} {svg.number(condition, 0)}"
    if snapshot.flatness >= RED > condition:
        return "ill-conditioned", f"{FLATNESS} {svg.number(snapshot.flatness, 0)}: {FLAT}; {E}."
    if condition >= RED:
        return "ill-conditioned", f"{gauge}, far too high: {method.ill}; {E}."
    if condition >= AMBER:
        return "ill-conditioned", f"{gauge}: {method.ill}; {E}."
    if snapshot.status == "converged":
        return "converged", f"{E} after {_motions(snapshot.motion)}; {_arrival(snapshot)}."
    if snapshot.status == "stalled":
        why = _rest(snapshot)
        ending = f"; {why}." if why else ", and it no longer falls; move an arm or reset."
        return "stalled", f"{E} after {_motions(snapshot.motion)}{ending}"
    if snapshot.motion == 0:
        return "ready", f"{E}; press space, or drag the demonstrator."
    trend = _trend(snapshot, previous)
    state = "moving" if playing else "paused"
    if snapshot.probe and playing:
        return state, f"{E}; a probing motion, to learn how the images move."
    return state, f"{E}{trend}; transfer well conditioned."


def draw_status(state: str, sentence: str, choices: str = "") -> str:
    """The pill over the scene. choices: links, in HTML."""
    return (
        f'<div class="vi-status" role="status"><svg width="22" height="22" viewBox="0 0 22 22">'
        f"{SHAPES.get(state, RING)}</svg><span><b>{TITLES[state]}</b> · {svg.escape(sentence)}{choices}</span></div>"
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


def _arrival(snapshot: Snapshot) -> str:
    if snapshot.expected_error:
        return f"the images' noise leaves about {svg.short(float(np.degrees(snapshot.expected_error)))}°"
    return _rest(snapshot) or "E no longer falls"


def _rest(snapshot: Snapshot) -> str:
    """The servo's own words, "" without any."""
    state = snapshot.servo_state
    return "" if state is None else SERVOS[snapshot.settings.servo].rests(state, snapshot.status)


def _motions(count: int) -> str:
    return "1 motion" if count == 1 else f"{count} motions"
