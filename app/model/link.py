"""A page as a link or its own tab holds it: one query, which the library reads from left to right as a script. Fields
of the page itself stand beside the script's: the preset, the motion shown, speed, chosen point and switches; in a duel
the opponent's own query; and for the tab alone, the colours and whether the tour was dismissed."""

import math
import time
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import msgspec
import numpy as np

from viewimit.loop import link
from viewimit.loop.arm_and_eyes import to_degrees
from viewimit.loop.history import MAX_HISTORY
from viewimit.loop.script import Begin, ChangeSettings, MoveDemonstrator, Script
from viewimit.loop.session import Session
from viewimit.loop.settings import OWN, Settings, convert_fields
from viewimit.sensing.files import file_name, is_text
from viewimit.simulation.robot import robot_names
from viewimit.simulation.scene import scene_names

from ..jobs.camera_images import CameraProcess, eyes_beside
from . import choices
from .player import DENSE
from .queue import UNFINISHED, CommandQueue
from .services import Services

MAX_FRAMES = 100  # images averaged in each observation
MAX_SCENES = 16  # described in full
BOUNDED = {"scene", "robot", "transfer", "servo", "body_points", "frames", "sensor"}  # settings, by `require_allowed`
SPEEDS_BY_NAME = {f"{speed:g}": speed for speed in choices.SPEEDS.values()}
T = TypeVar("T")
VERSUS = "versus"  # the opponent's query
OF_PAGE = ("preset", link.PACKED, "at", "speed", "point", VERSUS, "dark", "tour", *choices.SWITCHES)
EARLIER = "s"  # field of links of version 0.2


class Linked(msgspec.Struct, frozen=True, kw_only=True):
    """What a link, or a tab, holds of a page."""

    script: Script
    preset: choices.Preset
    speed: float
    opponent: Script | None = None  # of a duel
    at: int = MAX_HISTORY  # the motion shown
    chosen: int | None = -1  # a point; -1: the one with the largest residual
    show: dict[str, Any] = {}  # switches of the page
    dark: bool | None = None
    offers_tour: bool = True
    motion: bytes | None = None  # a recorded motion, as its file

    @property
    def uses_pictures(self) -> bool:
        """Whether it looks with camera images."""
        return any(settings.sensor == "rendered" for settings in settings_of(self.scripts))

    @property
    def last_settings(self) -> Settings:
        """The settings at its end, with the demonstrator's last posture."""
        settings = self.script.settings
        for action in self.script.actions:
            if isinstance(action, Begin):
                settings = action.settings
            elif isinstance(action, ChangeSettings):
                settings = msgspec.structs.replace(settings, **convert_fields(action.fields))
            elif isinstance(action, MoveDemonstrator):
                settings = msgspec.structs.replace(settings, demonstrator_deg=to_degrees(np.array(action.theta_demo)))
        return settings

    @property
    def scripts(self) -> list[Script]:
        """Its own script, and the opponent's."""
        return [self.script, *([self.opponent] if self.opponent is not None else [])]


