"""The strip over the scene: the learner's status in its own words, and the truth, which it does not know."""

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
EXACT = np.radians(0.05)  # smaller errors are written as 0.0°
WHOLE = np.radians(1.0)  # larger angles are written in whole degrees
COPIED, NEARLY = np.radians(1.0), np.radians(5.0)  # the demonstrator's posture is called copied, or nearly so
ANY = np.radians(90.0)  # larger angles allow any posture
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
BY_PAGE = {"message", "recording", "replaying", "see-through", "editing"}  # said by the page, not by the learner
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
class StatusMessage:
    """What the learner says of itself."""

    state: str  # of TITLES
    sentence: str
    subject: str = ""  # of the title, such as names of joints
    doubt: str = ""  # what makes the learner unsure
    probe: bool = False  # whether it moves to learn how its images change

    @property
    def word(self) -> str:
        """Key of the glossary's entry; "" for none."""
        return "probe" if self.probe else self.state if self.state in glossary() else ""

    @property
    def title(self) -> str:
        """State and subject."""
        return f"{TITLES[self.state]} {self.subject}".strip()


def describe(
    snapshot: Snapshot,
    previous: Sequence[Snapshot] = (),
    playing: bool = True,
    assessment: Assessment | None = None,
    joints: Sequence[int] = (),
    advises: bool = True,
) -> StatusMessage:
    """Describe a snapshot in the learner's words.

    Parameters
    ----------
    snapshot
        The present one.
    previous
        Those before it, the latest last.
    playing
        Whether further motions follow.
    assessment
        What the learner knows about its posture, if it rests.
    joints
        Numbers of the moving joints, from 1.
    advises
        Whether to say what a visitor can do next, which is not possible in a replay.
    """
    if snapshot.pending_postures is not None and snapshot.is_rehearsing:
        left = len(snapshot.pending_postures)
        sentence = f"watches itself, with nobody to imitate; {left} posture{'s' if left > 1 else ''} to go."
        return StatusMessage(ServoStatus.MOVING if playing else "paused", sentence)
    if snapshot.awaits_names:
        return _without_names(snapshot, playing)
    if snapshot.transfer is None:
        return StatusMessage("lost", _too_few(int(snapshot.usable.sum())))
    E, doubt = f"E {svg.short_E(snapshot.E)} px²", _swapped(snapshot) or _named(snapshot) or _ill_conditioned(snapshot)
    if snapshot.status == ServoStatus.MAX_MOTIONS:
        advice = "; reset to go on" if advises else ""
        return StatusMessage(
            ServoStatus.MAX_MOTIONS, f"{E} after {MAX_HISTORY} motions, the most that are made{advice}.", doubt=doubt
        )
    if snapshot.status.is_at_rest:
        said = _resting(snapshot, E, assessment, joints, advises)
        return replace(said, doubt=doubt or said.doubt)
    if snapshot.motion == 0:
        advice = "; press space, or drag the demonstrator" if advises else ""
        return StatusMessage(ServoStatus.READY, f"{E}{advice}.", doubt=doubt)
    state, doing = ServoStatus.MOVING if playing else "paused", _says(snapshot)
    trend = "" if snapshot.probe else _trend(snapshot, previous)
    return StatusMessage(
        state, f"{E}{trend}{'; ' + doing if doing and playing else ''}.", doubt=doubt, probe=snapshot.probe
    )


def _resting(
    snapshot: Snapshot, E: str, assessment: Assessment | None, joints: Sequence[int], advises: bool
) -> StatusMessage:
    says, after = _says(snapshot, joints), f"after {svg.count_motions(snapshot.motion)}"
    why = f"; {says}." if says else "."
    known = snapshot.certificate if assessment is None else assessment.certificate
    if snapshot.status.is_claim:
        if known is not None and known.simultaneous_std_error > EXACT:
            about = f"; expects to be about {svg.short(float(np.degrees(known.simultaneous_std_error)))}° off"
            why = f"{about}; {says}." if snapshot.misfit is not None else f"{about}."
        return StatusMessage("arrived", f"{E} {after}{why}")
    unobservable = [] if known is None else known.reportable_joints(snapshot.status)
    if known is not None and unobservable:
        names = " and ".join(svg.joint_symbol(joints[k]) for k in unobservable)
        return StatusMessage(ServoStatus.UNOBSERVABLE, f"{_costs(known, joints)} {E} {after}{why}", names)
    if assessment is not None and assessment.at_local_minimum:
        return StatusMessage(
            "least", f"{E}, not 0, {after}{why}", doubt=f"So much E could hide {_upto(assessment.max_displacement)}."
        )
    if snapshot.status == ServoStatus.SETTLED:
        return StatusMessage(ServoStatus.SETTLED, f"{E} {after}{why}")
    advice = "; move an arm or reset" if advises else ""
    return StatusMessage(ServoStatus.NO_PROGRESS, f"{E} {after}{why if says else f', and it no longer falls{advice}.'}")


def _costs(known: Certificate, joints: Sequence[int]) -> str:
    """Say why joints are unobservable: the cost of noise, or that E did not rise."""
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


def _swapped(snapshot: Snapshot) -> str:
    """Say which of the demonstrator's points seem to be swapped; "" for none."""
    pairs = ", ".join(f"{i} and {j}" for i, j in snapshot.exchanged)
    return f"The demonstrator's points {pairs} seem to be exchanged." if pairs else ""


