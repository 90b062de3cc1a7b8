"""Sends the parts of what a page's tab keeps."""

import math
from collections.abc import Callable
from weakref import WeakKeyDictionary

import msgspec

from ..model.keeping import saved_page
from ..model.page_model import PageModel
from ..model.past import Left
from ..model.view import SWITCHES
from ..sessions.link import MAX_TEXT, Branch, SavedPage, described, encode_blocks
from .redraw import Redraw

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
    """Sends to a page's tab what it is to keep, after the tab has told what it has kept.

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
        self._begun = self._has_changed = self._has_acted = False
        self._sent: list[str] = []
        self._branches: WeakKeyDictionary[Left, Branch | None] = WeakKeyDictionary()
        self._described: dict[str, str] = {}

    def tick(self, now: float, acted: int) -> None:
        """Send what has changed. acted: number of the last action that was carried out."""
        model = self._model
        if not model.is_kept or model.following.restores:
            return
        has_changed = self._redraw.changed("state", self._state())
        self._has_changed |= has_changed and self._begun  # the tab has what was there at first, or needs it not
        self._has_acted |= self._redraw.changed("acted", (acted,))
        self._begun = True
        if model.resends_all:
            self._sent, self._has_changed, model.resends_all = [], True, False
        self._parts = min(self._parts + (now - self._last) / SEND_EVERY, float(AT_ONCE))
        self._last = now
        if self._parts >= (1 if self._has_changed else AT_ONCE) and (self._has_changed or self._has_acted):
            self._parts -= 1
            self._send_part(acted)

    def _state(self) -> tuple:
        """What is kept, as far as a change of it is seen."""
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
        return msgspec.structs.replace(page, motion=None, incomplete="the recorded motion is too long to be kept")
    present = msgspec.structs.replace(page.present, runs=())
    return msgspec.structs.replace(page, present=present, incomplete="its motions are too many to be kept")
