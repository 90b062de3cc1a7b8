"""What links and tabs keep of a page, as text: scripts of its session and of what Undo goes back to, and its view.

A text is the format's number and blocks, separated by dots. A block is base64 of zstd of msgpack. The last block holds
settings and posture in every version, so that an older server can go on from there. The others hold actions, in such a
way that one more action changes the last two blocks only. All of it is read as hostile input.
"""

import base64
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Annotated, Any

import msgspec
import numpy as np
import zstandard

from viewimit import __version__
from viewimit.loop.embodiment import to_degrees
from viewimit.loop.history import MAX_HISTORY
from viewimit.loop.script import (
    Action,
    Begin,
    Calibrate,
    ChangeSettings,
    Looks,
    MoveDemonstrator,
    Script,
    Steps,
)
from viewimit.loop.settings import OWN, Settings
from viewimit.sensing.files import file_name, is_text
from viewimit.simulation.robot import robot_names
from viewimit.simulation.scene import load_scene, scene_names
from viewimit.simulation.scene_writing import scene_text

FORMAT = 2
MAX_LINK = 6_000  # characters of a link, as part of an address
MAX_TEXT = 100_000  # characters that a tab keeps
MAX_BYTES = 1 << 20  # unpacked
MAX_ACTIONS = 20_000
MAX_BRANCHES = 16
MAX_MOTION = 50_000  # bytes of a recorded motion
BLOCK = 100  # actions
MAX_FRAMES = 100  # images averaged in each observation
MAX_POINTS = 64  # placed by hand, or of a layout
MAX_LAYOUTS = 16
MAX_TITLE = 200  # characters
MAX_SCENES = 16  # described in full
MAX_CALIBRATION = 200  # postures

Index = Annotated[int, msgspec.Meta(ge=0, le=MAX_HISTORY)]
Speed = Annotated[float, msgspec.Meta(ge=0, le=1_000)]
Name = Annotated[str, msgspec.Meta(max_length=80)]
Reason = Annotated[str, msgspec.Meta(max_length=300)]
FIELDS: dict[str, Any] = {"frozen": True, "kw_only": True, "forbid_unknown_fields": True, "omit_defaults": True}


class Run(msgspec.Struct, **FIELDS):
    """A learner's run: the script to its last motion, and the motion that is shown."""

    script: Script
    cursor: Index


class Branch(msgspec.Struct, **FIELDS):
    """What a page shows, or what Undo goes back to.

    runs: the learner's, and its opponent's in a duel; at: the motion of the next branch from which Undo goes back here;
    preset, speed: of the page then.
    """

    runs: Annotated[tuple[Run, ...], msgspec.Meta(max_length=2)] = ()
    at: Index = 0
    preset: Name = ""
    speed: Speed = 2.0


class SavedPage(msgspec.Struct, **FIELDS):
    """What a link or a tab keeps of a page.

    present: without runs where no script is known; past: what Undo goes back to, the oldest first; settings, commanded:
    of the snapshot shown, commanded in rad; chosen: a point, -1 for the one with the largest residual; show: switches
    of the page; motion: a recorded motion, as its file; incomplete: what could not be kept, or read, and why.
    """

    present: Branch
    settings: Settings
    past: tuple[Branch, ...] = ()
    commanded: tuple[float, ...] = ()
    chosen: Index | None = None
    show: dict[Name, bool] = {}
    dark: bool | None = None
    offers_tour: bool = True
    motion: bytes | None = None
    incomplete: Reason = ""

    @property
    def scripts(self) -> list[Script]:
        """All of its scripts, the oldest first."""
        return [run.script for branch in (*self.past, self.present) for run in branch.runs]

    @property
    def uses_pictures(self) -> bool:
        """Whether a script looks with camera images."""
        found = (settings for script in self.scripts for settings in _all_settings(script))
        return any(settings.sensor == "rendered" for settings in found)

    def renamed(self, rename: Callable[[str], str]) -> "SavedPage":
        """The page with other names of scenes and robots."""
        branches = [
            msgspec.structs.replace(
                branch,
                runs=tuple(Run(script=run.script.renamed(rename), cursor=run.cursor) for run in branch.runs),
            )
            for branch in (*self.past, self.present)
        ]
        settings = Script(self.settings).renamed(rename).settings
        return msgspec.structs.replace(self, past=tuple(branches[:-1]), present=branches[-1], settings=settings)


