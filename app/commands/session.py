"""Commands to the session: play, step, undo, pose the demonstrator, begin with a preset, follow a link."""

from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from viewimit.drawing.export.panels import largest_residual
from viewimit.drawing.glossary import glossary
from viewimit.drawing.svg import count_motions, count_points, escape
from viewimit.loop.settings import Settings, given
from viewimit.simulation.world import pose_for_hand

from ..model.choices import MESSAGE_S, SPEEDS, WARNING_S, Preset, modified, usual
from ..model.editing import Rehearsal
from ..model.link import Played, read_link
from ..model.page_model import PageModel
from ..model.queue import command, number, one_of

FROM_LINK = "From a link"
NOT_RESTORED = "what this tab has kept cannot be restored, so the session begins again"
BODIES = ("scene", "robot", "joints", "body_points")  # settings of which a preset's sentence speaks
SPEED = one_of(SPEEDS, "there is no speed {value}")
UNSAVED = one_of({"": False, "storage": True}, "there is no problem {value}")
Word = Annotated[str, one_of(lambda: glossary().keys(), "the glossary has no entry {value}")]
Angles = Annotated[tuple[float, ...], lambda value: tuple(map(number, value.split(",")))]  # degrees, "25,-45"
Position = Annotated[NDArray, lambda value: np.array(value, float)]  # (3,) m in the world


@command("play", moves=True, order_independent=True)
def play(model: PageModel) -> None:
    """Play, or pause. A duel's opponent first gets what has changed for the learner."""
    if not model.player.playing:
        model.past.push_branch()
        model.duel.follow()
    model.player.toggle()


@command("step", moves=True)
def step(model: PageModel, *, now: float) -> None:
    """Make one motion."""
    model.player.pause()
    model.past.push_branch()
    model.duel.follow()
    model.player.step(now)


def _undo_needs_camera(model: PageModel) -> bool:
    left = model.past.here
    return left is not None and left.shown.settings.sensor == "rendered" != model.session.settings.sensor


@command("undo", moves=True, cancels=True, camera=_undo_needs_camera)
def undo(model: PageModel, *, now: float) -> None:
    """Go one motion back; where a reset, a preset or a start began, back to the former session. A link that is
    being followed is abandoned instead."""
    if model.following.let_go():
        return
    model.player.pause()
    left = model.past.here
    if left is None:
        model.player.scrub(model.player.cursor - 1, now)
    else:
        model.undoable.bring_back(left)
        parts = [left.preset.name, count_motions(left.motions)]
        if model.points.on:
            parts.append(count_points(len(model.session.world.body)))
        model.say(f"Back is what was here before: {', '.join(parts)}.", now + MESSAGE_S)


@command("reset", moves=True)
def reset(model: PageModel) -> None:
    """Go back to the start; an error that the page has met is over."""
    model.undoable.reset()
    model.message = None


@command("rehearsal", moves=True)
def toggle_rehearsal(model: PageModel) -> None:
    """Let the learner watch itself first, or forget what it has seen of itself."""
    if Rehearsal(model.session).held:
        model.undoable.forget_rehearsal()
    else:
        model.undoable.rehearse()


@command("moment", latest=True, moves=True, link=True)
def scrub(model: PageModel, motion: int) -> None:
    """Show the snapshot after this number of motions."""
    model.player.pause()
    model.player.scrub(motion)


@command("speed", latest=True)
def choose_speed(model: PageModel, motions_per_second: Annotated[float, SPEED]) -> None:
    """Choose the speed by its name; 0 is as fast as it computes."""
    model.player.speed = motions_per_second


@command("preset", latest=True, moves=True, camera=lambda model, name: name in model.presets.pictured)
def choose_preset(model: PageModel, name: str) -> None:
    """Begin with a preset of the page's list."""
    if name != modified(model.preset.name):  # which it is already
        offered = {**model.presets.offered, model.preset.name: model.preset}
        model.undoable.begin_preset(one_of(offered, "there is no preset {value}")(name))


@command("pose_joint", latest=True, moves=True)
def pose_joint(model: PageModel, k: int, angle_deg: float) -> None:
    """Turn one of the demonstrator's joints, counted among those that move."""
    theta = model.session.snapshot.theta_demo.copy()
    if k < len(theta):  # a slider of the scene before may still have sent
        theta[k] = np.radians(angle_deg)
        model.undoable.pose(theta)


@command("pose_hand", latest=True, moves=True)
def pose_hand(model: PageModel, position: Position) -> None:
    """Bring the demonstrator's hand to a place, as near as its joints can."""
    model.undoable.pose(pose_for_hand(model.session.world, position, model.session.snapshot.theta_demo))


