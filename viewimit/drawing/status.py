"""The strip over the scene: what the learner says, and, for the viewer only, what is true.

Only what the learner itself knows goes into what it says.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..analysis.self_assessment import Assessment
from ..estimation.equations import with_minus
from ..estimation.transfers.registry import FLAT, FLATNESS
from ..geometry.affine import MIN_POINTS
from ..loop.history import MAX_HISTORY
from ..loop.snapshot import Snapshot
from ..servo import Certificate, ServoStatus
from ..servo.trust_region.options import MAX_STD_PER_PX
from . import svg
from .glossary import ask, glossary
from .images.panel import AMBER, RED

TREND = 4  # motions over which the change of E is averaged
EXACT = np.radians(0.05)  # off, which reads as 0.0°
WHOLE = np.radians(1.0)  # from which a room is told in whole degrees
ANY = np.radians(90.0)  # a pixel's cost, or a room, that says no more than "any posture"
TITLES = {
    ServoStatus.READY: "Ready",
    "paused": "Paused",
    ServoStatus.MOVING: "Moving",
    "arrived": "Arrived",
    "least": "Settled where E is least nearby",
    ServoStatus.SETTLED: "Settled",
    ServoStatus.UNOBSERVABLE: "Cannot tell",
    ServoStatus.NO_PROGRESS: "No progress",
    "lost": "Lost",
    ServoStatus.MAX_MOTIONS: "Motion limit",
    "message": "Note",
    "recording": "Recording",
    "replaying": "Replaying",
    "see-through": "See-through arm",
    "editing": "Editing points",
}
BY_PAGE = {"message", "recording", "replaying", "see-through", "editing"}  # which the learner knows nothing of
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
RING = '<circle cx="11" cy="11" r="5.5" fill="none" stroke="var(--{0})" stroke-width="2.4"/>'
PLAY = (
    '<circle cx="11" cy="11" r="10" fill="var(--demonstrator)" fill-opacity=".28"/>'
    '<path d="M8 5.5v11l9-5.5z" class="vi-amber"/>'
)
AIM = (
    '<circle cx="11" cy="11" r="6" fill="none" stroke="var(--ink)" stroke-width="2"/>'
    '<path d="M0 11h8m6 0h8M11 0v8m0 6v8" fill="none" stroke="var(--ink)" stroke-width="2"/>'
)
IDLE = RING.format("secondary")
SHAPES = {
    ServoStatus.MOVING: DOT.format("learner"),
    "arrived": DOT.format("recovered"),
    "least": RING.format("recovered"),
    ServoStatus.SETTLED: RING.format("recovered"),
    ServoStatus.UNOBSERVABLE: DIAMOND,
    ServoStatus.NO_PROGRESS: DIAMOND,
    "lost": SQUARE,
    ServoStatus.MAX_MOTIONS: SQUARE,
    "recording": DOT.format("stopped"),
    "replaying": PLAY,
    "see-through": AIM,
    "editing": RING.format("chosen"),
}
BETWEEN = (
    '<path d="M6 11h10" stroke="var(--residual)" stroke-width="2.4"/>'
    '<circle cx="5" cy="11" r="4" fill="var(--learner)"/><path d="M17 6l5 5-5 5-5-5z" class="vi-amber"/>'
)


@dataclass(frozen=True)
class Said:
    """What the learner says: state, of TITLES; of: what the title is about; doubt: what makes it unsure; probe: whether
    it moves to learn."""

    state: str
    sentence: str
    of: str = ""
    doubt: str = ""
    probe: bool = False

    @property
    def word(self) -> str:
        """Of the glossary, "" if it needs none."""
        return "probe" if self.probe else self.state if self.state in glossary() else ""

    @property
    def title(self) -> str:
        return f"{TITLES[self.state]} {self.of}".strip()


def describe(
    snapshot: Snapshot,
    previous: Sequence[Snapshot] = (),
    playing: bool = True,
    assessment: Assessment | None = None,
    joints: Sequence[int] = (),
    advises: bool = True,
) -> Said:
    """previous: the snapshots before this one, the latest last. assessment: of this one, if it rests; joints: numbers
    from 1 of those that move; advises: whether it says what to do next, which nobody can in a replay."""
    if snapshot.pending_postures is not None and snapshot.is_rehearsing:
        left = len(snapshot.pending_postures)
        sentence = f"watches itself, with nobody to imitate; {left} posture{'s' if left > 1 else ''} to go."
        return Said(ServoStatus.MOVING if playing else "paused", sentence)
    if snapshot.transfer is None:
        return Said("lost", _too_few(int(snapshot.usable.sum())))
    E, doubt = f"E {svg.short_E(snapshot.E)} px²", _exchanged(snapshot) or _ill_conditioned(snapshot)
    if snapshot.status == ServoStatus.MAX_MOTIONS:
        advice = "; reset to go on" if advises else ""
        return Said(
            ServoStatus.MAX_MOTIONS, f"{E} after {MAX_HISTORY} motions, the most that are made{advice}.", doubt=doubt
        )
    if snapshot.status.is_at_rest:
        said = _resting(snapshot, E, assessment, joints, advises)
        return replace(said, doubt=doubt or said.doubt)
    if snapshot.motion == 0:
        advice = "; press space, or drag the demonstrator" if advises else ""
        return Said(ServoStatus.READY, f"{E}{advice}.", doubt=doubt)
    state, doing = ServoStatus.MOVING if playing else "paused", _says(snapshot)
    trend = "" if snapshot.probe else _trend(snapshot, previous)
    return Said(state, f"{E}{trend}{'; ' + doing if doing and playing else ''}.", doubt=doubt, probe=snapshot.probe)


def _resting(snapshot: Snapshot, E: str, assessment: Assessment | None, joints: Sequence[int], advises: bool) -> Said:
    says, after = _says(snapshot), f"after {_motions(snapshot.motion)}"
    why = f"; {says}." if says else "."
    known = snapshot.certificate if assessment is None else assessment.certificate
    if snapshot.status.is_claim:
        if known is not None and known.simultaneous_std_error > EXACT:
            why = f"; expects to be about {svg.short(float(np.degrees(known.simultaneous_std_error)))}° off."
        return Said("arrived", f"{E} {after}{why}")
    untold = [] if known is None else known.reportable_joints(snapshot.status)
    if known is not None and untold:
        names = " and ".join(svg.joint_symbol(joints[k]) for k in untold)
        return Said(ServoStatus.UNOBSERVABLE, f"{_costs(known, joints)} {E} {after}{why}", names)
    if assessment is not None and assessment.at_local_minimum:
        return Said(
            "least", f"{E}, not 0, {after}{why}", doubt=f"So much E could hide {_upto(assessment.max_displacement)}."
        )
    if snapshot.status == ServoStatus.SETTLED:
        return Said(ServoStatus.SETTLED, f"{E} {after}{why}")
    advice = "; move an arm or reset" if advises else ""
    return Said(ServoStatus.NO_PROGRESS, f"{E} {after}{why if says else f', and it no longer falls{advice}.'}")


def _costs(known: Certificate, joints: Sequence[int]) -> str:
    """What makes joints untold: the cost of noise, or that E was seen not to rise."""
    costly = [k for k in known.unobservable_joints if known.std_per_px[k] >= MAX_STD_PER_PX]
    by = "by " if len(costly) == 1 else ""
    each = [f"{svg.joint_symbol(joints[k])} {by}{_angle(known.std_per_px[k])}" for k in costly]
    return f"1 px of noise would turn {', '.join(each)}." if costly else "E was seen not to rise."


def _angle(rad: float) -> str:
    return svg.degrees(rad, 0) if rad < ANY else "any angle"


def _upto(rad: float) -> str:
    if rad < EXACT:
        return "less than 0.1°"
    return f"up to {svg.degrees(rad, 0 if rad >= WHOLE else 1)}" if rad < ANY else "any displacement"


def _too_few(used: int) -> str:
    seen = "no point is" if used == 0 else "only 1 point is" if used == 1 else f"only {used} points are"
    return f"{seen} seen in all images; at least {MIN_POINTS} non-coplanar points are needed."


def _exchanged(snapshot: Snapshot) -> str:
    """Which of the demonstrator's points the learner takes for each other, "" for none."""
    pairs = ", ".join(f"{svg.point_name(i)} and {svg.point_name(j)}" for i, j in snapshot.exchanged)
    return f"The demonstrator's points {pairs} seem to be exchanged." if pairs else ""