class _Block(msgspec.Struct, array_like=True, forbid_unknown_fields=True):
    """Actions in columns.

    settings: of a run's first block; kinds: a letter for each action; times: of steps and looks; tenths: differences
    from each posture to the next in whole tenths of a degree, by joint; others: as they are.
    """

    settings: dict[str, Any] | None
    kinds: str
    times: list[Annotated[int, msgspec.Meta(ge=1)]]
    tenths: list[list[int]]
    others: list[list[Any]]


class _Branch(msgspec.Struct, **FIELDS):
    """runs: the cursor and the number of blocks of each."""

    runs: Annotated[list[tuple[Index, Annotated[int, msgspec.Meta(ge=1)]]], msgspec.Meta(max_length=2)]
    at: Index = 0
    preset: Name = ""
    speed: Speed = 2.0


class _Head(msgspec.Struct, **FIELDS):
    """The last block. version: of the program; branches: the present one last; motion: whether it has a block."""

    version: Name
    settings: dict[str, Any]
    branches: Annotated[list[_Branch], msgspec.Meta(min_length=1, max_length=MAX_BRANCHES)]
    commanded: Annotated[tuple[float, ...], msgspec.Meta(max_length=64)] = ()
    chosen: Index | None = None
    show: dict[Name, bool] = {}
    dark: bool | None = None
    offers_tour: bool = True
    motion: bool = False
    incomplete: Reason = ""


class _Earlier(msgspec.Struct, forbid_unknown_fields=True):
    """Format 1, of links only."""

    script: Script
    preset: Name = ""
    speed: Speed = 2.0
    chosen: Index | None = None
    show: dict[Name, bool] = {}


def encode_link(page: SavedPage) -> str:
    """The text of a link: letters, digits, -, _ and dots.

    A scene file is described in full, so that the link opens everywhere. A scene with a robot of its own, or one that
    is too long for an address, is named by its file. Raises ValueError for a page that is too long.
    """
    text = ""
    for rename in (described, file_name):
        renamed = page.renamed(rename)
        text = ".".join(encode_blocks(renamed, level=19))
        if len(text) <= MAX_LINK:
            require_allowed(renamed, renamed.settings)
            return text
    refusal = "too much was done for a link: {n} characters of {most}"
    raise ValueError(refusal.format(n=len(text), most=MAX_LINK))


def encode_blocks(page: SavedPage, level: int = 9) -> list[str]:
    """The text's parts, which dots separate. level: of the compression."""
    packer = zstandard.ZstdCompressor(level, dict_data=COMMON, write_content_size=False)

    def block(content: object) -> str:
        packed = packer.compress(msgspec.msgpack.encode(content))
        return base64.urlsafe_b64encode(packed).decode().rstrip("=")

    blocks = [str(FORMAT)]
    if page.motion is not None:
        blocks.append(block(page.motion))
    branches = []
    for branch in (*page.past, page.present):
        runs = []
        for run in branch.runs:
            found = [block(one) for one in _columns(run.script)]
            runs.append((run.cursor, len(found)))
            blocks += found
        branches.append(_Branch(runs=runs, at=branch.at, preset=branch.preset, speed=branch.speed))
    head = _Head(
        version=__version__, settings=_fields(page.settings), commanded=page.commanded, branches=branches,
        chosen=page.chosen, show=page.show, dark=page.dark, offers_tour=page.offers_tour,
        motion=page.motion is not None, incomplete=page.incomplete,
    )  # fmt: skip
    return [*blocks, block(head)]


def decode(text: str, begun: Settings) -> SavedPage:
    """Read a link or what a tab has kept.

    begun: settings that the server was started with, whose scene file a text may name. If only the last block can be
    used, the page has no runs, and `incomplete` says why. Raises ValueError, in one line, for an invalid text.
    """
    page = _decoded(text)
    places = [place for place in (begun.scene, begun.robot) if place is not None]
    own = {name(place): place for place in places for name in (file_name, described)}
    page = page.renamed(lambda name: own.get(name, name))
    require_allowed(page, begun)
    return page


