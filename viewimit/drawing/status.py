"""The strip over the scene: the learner's status in its own words, and the truth, which it does not know."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..analysis.self_assessment import Assessment
from ..estimation.equations import with_minus
from ..estimation.transfers.registry import BADLY_CONDITIONED, ILL_CONDITIONED
from ..estimation.transfers.transfer import FLAT, FLATNESS
from ..geometry.arrays import Floats
from ..loop.snapshot import Snapshot
from ..servo import Certificate, ServoStatus, verdict, verdicts
from ..servo.certificate import MAX_STD_PER_PX
from ..servo.verdict import ANY_JOINT
from ..wording import listed, plural, sentences
from . import svg
from .glossary import ask, glossary

TREND = 4  # motions over which the change of E is averaged
EXACT = np.radians(0.05)  # smaller errors are written as 0.0°
WHOLE = np.radians(1.0)  # larger angles are written in whole degrees
COPIED, NEARLY = np.radians(1.0), np.radians(5.0)  # the demonstrator's posture is called copied, or nearly so
ANY = np.radians(90.0)  # larger angles allow any posture
TITLES = {  # of states that only the page has; those of a learner are in assets/verdicts.json
    "paused": "Paused",
    "message": "Note",
    "recording": "Recording",
    "replaying": "Moving the demonstrator",
    "see-through": "Ghost arm",
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
DOTS = {"blue": DOT.format("learner"), "green": DOT.format("recovered"), "amber": DIAMOND, "red": SQUARE}
DOTS |= {"grey": DOT.format("secondary"), "none": IDLE}
SHAPES = {"recording": DOT.format("stopped"), "replaying": PLAY, "see-through": AIM, "editing": RING.format("chosen")}
SHAPES |= {str(status): DOTS[told.dot] for status, told in verdicts().items()}
BETWEEN = (
    '<path d="M6 11h10" stroke="var(--residual)" stroke-width="2.4"/>'
    '<circle cx="5" cy="11" r="4" fill="var(--learner)"/><path d="M17 6l5 5-5 5-5-5z" class="vi-amber"/>'
)


@dataclass(frozen=True)
class StatusMessage:
    """What the learner says of itself."""

    state: str  # of TITLES, or a status
    sentence: str
    doubt: str = ""  # what makes the learner unsure
    probe: bool = False  # whether it moves to learn how its images change

    @property
    def word(self) -> str:
        """Key of the glossary's entry; "" for none."""
        return "probe" if self.probe else self.state if self.state in glossary() else ""

    @property
    def title(self) -> str:
        """State, in a few words."""
        return TITLES[self.state] if self.state in TITLES else verdict(ServoStatus(self.state)).label


def describe(
    snapshot: Snapshot,
    previous: Sequence[Snapshot] = (),
    playing: bool = True,
    assessment: Assessment | None = None,
    joints: Sequence[int] = (),
    advises: bool = True,
) -> StatusMessage:
    """Describe a snapshot in the learner's words.

    previous: those before it, the latest last; playing: whether further motions follow; assessment: what the learner
    knows about its posture, if it rests; joints: numbers of the moving ones, from 1; advises: whether to say what a
    visitor can do next, which is not possible in a replay.
    """
    if snapshot.pending_postures is not None and snapshot.is_rehearsing:
        left = len(snapshot.pending_postures)
        poses = f"{left} {plural('pose is', 'poses are', left)} left."
        sentence = f"It watches its own arm, without a demonstrator. {poses}"
        return StatusMessage(ServoStatus.MOVING if playing else "paused", sentence)
    if snapshot.awaits_names:
        return _without_names(snapshot, playing)
    if snapshot.transfer is None:
        few = verdict(ServoStatus.TOO_FEW_POINTS).sentence(snapshot.motion, snapshot.E, int(snapshot.usable.sum()))
        return StatusMessage(ServoStatus.TOO_FEW_POINTS, sentences(few, "They must not lie in a plane."))
    pairs = ", ".join(f"{i} and {j}" for i, j in snapshot.exchanged)
    swapped = f"The demonstrator's points {pairs} seem to be mixed up." if pairs else ""
    E, doubt = svg.short_E(snapshot.E), swapped or _named(snapshot) or _ill_conditioned(snapshot)
    if snapshot.status == ServoStatus.MAX_MOTIONS:
        sentence = verdict(snapshot.status).sentence(snapshot.motion, snapshot.E)
        advice = "Reset to go on." if advises else ""
        return StatusMessage(ServoStatus.MAX_MOTIONS, sentences(sentence, advice), doubt=doubt)
    if snapshot.status.is_at_rest:
        said = _resting(snapshot, assessment, joints, advises)
        return replace(said, doubt=doubt or said.doubt)
    if snapshot.motion == 0:
        advice = "Press Play, or drag the demonstrator." if advises else ""
        return StatusMessage(ServoStatus.READY, sentences(f"E is {E} px².", advice), doubt=doubt)
    state, doing = ServoStatus.MOVING if playing else "paused", _says(snapshot)
    trend = None if snapshot.probe else _trend(snapshot, previous)
    sentence = f"E is {E} px²."
    if trend is not None:
        way = "falling" if trend < 0 else "rising"
        sentence = f"E is {E} px², {way} by {svg.number(100 * abs(trend), 0)} % per step."
    return StatusMessage(state, sentences(sentence, doing if playing else ""), doubt=doubt, probe=snapshot.probe)


