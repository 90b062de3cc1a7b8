"""What a tab keeps of its page: made from a page, and made a page again."""

from contextlib import nullcontext
from dataclasses import replace
from weakref import WeakKeyDictionary

import msgspec
import numpy as np

from viewimit.loop.embodiment import to_degrees
from viewimit.loop.session import Session

from ..sessions.link import MAX_MOTION, Branch, Run, SavedPage
from .following import Played
from .page_model import PageModel
from .past import Left
from .presets import AS_STARTED, Preset
from .view import SWITCHES, switched

MESSAGE_STAYS = 30.0  # s


def saved_page(model: PageModel, branches: WeakKeyDictionary[Left, Branch | None] | None = None) -> SavedPage:
    """What is kept of a page. branches: those that were made before.

    A recorded motion that is too long is not kept, nor what no script can hold: `incomplete` says so.
    """
    view, snapshot = model.view, model.session.snapshot
    incomplete: list[str] = []
    branches = WeakKeyDictionary() if branches is None else branches
    past: list[Branch] = []
    for left in reversed(model.past.everything):
        if left not in branches:
            branches[left] = _branch(left, incomplete)
        branch = branches[left]
        if branch is None:
            break
        past.append(branch)
    present = _branch(model.past.present, incomplete)
    motion = model.motions.file
    if motion is not None and len(motion) > MAX_MOTION:
        motion = None
        incomplete.append("the recorded motion is too long to be kept: save it to a file")
    return SavedPage(
        present=present or Branch(preset=model.preset.name, speed=model.player.speed),
        past=tuple(reversed(past)) if present is not None else (),
        settings=snapshot.settings,
        commanded=tuple(snapshot.commanded.tolist()),
        chosen=view.chosen,
        show={name: on for name in SWITCHES if isinstance(on := getattr(view, name), bool)},
        dark=view.dark,
        offers_tour=model.tour_offered,
        motion=motion,
        incomplete="; ".join(incomplete)[:300],
    )


def _branch(left: Left, incomplete: list[str]) -> Branch | None:
    """A branch with its scripts, None where its own is not known."""
    runs = []
    for moments, cursor, log in left.runs:
        try:
            runs.append(Run(script=log.script(moments[-1].motion), cursor=cursor))
        except ValueError as error:
            if not runs:
                incomplete.append(f"its motions are not kept: {error}")
                return None
            incomplete.append("the duel's opponent is not kept")
    return Branch(runs=tuple(runs), at=left.at, preset=left.preset.name, speed=left.speed)


def become(model: PageModel, played: Played, now: float) -> None:
    """Make a page what was played, and say what of it could not be. Undo goes back to what was there before a link.

    Raises ValueError, with all as it is, for a link that cannot be followed.
    """
    page = played.page
    whole = len(played.branches) == len(page.past) + 1
    sessions = played.branches[0][1] if played.branches and played.branches[0][0] is page.present else []
    why = "" if played.error is None else str(played.error) or type(played.error).__name__
    complaints = [page.incomplete] if page.incomplete else []
    if not sessions and not page.commanded:
        raise ValueError(f"the link cannot be followed: {why}")
    model.player.pause()
    with nullcontext() if played.is_own else model.past.kept(whole=True):
        try:
            if sessions:
                _resume(model.session, sessions[0])
        except ValueError as error:  # camera images that are in use by others
            sessions, why = [], str(error)
        if not sessions:
            _restart(model, page)
            complaints.append(f"only its posture and settings are here{why and ': '}{why}")
        elif not whole:
            complaints.append(f"what Undo would go back to is not all here: {why}")
    if played.is_own:
        model.past.go_back_to(())
    if sessions:
        before = [_left(model, *branch) for branch in reversed(played.branches[1:])]
        model.past.go_back_to((*model.past.everything, *before))
        if page.commanded and page.commanded != tuple(model.session.snapshot.commanded.tolist()):
            off = np.abs(model.session.snapshot.commanded - page.commanded).max()
            complaints.append(f"computed again here, the arm is {np.degrees(off):.2g}° from where it was")
    _show(model, page, played.is_own)
    model.undoable.begin_anew()
    for opponent in sessions[1:]:
        model.duel.resume(opponent)
    if page.motion is not None:
        try:
            model.motions.load(page.motion)
        except ValueError as error:
            complaints.append(str(error))
    model.resends_all = played.is_own and not complaints  # else the tab keeps what is more than this, until a change
    if complaints:
        model.say(f"Not all of this session is back: {'; '.join(complaints)}.", now + MESSAGE_STAYS)


def _resume(session: Session, other: Session) -> None:
    session.resume(tuple(other.history), other.cursor, other.log)


def _restart(model: PageModel, page: SavedPage) -> None:
    """Begin at the saved posture with the saved settings; with projected points where there are no camera images."""
    settings = msgspec.structs.replace(page.settings, start_deg=to_degrees(np.array(page.commanded)))
    try:
        model.session.begin(settings)
    except ValueError:
        if settings.sensor == "projected":
            raise
        model.session.begin(msgspec.structs.replace(settings, sensor="projected"))


def _left(model: PageModel, branch: Branch, sessions: list[Session]) -> Left:
    """What Undo goes back to."""
    runs = tuple((tuple(session.history), session.cursor, session.log) for session in sessions)
    return Left(runs, branch.at, _preset(model, branch, branch.preset), branch.speed)


def _preset(model: PageModel, branch: Branch, unknown: str) -> Preset:
    """The preset of a branch. unknown: the name of one that this page does not offer."""
    settings = branch.runs[0].script.settings if branch.runs else model.session.settings
    other = Preset(unknown, settings, branch.speed, "As it was sent.")
    return model.presets.offered.get(branch.preset, other)


def _show(model: PageModel, page: SavedPage, is_own: bool) -> None:
    """Take what is no part of the session."""
    present = page.present
    model.presets.chosen = _preset(model, present, present.preset if is_own else "From a link")
    if present.preset == AS_STARTED and model.modified and not is_own:  # another server was started otherwise
        model.presets.chosen = _preset(model, msgspec.structs.replace(present, preset=""), "From a link")
    model.player.speed = present.speed
    model.tour_offered = model.tour_offered and page.offers_tour
    dark = model.view.dark if page.dark is None else page.dark
    view = replace(switched(model.view, page.show), chosen=page.chosen, dark=dark)
    if view != model.view:
        model.view = view