def files_named(text: str) -> list[str]:
    """Names of the scene and robot files in a text, with which a server has to be started to open it."""
    named: dict[str, None] = {}  # in their order
    _decoded(text).renamed(lambda name: named.setdefault(name) or name)
    return [name for name in named if name not in (*scene_names(), *robot_names()) and not is_text(name)]


def described(place: str) -> str:
    """A scene file's content, where possible; otherwise its name, as of anything that is no scene file."""
    if not place.lower().endswith(".toml"):
        return file_name(place)
    try:
        text = scene_text(load_scene(place))
        _require_scene(text)
        return text
    except (OSError, ValueError):
        return file_name(place)


def _columns(script: Script) -> Iterator[_Block]:
    """The blocks of a run."""
    first: dict[str, Any] | None = _fields(script.settings)
    for start in range(0, max(len(script.actions), 1), BLOCK):
        found, before = _Block(first, "", [], [], []), None
        first, kinds = None, []
        for action in script.actions[start : start + BLOCK]:
            tenths = _tenths(action.theta_demo) if isinstance(action, MoveDemonstrator) else None
            if isinstance(action, Steps | Looks):
                kinds.append("s" if isinstance(action, Steps) else "l")
                found.times.append(action.times)
            elif tenths is not None and (before is None or len(before) == len(tenths)):
                kinds.append("t")
                found.tenths = found.tenths or [[] for __ in tenths]
                for column, value, last in zip(found.tenths, tenths, before or [0] * len(tenths)):
                    column.append(value - last)
                before = tenths
            else:
                kinds.append("o")
                found.others.append(msgspec.to_builtins(action))
        found.kinds = "".join(kinds)
        yield found


def _tenths(theta: Sequence[float]) -> list[int] | None:
    """A posture in whole tenths of a degree, if it is the same to the last bit."""
    tenths = [round(10 * angle) for angle in to_degrees(np.array(theta))]
    return tenths if _radians(tenths) == tuple(theta) else None


def _radians(tenths: Sequence[int]) -> tuple[float, ...]:
    return tuple(float(np.radians(value / 10)) for value in tenths)


def _script(blocks: list[_Block]) -> Script:
    """The script of a run."""
    if blocks[0].settings is None:
        raise ValueError("a run has no settings")
    plain = {"settings": blocks[0].settings, "deeds": [other for block in blocks for other in block.others]}
    known = msgspec.convert(plain, Script)
    others, actions = iter(known.actions), list[Action]()
    for block in blocks:
        times, postures = iter(block.times), iter(np.cumsum(block.tenths, axis=1).T.tolist() if block.tenths else ())
        for kind in block.kinds:
            if kind in "sl":
                actions.append((Steps if kind == "s" else Looks)(next(times)))
            elif kind == "t":
                actions.append(MoveDemonstrator(_radians(next(postures))))
            else:
                actions.append(next(others))
    return Script(known.settings, tuple(actions))


def _fields(settings: Settings) -> dict[str, Any]:
    return msgspec.msgpack.decode(msgspec.msgpack.encode(settings))


def _decoded(text: str) -> SavedPage:
    """A text as it stands: names are not looked up."""
    if len(text) > MAX_TEXT:
        refusal = "the link is too long: {n} characters of {most}"
        raise ValueError(refusal.format(n=len(text), most=MAX_TEXT))
    number, *blocks = text.split(".")
    if not blocks and text.startswith("1"):
        return _earlier(text[1:])
    if not number.isdecimal() or len(number) > 4 or not blocks:
        raise ValueError("the link is of another version, or damaged")
    unpacker = _Unpacker()
    try:
        plain = msgspec.msgpack.decode(unpacker.unpacked(blocks[-1]))
        settings, commanded = plain.get("settings", {}), plain.get("commanded", ())
        if int(number) > FORMAT:
            known = {name: value for name, value in settings.items() if name in Settings.__struct_fields__}
            why = "it is of a newer version of viewimit, {version}".format(version=str(plain.get("version", ""))[:20])
            plain = {"version": "", "branches": [{"runs": []}], "incomplete": why, "commanded": commanded}
            settings = known
        head = msgspec.convert(plain | {"settings": settings}, _Head)
        page = SavedPage(
            present=_branch(head.branches[-1]), settings=msgspec.convert(settings, Settings),
            commanded=head.commanded, chosen=head.chosen, show=head.show, dark=head.dark, offers_tour=head.offers_tour,
            incomplete=head.incomplete,
        )  # fmt: skip
    except _ERRORS as error:
        raise _damaged(error) from None
    if int(number) > FORMAT:
        return page
    try:
        return _with_runs(page, head, [unpacker.unpacked(block) for block in blocks[:-1]])
    except _ERRORS as error:
        why = f"its motions are damaged: {str(error)[:120]}"
        return msgspec.structs.replace(page, incomplete=why)