def _resting(snapshot: Snapshot, assessment: Assessment | None, joints: Sequence[int], advises: bool) -> StatusMessage:
    """Say how a servo rests: the verdict of its status, then its own reason or what E alone tells."""
    status, why = snapshot.status, _says(snapshot, joints)
    known = snapshot.certificate if assessment is None else assessment.certificate
    unobservable = [] if known is None else known.unobservable_joints
    names = listed([svg.joint_symbol(joints[k]) for k in unobservable]) if unobservable else ANY_JOINT
    own = snapshot.expected_error  # not the assessment's: E's curvature knows nothing of a bias, and promises no error
    off = None if own is None else float(np.degrees(own))
    said = verdict(status).sentence(snapshot.motion, snapshot.E, int(snapshot.usable.sum()), names, off)
    if status.is_claim:
        return StatusMessage(status, sentences(said, why if snapshot.misfit is not None else ""))
    costs = _costs(known, joints) if known is not None and unobservable else ""
    if assessment is not None and assessment.at_local_minimum and not unobservable:
        return StatusMessage(status, sentences(said, why), doubt=_could_be_off(assessment.max_displacement))
    advice = "Move an arm, or reset." if advises and status == ServoStatus.NO_PROGRESS else ""
    return StatusMessage(status, sentences(said, costs, why or advice))


def _costs(known: Certificate, joints: Sequence[int]) -> str:
    """Say why joints are unobservable: the cost of noise, or that no picture shows them."""
    costly = [k for k in known.unobservable_joints if known.std_per_px[k] >= MAX_STD_PER_PX]
    if not costly:
        return "No picture so far shows how they stand."
    angles = [svg.degrees(std, 0) if std < ANY else "any angle" for std in known.std_per_px[costly].tolist()]
    each = [f"{svg.joint_symbol(joints[k])} by {angle}" for k, angle in zip(costly, angles)]
    return f"1 px of noise would shift {', '.join(each)}."


def _could_be_off(rad: float) -> str:
    """Say how far off a learner may be whose E is not 0."""
    if rad < EXACT:
        return "By E alone, it is less than 0.1° off."
    if rad >= ANY:
        return "By E alone, it could be anywhere."
    angle = svg.degrees(rad, 0 if rad >= WHOLE else 1)
    return f"By E alone, it could be up to {angle} off."


def _without_names(snapshot: Snapshot, playing: bool) -> StatusMessage:
    """Describe a snapshot in which the demonstrator's points have no names yet."""
    if snapshot.status.is_at_rest:
        return StatusMessage(snapshot.status, sentences(_says(snapshot)))
    state = ServoStatus.READY if snapshot.motion == 0 else ServoStatus.MOVING if playing else "paused"
    sentence = "It does not know yet which of the demonstrator's points is which, so there is no E."
    return StatusMessage(state, sentence, probe=snapshot.probe)


def _named(snapshot: Snapshot) -> str:
    """Say how sure the names are that the learner found; "" for points that came with names."""
    naming = snapshot.naming
    if naming is None or snapshot.settings.matched:
        return ""
    if naming.is_ambiguous:
        return "There are two answers: with other names of the points, another pose explains the pictures as well."
    found = naming.names >= 0
    uncertain, alone = np.flatnonzero(found & ~naming.certain).tolist(), int((~found).sum()) + len(naming.unnamed)
    n = int(found.sum())
    text = f"It is sure of the {plural('name', 'names', n)} of {svg.count_points(n)}."
    if uncertain:
        text = f"It named {svg.count_points(n)}, uncertainly {', '.join(map(str, uncertain))}."
    partners = f"{svg.count_points(alone)} {plural('has', 'have', alone)} no partner."
    return sentences(text, partners if alone else "")


