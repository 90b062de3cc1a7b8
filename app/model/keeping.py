"""What a tab keeps of its page: made from a page, and made a page again."""

import math
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from weakref import WeakKeyDictionary

import msgspec
import numpy as np

from viewimit.drawing.export.panels import largest_residual
from viewimit.loop.embodiment import to_degrees
from viewimit.loop.session import Session

from ..sessions.link import MAX_MOTION, MAX_TEXT, Branch, Run, SavedPage, described, encode_blocks
from .choices import AS_STARTED, SWITCHES, Preset, switched
from .editing import UndoEntry
from .following import Played
from .page_model import PageModel
from .services import Redraw

MESSAGE_STAYS = 30.0  # s
FROM_LINK = "From a link"


def saved_page(model: PageModel, branches: WeakKeyDictionary[UndoEntry, Branch | None] | None = None) -> SavedPage:
    """Return a page as its tab stores it. branches: those encoded before.

    It leaves out a recorded motion that is too long, and runs that no script can hold: `incomplete` says so.
    """
    view, snapshot = model.view, model.session.snapshot
    incomplete: list[str] = []
    branches = WeakKeyDictionary() if branches is None else branches
    past: list[Branch] = []
    for entry in reversed(model.past.everything):
        if entry not in branches:
            branches[entry] = _branch(entry, incomplete)
        branch = branches[entry]
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


def _branch(entry: UndoEntry, incomplete: list[str]) -> Branch | None:
    """A branch with its scripts, None where its own is not known."""
    runs = []
    for snapshots, cursor, log in entry.runs:
        try:
            runs.append(Run(script=log.script(snapshots[-1].motion), cursor=cursor))
        except ValueError as error:
            if not runs:
                incomplete.append(f"its steps are not kept: {error}")
                return None
            incomplete.append("the duel's opponent is not kept")
    return Branch(runs=tuple(runs), at=entry.at, preset=entry.preset.name, speed=entry.speed)


def become(model: PageModel, played: Played, now: float) -> None:
    """Restore a page from a played script, and say if anything is missing. Undo goes back to the page before a link.

    Raises ValueError, and changes nothing, for a link that cannot be followed.
    """
    page = played.page
    whole = len(played.branches) == len(page.past) + 1
    sessions = played.branches[0][1] if played.branches and played.branches[0][0] is page.present else []
    why = "" if played.error is None else str(played.error) or type(played.error).__name__
    complaints = [page.incomplete] if page.incomplete else []
    if not sessions and not page.commanded:
        raise ValueError(f"the link cannot be followed: {why}")
    model.player.pause()
    with nullcontext() if played.is_own else model.past.recording_undo(whole=True):
        try:
            if sessions:
                _resume(model.session, sessions[0])
        except ValueError as error:  # camera images that are in use by others
            sessions, why = [], str(error)
        if not sessions:
            _restart(model, page)
            text = "only its posture and settings are here: {why}" if why else "only its posture and settings are here"
            complaints.append(text.format(why=why))
        elif not whole:
            complaints.append(f"what Undo would go back to is not all here: {why}")
    if played.is_own:
        model.past.replace(())
    if sessions:
        before = [_undo_entry(model, *branch) for branch in reversed(played.branches[1:])]
        model.past.replace((*model.past.everything, *before))
        if page.commanded and page.commanded != tuple(model.session.snapshot.commanded.tolist()):
            off = np.abs(model.session.snapshot.commanded - page.commanded).max()
            text = "computed again here, the arm is {angle:.2g}° from where it was"
            complaints.append(text.format(angle=np.degrees(off)))
    _show(model, page, played.is_own)
    model.undoable.after_restart()
    for opponent in sessions[1:]:
        model.duel.resume(opponent)
    if page.motion is not None:
        try:
            model.motions.load(page.motion)
        except ValueError as error:
            complaints.append(str(error))
    model.resends_all = played.is_own and not complaints  # else the tab keeps its larger text until a change
    if complaints:
        text = "Not all of this session is back: {complaints}."
        model.say(text.format(complaints="; ".join(complaints)), now + MESSAGE_STAYS)


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


def _undo_entry(model: PageModel, branch: Branch, sessions: list[Session]) -> UndoEntry:
    """The state that Undo restores."""
    runs = tuple((tuple(session.history), session.cursor, session.log) for session in sessions)
    return UndoEntry(runs, branch.at, _preset(model, branch, branch.preset), branch.speed)


def _preset(model: PageModel, branch: Branch, unknown: str) -> Preset:
    """The preset of a branch. unknown: the name of one that this page does not offer."""
    settings = branch.runs[0].script.settings if branch.runs else model.session.settings
    other = Preset(unknown, settings, branch.speed, "As it was sent.")
    return model.presets.offered.get(branch.preset, other)