def _with_runs(page: SavedPage, head: _Head, packed: list[bytes]) -> SavedPage:
    """A page with the contents of the blocks before the last one."""
    motion = msgspec.msgpack.decode(packed.pop(0), type=bytes) if head.motion else None
    blocks = iter(msgspec.msgpack.decode(one, type=_Block) for one in packed)
    branches, actions = [], 0
    for branch in head.branches:
        runs = []
        for cursor, count in branch.runs:
            found = [next(blocks) for __ in range(count)]
            actions += sum(len(block.kinds) for block in found)
            if actions > MAX_ACTIONS:
                raise ValueError(f"more than {MAX_ACTIONS} actions")
            runs.append(Run(script=_script(found), cursor=cursor))
        branches.append(msgspec.structs.replace(_branch(branch), runs=tuple(runs)))
    return msgspec.structs.replace(page, motion=motion, past=tuple(branches[:-1]), present=branches[-1])


def _branch(head: _Branch) -> Branch:
    return Branch(at=head.at, preset=head.preset, speed=head.speed)


def _earlier(text: str) -> SavedPage:
    """A link of format 1, without its number."""
    try:
        found = msgspec.msgpack.decode(_Unpacker(common=None).unpacked(text))
        if isinstance(found.pop("lesson", None), list):
            raise ValueError("it opens a lesson, which are in the lab now, at /lab/tour")
        linked = msgspec.convert(found, _Earlier)
        run = Run(script=linked.script, cursor=MAX_HISTORY)
    except _ERRORS as error:
        raise _damaged(error) from None
    present = Branch(runs=(run,), preset=linked.preset, speed=linked.speed)
    return SavedPage(present=present, settings=linked.script.settings, chosen=linked.chosen, show=linked.show)


# What blocks have in common, which shortens them by half. It belongs to the format: without it no text can be read
COMMON = zstandard.ZstdCompressionDict(
    msgspec.msgpack.encode(
        {
            "version": "", "commanded": [], "branches": [{"runs": [[0, 1]], "preset": "", "speed": 2.0, "at": 0}],
            "chosen": 0, "offers_tour": False, "motion": True, "incomplete": "", "dark": False,
            "show": dict.fromkeys(("rays", "residuals", "gizmo", "whole_frames", "rectified", "shadows"), False),
            "linear": "trust-region", "gradient": "rendered", "settings": {
                "scene": "panda", "robot": None, "joints": None, "points": 10, "body_points": None,
                "demonstrator_deg": [45.0, -90.0], "start_deg": [25.0, -45.0], "transfer": "epipolar",
                "servo": "broyden", "noise_px": 0.0, "missing": 0.0, "outliers": 0.0, "swapped": 0.0, "frames": 1,
                "gain_error": 0.0, "encoder_step_deg": 0.0, "delay": 0, "seed": 7, "undistort": None,
                "rectify": "auto", "sensor": "projected", "max_step_deg": None, "restarts": 4, "workspace_deg": None,
            },
        }
    ),
    dict_type=zstandard.DICT_TYPE_RAWCONTENT,
)  # fmt: skip


class _Unpacker:
    """Decodes blocks while they have at most MAX_BYTES together."""

    def __init__(self, common: zstandard.ZstdCompressionDict | None = COMMON):
        self._left, self._unpacker = MAX_BYTES, zstandard.ZstdDecompressor(dict_data=common)

    def unpacked(self, block: str) -> bytes:
        packed = base64.b64decode(block + "=" * (-len(block) % 4), altchars="-_", validate=True)
        plain = self._unpacker.decompress(packed, max_output_size=self._left)
        self._left -= len(plain)
        return plain