def _ill_conditioned(snapshot: Snapshot) -> str:
    """What speaks against the transfer, "" if nothing does."""
    assert snapshot.transfer is not None
    condition, method = float(snapshot.transfer.condition), snapshot.method
    if snapshot.flatness >= RED > condition:
        return f"{FLATNESS} {svg.number(snapshot.flatness, 0)}: {FLAT}."
    if condition < AMBER:
        return ""
    high = ", far too high" if condition >= RED else ""
    return f"{method.condition_name} {svg.number(condition, 0)}{high}: {method.degenerate_message}."


def describe_truth(joints: Sequence[int], theta: NDArray, theta_demo: NDArray) -> str:
    """How far off the learner is, which it cannot know. joints: numbers from 1; theta, theta_demo: (m,) rad."""
    is_at, should_be = theta.tolist(), theta_demo.tolist()
    off = [abs(own - demo) for own, demo in zip(is_at, should_be)]
    k = off.index(max(off))
    if off[k] < EXACT:
        return "The demonstrator's posture, to 0.1°."
    instead = f"{svg.degrees(is_at[k])} instead of {svg.degrees(should_be[k])}"
    return f"{svg.degrees(off[k])} off, at {svg.joint_symbol(joints[k])}: {instead}."


def draw_status(said: Said, truth: str, choices: str = "") -> str:
    """The strip. truth: for the viewer; choices: links, in HTML."""
    words = f"<b>{svg.escape(said.title)}</b> · {svg.escape(with_minus(said.sentence))}"
    if said.doubt:
        words += f" <i>{svg.escape(said.doubt)}</i>"
    known, true = ask(said.word) if said.word else "", svg.escape(truth)
    who = "Page" if said.state in BY_PAGE else "Learner"
    return (
        f'<div class="vi-strip"><div class="vi-status"><div>{_icon(SHAPES.get(said.state, IDLE))}'
        f'<em>{who} says</em><p role="status">{words}{choices}</p>{known}</div>'
        f'<div class="vi-truth">{_icon(BETWEEN)}<em>Viewer only</em><p>{true}</p>{ask("truth")}</div></div></div>'
    )


def _icon(shape: str) -> str:
    return f'<svg width="22" height="22" viewBox="0 0 22 22" aria-hidden="true">{shape}</svg>'


def _trend(snapshot: Snapshot, previous: Sequence[Snapshot]) -> str:
    """Change of E a motion, over the last motions that were no probes; "" from or to an E that nobody sees."""
    recent = [s for s in previous[-TREND:] if not s.probe and s.E >= svg.UNSEEN_E and s.motion < snapshot.motion]
    if not recent or not snapshot.E >= svg.UNSEEN_E:
        return ""
    first = recent[0]
    share = (snapshot.E / first.E) ** (1 / (snapshot.motion - first.motion)) - 1
    text = svg.number(100 * share, 0)
    return f", {text if share < 0 else '+' + text} % a motion"


def _says(snapshot: Snapshot) -> str:
    """The servo's own words, "" without any."""
    state = snapshot.servo_state
    return "" if state is None else snapshot.servo.describe_status(state, snapshot.status)


def _motions(count: int) -> str:
    return "1 motion" if count == 1 else f"{count} motions"