def _show(model: PageModel, page: SavedPage, is_own: bool) -> None:
    """Take over the preset, speed, view and tour."""
    present = page.present
    model.presets.chosen = _preset(model, present, present.preset if is_own else FROM_LINK)
    if present.preset == AS_STARTED and model.modified and not is_own:  # another server was started otherwise
        model.presets.chosen = _preset(model, msgspec.structs.replace(present, preset=""), FROM_LINK)
    model.player.speed = present.speed
    model.tour_offered = model.tour_offered and page.offers_tour
    dark = model.view.dark if page.dark is None else page.dark
    chosen = largest_residual(model.session.snapshot) if page.chosen == -1 else page.chosen
    view = replace(switched(model.view, page.show), chosen=chosen, dark=dark)
    if view != model.view:
        model.view = view


# Sends the parts of what a page's tab keeps.

SEND_EVERY = 1.0  # s, on average
AT_ONCE = 4  # parts after a pause, so that who clicks and reloads has lost nothing


class Part(msgspec.Struct):
    """News for the tab. number: counted from 1 on each connection; at: the blocks from here on are these, -1 for no
    change; acted: the number of the last action that is in them."""

    number: int
    at: int
    blocks: list[str]
    acted: int


class Keeper:
    """Sends to a page's tab the text that it stores, after the tab has sent its stored text.

    Parameters
    ----------
    model
        Of the page.
    send
        Sends a part, as JSON.
    """

    def __init__(self, model: PageModel, send: Callable[[str], None]):
        self._model, self._send = model, send
        self._redraw, self._number = Redraw(), 0
        self._parts, self._last = float(AT_ONCE), -math.inf  # that may be sent; s, of the last tick
        self._redraw.changed("state", self._state())  # as the page was built: it needs no storing
        self._has_restored = self._has_changed = self._has_acted = False
        self._sent: list[str] = []
        self._branches: WeakKeyDictionary[UndoEntry, Branch | None] = WeakKeyDictionary()
        self._described: dict[str, str] = {}

    def tick(self, now: float, acted: int) -> None:
        """Send what has changed. acted: number of the last action that was applied."""
        model = self._model
        self._has_restored |= model.following.restores
        if not model.is_kept or model.following.restores:
            return
        has_changed = self._redraw.changed("state", self._state())
        self._has_changed |= has_changed and not self._has_restored  # the tab stores the restored state already
        self._has_acted |= self._redraw.changed("acted", (acted,))
        self._has_restored = False
        if model.resends_all:
            self._sent, self._has_changed, model.resends_all = [], True, False
        self._parts = min(self._parts + (now - self._last) / SEND_EVERY, float(AT_ONCE))
        self._last = now
        if self._parts >= (1 if self._has_changed else AT_ONCE) and (self._has_changed or self._has_acted):
            self._parts -= 1
            self._send_part(acted)

    def _state(self) -> tuple:
        """The values whose change the tab stores."""
        model = self._model
        session, view, opponent = model.session, model.view, model.duel.opponent
        return (
            session.snapshot, len(session.history), model.past.everything, model.preset, model.player.speed,
            *(getattr(view, name) for name in ("chosen", "dark", *SWITCHES)), model.tour_offered, model.motions.file,
            None if opponent is None else opponent.snapshot,
        )  # fmt: skip

    def _send_part(self, acted: int) -> None:
        self._number += 1
        part = Part(self._number, -1, [], acted)
        if self._has_changed:
            blocks = self._blocks()
            same = [one == other for one, other in zip(self._sent, blocks)]
            part.at = same.index(False) if False in same else len(same)
            part.blocks, self._sent = blocks[part.at :], blocks
        self._has_changed = self._has_acted = False
        self._send(msgspec.json.encode(part).decode())

    def _blocks(self) -> list[str]:
        """Those of the page, or of as much of it as a tab keeps."""
        page = self._page()
        blocks = encode_blocks(page)
        while len(".".join(blocks)) > MAX_TEXT and (page.past or page.motion is not None or page.present.runs):
            page = _less(page)
            blocks = encode_blocks(page)
        return blocks

    def _page(self) -> SavedPage:
        return saved_page(self._model, self._branches).renamed(self._describe)

    def _describe(self, place: str) -> str:
        if place not in self._described:
            self._described[place] = described(place)
        return self._described[place]


def _less(page: SavedPage) -> SavedPage:
    """A page with less to keep."""
    if page.past:
        why = "what Undo goes back to is too long to be kept"
        return msgspec.structs.replace(page, past=page.past[1:], incomplete=why)
    if page.motion is not None:
        why = "the recorded motion is too long to be kept"
        return msgspec.structs.replace(page, motion=None, incomplete=why)
    present = msgspec.structs.replace(page.present, runs=())
    return msgspec.structs.replace(page, present=present, incomplete="its steps are too many to be kept")