_ERRORS = (
    ValueError, LookupError, TypeError, AttributeError, RecursionError, StopIteration, OverflowError,
    zstandard.ZstdError, msgspec.MsgspecError,
)  # fmt: skip


def _damaged(error: BaseException) -> ValueError:
    return ValueError("the link is damaged: {why}".format(why=" ".join(str(error).split())[:120]))


def require_allowed(page: SavedPage, begun: Settings) -> None:
    """Raise ValueError for work that a server does not do for every visitor."""
    scripts = page.scripts
    all_settings = [page.settings, *(settings for script in scripts for settings in _all_settings(script))]
    for settings in all_settings:
        _require_names(settings, begun)
    texts = {settings.scene for settings in all_settings if is_text(settings.scene)}
    if len(texts) > MAX_SCENES:
        refusal = "the link describes {n} scenes; {most} are the most"
        raise ValueError(refusal.format(n=len(texts), most=MAX_SCENES))
    for text in texts:
        _require_scene(text)
    if not all(map(math.isfinite, page.commanded)):
        raise ValueError("the link is damaged: an angle is no number")
    if page.motion is not None and len(page.motion) > MAX_MOTION:
        refusal = "the link holds a motion of {n} bytes; {most} are the most"
        raise ValueError(refusal.format(n=len(page.motion), most=MAX_MOTION))
    for script in scripts:
        for action in script.actions:
            _require_finite(action)


def _all_settings(script: Script) -> Iterator[Settings]:
    """The settings that a script begins with, and those that its actions begin or go on with."""
    yield script.settings
    for action in script.actions:
        if isinstance(action, Begin):
            yield action.settings
        elif isinstance(action, ChangeSettings):
            try:
                yield msgspec.convert(action.fields, Settings)
            except msgspec.ValidationError as error:
                raise _damaged(error) from None


def _require_names(settings: Settings, begun: Settings) -> None:
    """No file of the server is opened for a link, except those that it shows anyhow."""
    if OWN in (settings.transfer, settings.servo):
        raise ValueError("the link runs a transfer or a servo that only its author has")
    if not is_text(settings.scene) and settings.scene not in (*scene_names(), begun.scene):
        raise ValueError(f"the link shows a scene that is not here, {settings.scene[:80]!r}")
    if settings.robot is not None and settings.robot not in (*robot_names(), begun.robot):
        raise ValueError(f"the link shows a robot that is not here, {settings.robot[:80]!r}")
    if len(settings.body_points or ()) > MAX_POINTS:
        refusal = "the link places {n} points; {most} are the most"
        raise ValueError(refusal.format(n=len(settings.body_points or ()), most=MAX_POINTS))
    if settings.frames > MAX_FRAMES:
        refusal = "the link averages {n} images; {most} are the most"
        raise ValueError(refusal.format(n=settings.frames, most=MAX_FRAMES))


def _require_scene(text: str) -> None:
    """At most what a page can draw."""
    try:
        scene = load_scene(text)
    except ValueError as error:
        why = " ".join(str(error).split())[:150]
        raise ValueError(f"the link's scene cannot be shown: {why}") from None
    points = max(map(len, scene.points.values()), default=0)
    for refusal, count, most in (
        ("the link's scene has {n} points; {most} are the most", points, MAX_POINTS),
        ("the link's scene has {n} layouts; {most} are the most", len(scene.points), MAX_LAYOUTS),
        ("the link's scene has a title of {n} letters; {most} are the most", len(scene.title), MAX_TITLE),
    ):
        if count > most:
            raise ValueError(refusal.format(n=count, most=most))
    if not scene.title.isprintable():
        raise ValueError("the link's scene has a title that cannot be printed")


def _require_finite(action: Action) -> None:
    postures = (
        (action.theta_demo,)
        if isinstance(action, MoveDemonstrator)
        else action.postures
        if isinstance(action, Calibrate)
        else ()
    )
    if len(postures) > MAX_CALIBRATION:
        refusal = "the link calibrates with {n} postures; {most} are the most"
        raise ValueError(refusal.format(n=len(postures), most=MAX_CALIBRATION))
    if not all(math.isfinite(angle) for posture in postures for angle in posture):
        raise ValueError("the link is damaged: an angle is no number")
