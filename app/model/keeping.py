"""A page written as a query, for others, for its own tab and for the lab; and what its tab keeps."""

from collections.abc import Callable, Iterable
from contextlib import suppress
from urllib.parse import urlencode

import msgspec
import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.trajectory import encode_motion
from viewimit.drawing.export.panels import largest_residual
from viewimit.loop import link
from viewimit.loop.arm_and_eyes import to_degrees
from viewimit.loop.script import Script
from viewimit.loop.session import Session
from viewimit.loop.settings import DISTURBANCES, Settings
from viewimit.loop.snapshot import Snapshot

from ..lab.recording import lab_methods, lacks
from ..presets import LAB_PRESETS
from .choices import PRESETS, SWITCHES, WARNING_S, Preset, View, place_in_link, usual
from .link import VERSUS
from .page_model import PageModel, Redraw

MAX_READABLE = 6_000  # characters of a query, above which its script is packed
FOR_PAGE = 200  # characters that the page's own fields may take


def share_link(model: PageModel, hides: bool = False) -> str:
    """Return the query that opens what a page shows. hides: no posture can be read in it. Raises ValueError."""
    script = model.session.script.renamed(place_in_link)
    opponent = model.duel.opponent
    other = None if opponent is None else opponent.script.renamed(place_in_link)
    return link.joined(_pairs(model, script, other, hides) + _view_pairs(model))


def tab_link(model: PageModel) -> tuple[str, str]:
    """Return the query that a page's tab keeps, and why it does not hold all of the page; "" if it does."""
    session, why, extra = model.session, "", list[tuple[str, str]]()
    try:
        script = session.log.script(session.history[-1].motion).renamed(place_in_link)
    except ValueError as error:
        script, why = _posture_alone(session), str(error)
    opponent, other = model.duel.opponent, None
    if opponent is not None and not why:
        with suppress(ValueError):
            other = opponent.log.script(opponent.history[-1].motion).renamed(place_in_link)
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
    preset = model.preset if model.preset.key else _nearest(script.settings)
    base = usual(preset)
    pairs = [("preset", preset.key), *_said(script, base, hides, motion)]
    if opponent is not None:
        pairs.append((VERSUS, link.joined(_said(opponent, base, hides))))
    if len(link.joined(pairs)) > link.MAX_LINK - FOR_PAGE:
        raise ValueError(f"too much was done for a link of {link.MAX_LINK} characters. Save a replay instead")
    return pairs


def _nearest(settings: Settings) -> Preset:
    """Return the preset with a key from which settings differ least."""
    differing = lambda preset: _differing(Settings.__struct_fields__, usual(preset), settings)
    return min((preset for preset in PRESETS if preset.settings.sensor == settings.sensor), key=differing)


def _differing(fields: Iterable[str], one: Settings, other: Settings) -> int:
    return sum(getattr(one, name) != getattr(other, name) for name in fields)


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
    others = [name for name in SWITCHES if getattr(view, name) != getattr(View(), name)]
    return pairs + [(name, str(int(getattr(view, name)))) for name in others]


def _posture_alone(session: Session) -> Script:
    """The script of a session that begins where this one is."""
    now = session.snapshot
    start, demo = to_degrees(now.commanded), to_degrees(now.theta_demo)
    return Script(msgspec.structs.replace(now.settings, start_deg=start, demonstrator_deg=demo)).renamed(place_in_link)


SEND_EVERY = 1.0  # s, on average
AT_ONCE = 4  # texts after a pause, so that who clicks and reloads has lost nothing


class Kept(msgspec.Struct):
    """What a tab is sent. text: its page's query; acted: the number of the last action that is in it."""

    text: str
    acted: int


class Keeper:
    """Sends a page's tab the query that it stores, after the tab has handed back the one that it had. send: takes
    `Kept` as JSON."""

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
                model.say(f"A reload would not bring all of this back: {why}.", now + WARNING_S)
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


# The address at which the lab opens in a session's state, as app/lab/view/address.js reads it.

FIELDS_OF_LINK = {  # fields that the address carries, or that are told by what they do
    "scene", "robot", "joints", "body_points", "points", "demonstrator_deg", "start_deg", "transfer", "servo",
    "noise_px", "missing", "seed", "rectify", "sensor",
}  # fmt: skip
DIGITS = 2  # of an angle in degrees


def lab_address(now: Snapshot) -> str | None:
    """Return the lab's path and fragment for a moment; None for a scene that the lab does not have. A servo or a
    transfer that the lab does not have is left to its default there; `lab_lacks` says so."""
    settings, found, methods = now.settings, _presets_of(now), lab_methods()
    if not found or _own_bodies(now) or settings.sensor != "projected":
        return None
    fields = {
        "preset": found[0].key,
        "demo": _degrees(now.theta_demo),
        "start": _degrees(now.theta),
        "servo": settings.servo if settings.servo in methods.servos else None,
        "transfer": settings.transfer if settings.transfer in methods.transfers else None,
        "points": settings.points,
        "noise": settings.noise_px,
        "missing": settings.missing,
        "seed": settings.seed,
    }
    return "/lab#" + urlencode({name: value for name, value in fields.items() if value is not None}, safe=",")


def lab_lacks(now: Snapshot) -> list[str]:
    """Say what of a moment the lab's address cannot carry, each in a few words."""
    scene = [] if _presets_of(now) else ["this scene"]
    paper = Settings.paper()
    fields = (name for name in paper.__struct_fields__ if name not in FIELDS_OF_LINK and name not in DISTURBANCES)
    other = [name.replace("_", " ") for name in fields if getattr(now.settings, name) != getattr(paper, name)]
    lacking = lacks(now.settings, now.method.title, now.servo.title, now.rectification is not None)
    return [*scene, *_own_bodies(now), *lacking, *other]


def _presets_of(now: Snapshot) -> list[Preset]:
    """The lab's presets of a moment's scene, the one of the most equal settings first."""
    there = [preset for preset in LAB_PRESETS if preset.settings.scene == now.settings.scene]
    fields = ("transfer", "servo", "points", "noise_px", "missing")
    return sorted(there, key=lambda one: _differing(fields, one.settings, now.settings))


def _own_bodies(now: Snapshot) -> list[str]:
    own = {"robot": "this robot", "joints": "these joints", "body_points": "these points"}
    return [words for field, words in own.items() if getattr(now.settings, field) is not None]


def _degrees(theta: NDArray[np.float64]) -> str:
    return ",".join(f"{angle:g}" for angle in np.degrees(theta).round(DIGITS))