def read_link(query: str, begun: Settings) -> Linked:
    """Read a query. begun: what the server was started with, whose scene file a link may name, and against which a link
    without a preset is read. Raises ValueError, in one line, for what is not understood or not allowed."""
    pairs = link.split(query)
    page, script_pairs = dict[str, str](), list[tuple[str, str]]()
    for name, text in pairs:
        if name == EARLIER:
            raise ValueError("the link is of version 0.2, which is not read any more: ask for a new one")
        if name not in OF_PAGE:
            script_pairs.append((name, text))
        elif name in page:
            raise ValueError(f"the link has {name!r} twice")
        else:
            page[name] = text
    own = {file_name(place): place for place in (begun.scene, begun.robot) if place}
    own[choices.place_in_link(begun.scene)] = begun.scene
    preset = _preset(page.get("preset"), begun)
    base = choices.usual(preset)
    share = 2 if VERSUS in page else 1
    script, motion = _script(page.pop(link.PACKED, None), script_pairs, base, share)
    scripts = [script]
    if VERSUS in page:
        versus = link.split(page[VERSUS])
        packed = dict(versus).get(link.PACKED)
        scripts.append(_script(packed, [pair for pair in versus if pair[0] != link.PACKED], base, share)[0])
    scripts = [one.renamed(lambda name: own.get(name, name)) for one in scripts]
    require_allowed(scripts, begun)
    return Linked(
        script=scripts[0],
        opponent=scripts[1] if len(scripts) > 1 else None,
        preset=preset,
        speed=_chosen("speed", page["speed"], SPEEDS_BY_NAME) if "speed" in page else preset.motions_per_second,
        at=_number("at", page["at"], MAX_HISTORY) if "at" in page else MAX_HISTORY,
        chosen=_point(page.get("point")),
        show={name: getattr(choices.View(), name) for name in choices.SWITCHES}
        | {n: _chosen(n, page[n], choices.FLAGS) for n in choices.SWITCHES if n in page},
        dark=_chosen("dark", page["dark"], choices.FLAGS) if "dark" in page else None,
        offers_tour=_chosen("tour", page.get("tour", "1"), choices.FLAGS),
        motion=motion,
    )


def _script(packed: str | None, pairs: link.Pairs, base: Settings, share: int) -> tuple[Script, bytes | None]:
    """share: of how many scripts of the link it is one."""
    if packed is None:
        return link.understood(pairs, base, share), None
    if pairs:
        raise ValueError(f"the link has both {link.PACKED!r} and {pairs[0][0][:40]!r}")
    found = link.unpacked(packed, share)
    return found.script, found.motion


def _preset(key: str | None, begun: Settings) -> choices.Preset:
    if key is None:
        return next(iter(choices.presets_from(begun).values()))
    offered = {preset.key: preset for preset in choices.PRESETS}
    if key not in offered:
        raise ValueError(f"the link has a preset that is not here, {key[:40]!r}; there are {', '.join(offered)}")
    return offered[key]


def _chosen(name: str, text: str, offered: Mapping[str, T]) -> T:
    if text not in offered:
        raise ValueError(f"the link's {name} must be one of {', '.join(offered)}, got {text[:40]!r}")
    return offered[text]


def _point(text: str | None) -> int | None:
    return None if text == "none" else -1 if text is None else _number("point", text, 1_000)


def _number(name: str, text: str, most: int) -> int:
    if not (text.isascii() and text.isdecimal() and len(text) < 8 and int(text) <= most):
        raise ValueError(f"the link's {name} must be a whole number up to {most}, got {text[:40]!r}")
    return int(text)


def files_named(script: Script) -> list[str]:
    """Return the scene and robot files that a script names, with which a server has to be started to open it."""
    named: dict[str, None] = {}  # in their order
    script.renamed(lambda name: named.setdefault(name) or name)
    return [name for name in named if name not in (*scene_names(), *robot_names()) and not is_text(name)]


def settings_of(scripts: list[Script]) -> Iterator[Settings]:
    """Yield the settings that scripts begin with or go on with."""
    for script in scripts:
        yield script.settings
        for action in script.actions:
            if isinstance(action, Begin):
                yield action.settings
            elif isinstance(action, ChangeSettings) and not action.fields.keys().isdisjoint(BOUNDED):
                try:
                    yield msgspec.convert(action.fields, Settings)
                except (msgspec.ValidationError, ValueError) as error:
                    raise ValueError(f"the link cannot be opened: {' '.join(str(error).split())[:200]}") from None


def require_allowed(scripts: list[Script], begun: Settings) -> None:
    """Raise ValueError for work that a server does not do for every visitor."""
    scenes, robots, texts = {*scene_names(), begun.scene}, {*robot_names(), begun.robot, None}, set[str]()
    for settings in settings_of(scripts):
        _require_names(settings, scenes, robots)
        if is_text(settings.scene):
            texts.add(settings.scene)
    if len(texts) > MAX_SCENES:
        raise ValueError(f"the link describes {len(texts)} scenes; {MAX_SCENES} are the most")
    for text in texts:
        choices.require_scene(text)