@command("start_joint", latest=True, moves=True)
def start_joint(model: PageModel, k: int, angle_deg: float) -> None:
    """Turn one joint of the learner's start, counted among those that move."""
    start = list(given(model.session.settings.start_deg))
    if k < len(start):  # a slider of the scene before may still have sent
        start[k] = angle_deg
        model.undoable.start_at(tuple(start))


@command("posture", moves=True, link=True)
def choose_posture(model: PageModel, angles_deg: Angles) -> None:
    """Take a posture of the landscape: the learner starts there, or a see-through arm shows it."""
    if not model.view.look_only:
        model.undoable.start_at(angles_deg)
    else:
        model.player.pause()
        model.display.preview.look(np.radians(angles_deg))


@command("start", moves=True, link=True)
def start_there(model: PageModel) -> None:
    """Start where the see-through arm is."""
    moment = model.display.preview.moment
    if moment is None:
        raise ValueError("there is no ghost arm to start from")
    model.undoable.start_at(tuple(np.degrees(moment.theta).tolist()))


@command("show", moves=True, link=True)
def show_word(model: PageModel, key: Word) -> None:
    """Begin with the settings in which an entry of the glossary is seen; at once where that takes motions."""
    entry = glossary()[key]
    speed = 0.0 if entry.plays else model.player.speed
    lesson = escape(f"{entry.symbol}, {entry.name}{': where it is bad' if entry.bad else ''}.")
    model.undoable.begin_preset(Preset(f"Show me: {entry.symbol}", entry.show, speed, lesson))
    model.show(help=False)
    if entry.plays:
        play(model)


@command("link", latest=True, moves=True, link=True)
def follow_link(model: PageModel, address: str) -> None:
    """Become what a link holds. Its motions are computed beside the page, as that may take seconds."""
    model.following.begin(read_link(address, model.begun), partial(become, model))


@command("session", latest=True, link=True)
def restore_session(model: PageModel, kept: str) -> None:
    """Become what the tab has kept; an empty text of a new tab."""
    if model.is_kept:
        return
    model.is_kept = True
    if kept:
        try:
            page = read_link(kept, model.begun)
        except ValueError as error:
            raise ValueError(f"{NOT_RESTORED}: {error}") from None
        model.following.begin(page, partial(become, model), is_own=True)


@command("unsaved", latest=True, link=True)
def tell_unsaved(model: PageModel, unsaved: Annotated[bool, UNSAVED]) -> None:
    """Take whether the tab's storage is full or forbidden."""
    model.unsaved = unsaved


def become(model: PageModel, played: Played, now: float) -> None:
    """Show on a page what a link gave; Undo goes back to before it. Raises ValueError if it could not be played."""
    page = played.page
    if played.error is not None or not played.sessions:
        why = str(played.error) or type(played.error).__name__
        if not played.is_own:
            raise ValueError(f"the link cannot be followed: {why}")
        _begin_with_settings_alone(model, page.last_settings, why, now)
        return
    model.player.pause()
    with nullcontext() if played.is_own else model.past.recording_undo(whole=True):
        first = played.sessions[0]
        model.session.resume(tuple(first.history), first.cursor, first.log)
    if played.is_own:
        model.past.clear()
    begun = page.script.settings
    same = next((one for one in (page.preset, *model.presets.offered.values()) if usual(one) == begun), None)
    model.presets.chosen = same or page.preset
    if same is None and any(getattr(begun, name) != getattr(usual(page.preset), name) for name in BODIES):
        model.presets.chosen = Preset(FROM_LINK, begun, page.speed, "As it was sent.")
    model.player.speed = page.speed
    model.tour_offered = model.tour_offered and page.offers_tour
    dark = model.view.dark if page.dark is None else page.dark
    chosen = largest_residual(model.session.snapshot) if page.chosen == -1 else page.chosen
    model.view = replace(model.view, chosen=chosen, dark=dark, **page.show)
    model.undoable.after_restart()
    for opponent in played.sessions[1:]:
        model.duel.resume(opponent)
    if page.motion is not None:
        try:
            model.motions.load(page.motion)
        except ValueError as error:
            model.say(f"The recorded motion is not back: {error}.", now + WARNING_S)


def _begin_with_settings_alone(model: PageModel, settings: Settings, why: str, now: float) -> None:
    """Begin without the steps of the tab's session, and without camera images, which may be in use by others."""
    try:
        model.undoable.begin_like(settings)
    except ValueError:
        raise ValueError(f"{NOT_RESTORED}: {why}") from None
    model.undoable.after_restart()
    model.say(f"Only the settings of this tab's session are back: {why}.", now + WARNING_S)