def _without_names(snapshot: Snapshot, playing: bool) -> StatusMessage:
    """Describe a snapshot in which the demonstrator's points have no names yet."""
    if snapshot.status.is_at_rest:
        return StatusMessage(snapshot.status, f"{_says(snapshot)}.")
    state = ServoStatus.READY if snapshot.motion == 0 else ServoStatus.MOVING if playing else "paused"
    sentence = "which of the demonstrator's points is which is not known yet, nor is E."
    return StatusMessage(state, sentence, probe=snapshot.probe)


def _named(snapshot: Snapshot) -> str:
    """Say how sure the names are that the learner found; "" for points that came with names."""
    naming = snapshot.naming
    if naming is None or snapshot.settings.matched:
        return ""
    if naming.is_ambiguous:
        return "Two answers: with other names of the points, another pose explains the images as well."
    found = naming.names >= 0
    uncertain, alone = np.flatnonzero(found & ~naming.certain).tolist(), int((~found).sum()) + len(naming.unnamed)
    named = f"{found.sum()} points named"
    sure = f", {', '.join(map(str, uncertain))} uncertainly" if uncertain else " with certainty"
    return f"{named}{sure}{f'; {alone} have no partner' if alone else ''}."


def _ill_conditioned(snapshot: Snapshot) -> str:
    """Say why the transfer is ill-conditioned; "" if it is not."""
    assert snapshot.transfer is not None
    condition, method = float(snapshot.transfer.condition), snapshot.method
    if snapshot.flatness >= RED > condition:
        return f"{FLATNESS} {svg.number(snapshot.flatness, 0)}: {FLAT}."
    if condition < AMBER:
        return ""
    high = ", far too high" if condition >= RED else ""
    return f"{method.condition_name} {svg.number(condition, 0)}{high}: {method.degenerate_message}."


def describe_truth(joints: Sequence[int], theta: NDArray[np.float64], theta_demo: NDArray[np.float64]) -> str:
    """Say how far off the learner is, which it cannot know. joints: numbers from 1; theta, theta_demo: (m,) rad."""
    is_at, should_be = theta.tolist(), theta_demo.tolist()
    off = [abs(own - demo) for own, demo in zip(is_at, should_be)]
    k = off.index(max(off))
    if off[k] < EXACT:
        return "The demonstrator's posture, to 0.1°."
    instead = f"{svg.degrees(is_at[k])} instead of {svg.degrees(should_be[k])}"
    return f"{svg.degrees(off[k])} off, at {svg.joint_symbol(joints[k])}: {instead}."


def describe_outcome(
    status: ServoStatus, motions: int, theta: NDArray[np.float64], theta_demo: NDArray[np.float64], playing: bool
) -> str:
    """Say first, in plain words, what has come of it, as HTML; this uses the truth. theta, theta_demo: (m,) rad."""
    off = float(np.abs(theta - theta_demo).max())
    how_far, after = f"{svg.degrees(off)} off", f"after {svg.count_motions(motions)}"
    if status == ServoStatus.READY:
        return "<b>Ready.</b> Press Play: the blue robot copies the pose of the orange one."
    if not status.has_ended:
        return f"<b>{'Copying' if playing else 'Paused'}:</b> still {how_far} {after}."
    if off < COPIED:
        return f"<b>Copied:</b> {how_far} {after}."
    return f"<b>{'Nearly copied' if off < NEARLY else 'Not copied'}:</b> it stopped {how_far} {after}."


def draw_status(message: StatusMessage, truth: str, choices: str = "", outcome: str = "") -> str:
    """Draw the strip as HTML. truth: what the learner does not know; choices, outcome: HTML."""
    words = f"<b>{svg.escape(message.title)}</b> · {svg.escape(with_minus(message.sentence))}"
    if message.doubt:
        words += f" <i>{svg.escape(message.doubt)}</i>"
    known, true = ask(message.word) if message.word else "", svg.escape(truth)
    who = "Page" if message.state in BY_PAGE else "Learner"
    first = f'<div class="vi-outcome vi-tells"><p>{outcome}</p></div>' if outcome else ""
    return (
        f'<div class="vi-strip"><div class="vi-status">{first}<div>{_icon(SHAPES.get(message.state, IDLE))}'
        f'<em>{who} says</em><p role="status">{words}{choices}</p>{known}</div>'
        f'<div class="vi-truth">{_icon(BETWEEN)}<em>Viewer only</em><p>{true}</p>{ask("truth")}</div></div></div>'
    )


def _icon(shape: str) -> str:
    return f'<svg width="22" height="22" viewBox="0 0 22 22" aria-hidden="true">{shape}</svg>'


def _trend(snapshot: Snapshot, previous: Sequence[Snapshot]) -> str:
    """Write the change of E per motion over the last motions without probes; "" if E is too small to be seen."""
    recent = [s for s in previous[-TREND:] if not s.probe and s.E >= svg.UNSEEN_E and s.motion < snapshot.motion]
    if not recent or not snapshot.E >= svg.UNSEEN_E:
        return ""
    first = recent[0]
    share = (snapshot.E / first.E) ** (1 / (snapshot.motion - first.motion)) - 1
    text = svg.number(100 * share, 0)
    return f", {text if share < 0 else '+' + text} % a motion"


def _says(snapshot: Snapshot, joints: Sequence[int] = ()) -> str:
    """Return the servo's own words, "" without any. joints: numbers from 1."""
    state = snapshot.servo_state
    if snapshot.misfit is not None and snapshot.status.is_at_rest:
        return snapshot.misfit.describe(joints)
    return "" if state is None else snapshot.servo.describe_status(state, snapshot.status)