def _require_names(settings: Settings, scenes: Container[str], robots: Container[str | None]) -> None:
    """No file of the server is opened for a link, except those that it shows anyhow."""
    if OWN in (settings.transfer, settings.servo):
        raise ValueError("the link runs a transfer or a servo that only its author has")
    if not is_text(settings.scene) and settings.scene not in scenes:
        raise ValueError(f"the link shows a scene that is not here, {settings.scene[:80]!r}")
    if settings.robot not in robots:
        raise ValueError(f"the link shows a robot that is not here, {str(settings.robot)[:80]!r}")
    if len(settings.body_points or ()) > choices.MAX_POINTS:
        raise ValueError(f"the link places {len(settings.body_points or ())} points; {choices.MAX_POINTS} are the most")
    if settings.frames > MAX_FRAMES:
        raise ValueError(f"the link averages {settings.frames} pictures; {MAX_FRAMES} are the most")
    if not all(map(math.isfinite, (*(settings.demonstrator_deg or ()), *(settings.start_deg or ())))):
        raise ValueError("the link has an angle that is no number")


# Its scripts are played beside the page, which then becomes what they lead to.

TURN_S = 0.02  # of one page's scripts, before those of the next have their turn
MAX_S = 30.0  # that scripts may take


@dataclass(eq=False)
class Played:
    """What a link holds, and its sessions as far as they are played. is_own: it is what the page's own tab has kept;
    camera: renders the pictures; error: why they are not played."""

    page: Linked
    is_own: bool
    camera: CameraProcess
    sessions: list[Session] = field(default_factory=list)
    error: Exception | None = None
    spent_s: float = 0.0

    def passes(self) -> Iterator[None]:
        """Play it, and yield after each pass of the loop."""
        for script in self.page.scripts:
            session = Session(script.settings, open_eyes=eyes_beside(self.camera), dense=DENSE)
            yield from session.passes(script)
            session.scrub(min(self.page.at, len(session.history) - 1))
            self.sessions.append(session)

    def turn(self, passes: Iterator[None]) -> object:
        """Play on for a turn, and rest as long, which leaves the pages time. Return UNFINISHED unless it is whole."""
        clock = time.monotonic if self.page.uses_pictures else time.thread_time
        began, computed = clock(), time.thread_time()
        while clock() - began < TURN_S:
            if next(passes, passes) is passes:
                return None
            if self.spent_s + clock() - began > MAX_S:
                raise ValueError(f"it takes more than {MAX_S:g} s to compute")
        self.spent_s += clock() - began
        time.sleep(time.thread_time() - computed)
        return UNFINISHED


class Following:
    """The saved page that a page becomes, if any. goes_on: a script is still played; restores: it is what the page's
    own tab has kept, before which nothing else counts."""

    def __init__(self, services: Services, queue: CommandQueue):
        self._services, self._queue = services, queue
        self._played: Played | None = None
        self.goes_on = self.restores = False

    def begin(self, page: Linked, become: Callable[[Played, float], None], is_own: bool = False) -> None:
        """Play a saved page instead of the one that is played now. become(played, now): makes the page what it is."""
        played = self._played = Played(page, is_own, self._services.camera)
        self.goes_on, self.restores = True, is_own
        worker = self._services.picture_scripts if page.uses_pictures else self._services.scripts
        passes = played.passes()

        def turn() -> object:
            return played.turn(passes) if played is self._played else None

        def arrive(made: Exception | None) -> None:
            if played is self._played:  # it was not cancelled just when it was complete
                self.let_go()
                played.error = made
                become(played, self._services.clock())

        how = {"moves": True, "cancels": True, "is_made": False, "camera": lambda model: page.uses_pictures}
        worker.ask(self._queue, "script", turn, arrive, **how)

    def let_go(self) -> bool:
        """Follow it no more. Return whether there was one."""
        played, self._played = self._played, None
        self.goes_on = self.restores = False
        return played is not None