def _ill_conditioned(snapshot: Snapshot) -> str:
    """Say why the transfer is ill-conditioned; "" if it is not."""
    assert snapshot.transfer is not None
    condition, method = float(snapshot.transfer.condition), snapshot.method
    if snapshot.flatness >= BADLY_CONDITIONED > condition:
        return sentences(f"{FLATNESS} is {svg.number(snapshot.flatness, 0)}, which is high.", FLAT)
    if condition < ILL_CONDITIONED:
        return ""
    words = "far too high" if condition >= BADLY_CONDITIONED else "which is high"
    return sentences(f"{method.condition_name} is {svg.number(condition, 0)}, {words}.", method.degenerate_message)


def describe_truth(joints: Sequence[int], theta: Floats, theta_demo: Floats) -> str:
    """Say how far off the learner is, which it cannot know. joints: numbers from 1; theta, theta_demo: (m,) rad."""
    is_at, should_be = theta.tolist(), theta_demo.tolist()
    off = [abs(own - demo) for own, demo in zip(is_at, should_be)]
    k = off.index(max(off))
    if off[k] < EXACT:
        return "Correct to within 0.1°."
    where = f"is at {svg.degrees(is_at[k])} but should be at {svg.degrees(should_be[k])}"
    return f"{svg.degrees(off[k])} off: {svg.joint_symbol(joints[k])} {where}."


def describe_outcome(status: ServoStatus, motions: int, theta: Floats, theta_demo: Floats, playing: bool) -> str:
    """Say first, in plain words, what has come of it, as HTML; this uses the truth. theta, theta_demo: (m,) rad."""
    off = float(np.abs(theta - theta_demo).max())
    if status == ServoStatus.READY:
        return "<b>Ready.</b> Press Play: the blue robot copies the pose of the orange one."
    if not status.has_ended:
        words = "<b>Copying:</b>" if playing else "<b>Paused:</b>"
    elif off < COPIED:
        words = "<b>Copied:</b>"
    else:
        words = f"<b>{'Nearly copied' if off < NEARLY else 'Not copied'}:</b> it stopped"
    return f"{words} {svg.degrees(off)} off after {svg.count_motions(motions)}."


def draw_status(message: StatusMessage, truth: str, choices: str = "", outcome: str = "") -> str:
    """Draw the strip as HTML. truth: what the learner does not know; choices, outcome: HTML."""
    words = f"<b>{svg.escape(message.title)}</b> · {svg.escape(with_minus(message.sentence))}"
    if message.doubt:
        words += f" <i>{svg.escape(message.doubt)}</i>"
    known, true = ask(message.word) if message.word else "", svg.escape(truth)
    who = "Page" if message.state in BY_PAGE else "Learner"
    hidden = "hidden from the learner"
    first = f'<div class="vi-outcome vi-tells"><p>{outcome}</p></div>' if outcome else ""
    return (
        f'<div class="vi-strip"><div class="vi-status">{first}<div>{_icon(SHAPES.get(message.state, IDLE))}'
        f'<em>{who}</em><p role="status">{words}{choices}</p>{known}</div>'
        f'<div class="vi-truth">{_icon(BETWEEN)}<em title="{hidden}">Truth</em><p>{true}</p>'
        f"{ask('truth')}</div></div></div>"
    )


def _icon(shape: str) -> str:
    return f'<svg width="22" height="22" viewBox="0 0 22 22" aria-hidden="true">{shape}</svg>'


def _trend(snapshot: Snapshot, previous: Sequence[Snapshot]) -> float | None:
    """Compute the relative change of E per step over the last steps without probes, since the demonstrator moved; None
    without any, and if E is too small to see."""
    recent = [s for s in previous[-TREND:] if not s.probe and s.E >= svg.UNSEEN_E and s.motion < snapshot.motion]
    demo = snapshot.views.demo  # kept with its noise while the demonstrator rests
    recent = [s for s in recent if np.array_equal(s.views.demo, demo, equal_nan=True)]
    if not recent or not snapshot.E >= svg.UNSEEN_E:
        return None
    first = recent[0]
    return (snapshot.E / first.E) ** (1 / (snapshot.motion - first.motion)) - 1


def _says(snapshot: Snapshot, joints: Sequence[int] = ()) -> str:
    """Return the servo's own words, "" without any. joints: numbers from 1."""
    state = snapshot.servo_state
    if snapshot.misfit is not None and snapshot.status.is_at_rest:
        return snapshot.misfit.describe(joints)
    return "" if state is None else snapshot.servo.describe_status(state, snapshot.status)
