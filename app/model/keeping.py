"""A page written as a query, for others and for its own tab; a page made of what was played; and what its tab keeps."""

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace

import msgspec

from viewimit.analysis.trajectory import encode_motion
from viewimit.drawing.export.panels import largest_residual
from viewimit.loop import link
from viewimit.loop.embodiment import to_degrees
from viewimit.loop.script import Script
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

from .choices import SWITCHES, Preset, View
from .link import VERSUS, Played, described, nearest, usual
from .page_model import PageModel, Redraw

MAX_READABLE = 6_000  # characters of a query, above which its script is packed
FOR_PAGE = 200  # characters that the page's own fields may take
MESSAGE_STAYS = 30.0  # s
FROM_LINK = "From a link"
BODIES = ("scene", "robot", "joints", "body_points")  # settings of which a preset's sentence speaks


def share_link(model: PageModel, hides: bool = False) -> str:
    """Return the query that opens what a page shows. hides: no posture can be read in it. Raises ValueError."""
    script = model.session.script.renamed(described)
    opponent = model.duel.opponent
    other = None if opponent is None else opponent.script.renamed(described)
    return link.joined(_pairs(model, script, other, hides) + _view_pairs(model))


def tab_link(model: PageModel) -> tuple[str, str]:
    """Return the query that a page's tab keeps, and why it does not hold all of the page; "" if it does."""
    session, why, extra = model.session, "", list[tuple[str, str]]()
    try:
        script = session.log.script(session.history[-1].motion).renamed(described)
    except ValueError as error:
        script, why = _posture_alone(session), str(error)
    opponent = model.duel.opponent
    try:
        other = None if opponent is None or why else opponent.log.script(opponent.history[-1].motion).renamed(described)
    except ValueError:
        other = None
    if model.view.dark is not None:
        extra.append(("dark", str(int(model.view.dark))))
    if not model.tour_offered:
        extra.append(("tour", "0"))
    if session.cursor < len(session.history) - 1 and not why:
        extra.append(("at", str(session.cursor)))
    extra += _view_pairs(model)
    recorded = model.motions.recorded
    motion_file = None if recorded is None else encode_motion(recorded)
    for motion, one, versus in ((motion_file, script, other), (None, script, other), (None, script, None)):
        try:
            return link.joined(_pairs(model, one, versus, motion=motion) + extra), why
        except ValueError as error:
            why = why or str(error)
    return link.joined(_pairs(model, _posture_alone(session), None) + extra), why


def _pairs(
    model: PageModel, script: Script, opponent: Script | None, hides: bool = False, motion: bytes | None = None
) -> list[tuple[str, str]]:
    """The fields of the preset and of the scripts. Raises ValueError if they are too long."""
    preset = model.preset if model.preset.key else nearest(script.settings)
    base = usual(preset)
    pairs = [("preset", preset.key), *_said(script, base, hides, motion)]
    if opponent is not None:
        pairs.append((VERSUS, link.joined(_said(opponent, base, hides))))
    if len(link.joined(pairs)) > link.MAX_LINK - FOR_PAGE:
        raise ValueError(f"too much was done for a link of {link.MAX_LINK} characters. Save a replay instead")
    return pairs


def _said(script: Script, base: Settings, hides: bool, motion: bytes | None = None) -> list[tuple[str, str]]:
    try:
        pairs = link.said(script, base)
        if not hides and motion is None and len(link.joined(pairs)) <= MAX_READABLE:
            link.understood(pairs, base)  # within the bounds of what is read
            return pairs
    except ValueError:
        pass
    return [(link.PACKED, link.packed(script, motion))]


def _view_pairs(model: PageModel) -> list[tuple[str, str]]:
    """The fields of what a page shows beside its session."""
    view, preset, pairs = model.view, model.preset, list[tuple[str, str]]()
    if model.player.speed != preset.motions_per_second or not preset.key:
        pairs.append(("speed", f"{model.player.speed:g}"))
    if view.chosen != largest_residual(model.session.snapshot):
        pairs.append(("point", "none" if view.chosen is None else str(view.chosen)))
    usual = View()
    return pairs + [(name, str(int(on))) for name in SWITCHES if (on := getattr(view, name)) != getattr(usual, name)]


def _posture_alone(session: Session) -> Script:
    """The script of a session that begins where this one is."""
    now = session.snapshot
    start, demo = to_degrees(now.commanded), to_degrees(now.theta_demo)
    return Script(msgspec.structs.replace(now.settings, start_deg=start, demonstrator_deg=demo)).renamed(described)


def become(model: PageModel, played: Played, now: float) -> None:
    """Make a page what was played. Undo goes back to the page before a link.

    Raises ValueError, and changes nothing, if it could not be played.
    """
    page = played.page
    if played.error is not None or not played.sessions:
        why = str(played.error) or type(played.error).__name__
        if not played.is_own:
            raise ValueError(f"the link cannot be followed: {why}")
        try:  # without its steps, and without camera images, which may be in use by others
            model.undoable.begin_like(page.last_settings)
        except ValueError:
            raise ValueError(f"what this tab has kept cannot be restored, so the session begins again: {why}") from None
        model.undoable.after_restart()
        model.say(f"Only the settings of this tab's session are back: {why}.", now + MESSAGE_STAYS)
        return
    model.player.pause()
    with nullcontext() if played.is_own else model.past.recording_undo(whole=True):
        first = played.sessions[0]
        model.session.resume(tuple(first.history), first.cursor, first.log)
    if played.is_own:
        model.past.clear()
    begun = page.script.settings
    same = [preset for preset in (page.preset, *model.presets.offered.values()) if usual(preset) == begun]
    model.presets.chosen = same[0] if same else page.preset
    if any(getattr(begun, name) != getattr(usual(page.preset), name) for name in BODIES) and not same:
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
            model.say(f"The recorded motion is not back: {error}.", now + MESSAGE_STAYS)


SEND_EVERY = 1.0  # s, on average
AT_ONCE = 4  # texts after a pause, so that who clicks and reloads has lost nothing


class Kept(msgspec.Struct):
    """What a tab is sent. text: its page's query; acted: the number of the last action that is in it."""

    text: str
    acted: int


class Keeper:
    """Sends a page's tab the query that it stores, after the tab has handed back the one that it had.

    send: takes `Kept` as JSON.
    """

    def __init__(self, model: PageModel, send: Callable[[str], None]):
        self._model, self._send = model, send
        self._redraw, self._allowed, self._last = Redraw(), float(AT_ONCE), 0.0
        self._redraw.changed("state", self._state())  # as the page was built: it needs no storing
        self._has_changed = self._has_acted = False
        self._text, self._why = "", ""

    def tick(self, now: float, acted: int) -> None:
        """Send what has changed. acted: number of the last action that was applied."""
        model = self._model
        if not model.is_kept or model.following.restores:
            return
        self._has_changed |= self._redraw.changed("state", self._state())
        self._has_acted |= self._redraw.changed("acted", (acted,))
        self._allowed = min(self._allowed + (now - self._last) / SEND_EVERY, float(AT_ONCE))
        self._last = now
        if self._allowed < (1 if self._has_changed else AT_ONCE) or not (self._has_changed or self._has_acted):
            return
        self._allowed -= 1
        if self._has_changed:
            self._text, why = tab_link(model)
            if why and why != self._why:
                model.say(f"A reload would not bring all of this back: {why}.", now + MESSAGE_STAYS)
            self._why = why
        self._has_changed = self._has_acted = False
        self._send(msgspec.json.encode(Kept(self._text, acted)).decode())

    def _state(self) -> tuple:
        """The values whose change the tab stores."""
        model = self._model
        session, view, opponent = model.session, model.view, model.duel.opponent
        return (
            session.snapshot, len(session.history), model.preset, model.player.speed,
            *(getattr(view, name) for name in ("chosen", "dark", *SWITCHES)), model.tour_offered,
            model.motions.recorded, None if opponent is None else opponent.snapshot,
        )  # fmt: skip
