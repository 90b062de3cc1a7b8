"""A session's snapshots as numbers, which the modules of the lab draw in a replay. Pixels are whole hundredths and
angles whole microradians, null where something is not known: small as compressed JSON. app/lab/view/recorded.js reads
what is written here."""

from collections.abc import Sequence
from functools import cache, lru_cache
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from viewimit.assets import ROOT

from viewimit.analysis.construction import construct
from viewimit.analysis.landscape import Landscape, conflict_at, seen_from
from viewimit.analysis.observability import joint_uncertainty
from viewimit.analysis.self_assessment import assess
from viewimit.drawing import svg
from viewimit.drawing.export.panels import TOO_FEW, compute_landscape, landscape_key
from viewimit.drawing.images.panel import gauge
from viewimit.drawing.landscape import HEIGHT, WIDTH, draw_observability
from viewimit.drawing.status import describe, describe_truth
from viewimit.loop.session import Session
from viewimit.loop.settings import DISTURBANCES, Settings
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.appearance import Silhouettes

MAX_SNAPSHOTS = 150  # of a longer run, evenly spread
MAX_LANDSCAPES = 24  # of different demonstrators' postures; with more, a sentence says that the map follows
MAX_CONSTRUCTIONS = 2400  # over all points and snapshots; with more, only the first chosen point's is recorded
TREND = 5  # snapshots before a moment that its status may mention
MAP_DEG = 2.0  # step of a map's grid
FOLLOWS = "The map of E follows the demonstrator."
PX, RAD, SHARE = 100, 1e6, 1000  # units of what is recorded in a px, a rad, and the logarithm of E
MAX_WHOLE = 1e8  # hundredths of a px: nothing so far off is drawn
LAB_DISTURBANCES = "noise_px", "missing"


class LabMethods(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the lab says of each method, by its name; the first stands in for others."""

    servos: dict[str, dict[str, Any]]
    transfers: dict[str, dict[str, Any]]


@cache
def lab_methods() -> LabMethods:
    """Return the methods of the lab, from the file that its modules read as well."""
    return msgspec.json.decode(ROOT.joinpath("lab", "methods.json").read_bytes(), type=LabMethods)


def kept_motions(history: Sequence[Snapshot]) -> list[int]:
    """Choose at most MAX_SNAPSHOTS motions of a history that a replay shows."""
    available = [k for k, moment in enumerate(history) if moment.motion == k]  # long histories are thinned out
    return [available[i] for i in svg.thinned(len(available), MAX_SNAPSHOTS)]


def record(session: Session, motions: Sequence[int], chosen: int | None) -> dict[str, Any]:
    """Record a session in a scene at these motions. chosen: a body point, whose construction is shown at first."""
    snapshots = [session.history[k] for k in motions]
    count, points = len(session.world.body), range(len(session.world.body))
    constructed = points if count * len(motions) <= MAX_CONSTRUCTIONS else [] if chosen is None else [chosen]
    demonstrators, methods, maps = list[Any](), list[Any](), _Maps(session, snapshots)
    silhouettes = Silhouettes({}, session.world)
    recorded = []
    for moment in snapshots:
        views, recovered = moment.views, silhouettes.bodies(moment.theta_demo, moment.theta, moment.transfer).recovered
        flags = lambda pair: "" if pair.all() else "".join(map(str, pair.astype(int).ravel()))
        seen, own_seen = map(flags, np.split(views.visible, 2, 1))
        demo = {"theta": _angles(moment.theta_demo), "images": _pixels(views.demo), "seen": seen}
        recorded.append(
            {
                "motion": moment.motion,
                "theta": _angles(moment.theta),
                "demo": _index(demonstrators, demo),
                "own": _pixels(views.own),
                "seen": own_seen,
                "recovered": _pixels(moment.recovered),
                "bones": None if recovered is None else _pixels(recovered),
                "E": None if np.isnan(moment.E) else float(f"{moment.E:.6g}"),
                "probe": moment.probe,
                "method": _index(methods, describe_method(moment)),
                "map": maps.index(moment),
                "condition": _condition(moment),
                "constructed": {str(point): _construction(moment, point) for point in constructed},
                **_said(session, moment),
            }
        )
    tables = {"demonstrators": demonstrators, "methods": methods, "maps": maps.entries}
    return {"chosen": chosen, "snapshots": recorded, **tables}


def lab_settings(settings: Settings) -> dict[str, Any]:
    """Return the settings that the lab has, as its modules name them."""
    same = ("transfer", "servo", "missing", "seed", "points")
    return {**{name: getattr(settings, name) for name in same}, "noisePx": settings.noise_px}


def describe_method(moment: Snapshot) -> dict[str, Any]:
    """Say how the learner learns at a moment, and with which of the lab's methods the run can go on there."""
    settings = moment.settings
    offered = lab_methods()
    transfer = settings.transfer if settings.transfer in offered.transfers else next(iter(offered.transfers))
    servo = settings.servo if settings.servo in offered.servos else next(iter(offered.servos))
    return {
        "transferTitle": moment.method.title,
        "servoTitle": moment.servo.title,
        "crosses": moment.method.crosses_lines,
        "rectified": moment.rectification is not None,
        "lab": {
            **lab_settings(settings),
            "transfer": transfer,
            "servo": servo,
            "noisePx": round(settings.noise_px / settings.frames**0.5, 4),
            "points": len(moment.views.demo),
        },
        "lacks": lacks(settings, moment.method.title, moment.servo.title, moment.rectification is not None),
    }


@lru_cache(64)
def lacks(settings: Settings, transfer: str, servo: str, is_rectified: bool) -> tuple[str, ...]:
    """Say what of a run the lab has not, each in a few words. transfer, servo: their titles."""
    offered = lab_methods()
    disturbed = (name for name in DISTURBANCES if name not in LAB_DISTURBANCES and getattr(settings, name))
    found = {
        f"the transfer “{transfer}”": settings.transfer not in offered.transfers,
        f"the servo “{servo}”": settings.servo not in offered.servos,
        "rectified pictures": is_rectified,
        "rendered pictures": settings.sensor != "projected",
        **{name.removesuffix("_deg").replace("_", " "): True for name in disturbed},
    }
    return tuple(words for words, is_lacking in found.items() if is_lacking)


def _said(session: Session, moment: Snapshot) -> dict[str, Any]:
    """What the learner says of itself, and the truth beside it."""
    history, joints = session.history, session.scene.moving_joints
    motion, last = moment.motion, session.history[-1].motion
    is_last = motion == last
    assessment = assess(session) if is_last and session.cursor == last and moment.status.is_at_rest else None
    before = history[max(motion - TREND, 0) : motion]
    said = describe(moment, before, not is_last, assessment, joints, advises=False)
    words = {name: getattr(said, name) for name in ("title", "sentence", "doubt", "word")}
    return {"state": str(said.state), **words, "truth": describe_truth(joints, moment.theta, moment.theta_demo)}


def _condition(moment: Snapshot) -> dict[str, Any] | None:
    if moment.transfer is None:
        return None
    value = float(moment.transfer.condition)
    level, name = gauge(value, moment.method.condition_name)
    return {"name": name, "value": svg.short(value, 100), "level": level}


def _construction(moment: Snapshot, point: int) -> dict[str, Any] | None:
    """How a point is transferred, as `Construction`; with rectified images also its epipolar lines."""
    built = construct(moment, point) if point < len(moment.views.demo) else None
    if built is None:
        return None
    found: dict[str, Any] = {"axes": _pixels(built.half_axes), "turn": np.degrees(built.direction).round(1).tolist()}
    if built.angle is not None:
        found["angle"] = np.degrees(built.angle).round().astype(int).tolist()
    if built.steps is not None:
        found["steps"] = [_pixels(stops) for stops in built.steps]
    if moment.rectification is not None and moment.method.crosses_lines:
        lines = moment.epipolar_lines(point)
        if lines is not None:
            found["lines"] = (lines / np.hypot(lines[:, 0], lines[:, 1])[:, None]).round(5).tolist()
    return found


def _index(entries: list[Any], entry: Any) -> int:
    """The entry's index, after adding it to different ones if it is new."""
    if entry not in entries:
        entries.append(entry)
    return entries.index(entry)


class _Maps:
    """Maps of E of a session, or for other than two joints what noise costs at each; computed at their first use."""

    def __init__(self, session: Session, snapshots: Sequence[Snapshot]):
        self._world = session.world
        self._too_many = len({landscape_key(snapshot) for snapshot in snapshots}) > MAX_LANDSCAPES
        self._indices: dict[tuple, int] = {}
        self.entries: list[dict[str, Any]] = []

    def index(self, moment: Snapshot) -> int:
        """Return the index of a moment's entry."""
        key = () if self._too_many else landscape_key(moment)
        if key not in self._indices:
            self._indices[key] = len(self.entries)
            self.entries.append(self._made(moment))
        return self._indices[key]

    def _made(self, moment: Snapshot) -> dict[str, Any]:
        if self._too_many:
            return {"says": FOLLOWS}
        if moment.transfer is None and not moment.usable.any():
            return {"says": TOO_FEW}
        world, theta, seen = self._world, moment.theta_demo, seen_from(self._world, moment)
        E_true = float(conflict_at(*seen, theta[:, None])[0, 0])
        found: dict[str, Any] = {"E_true": E_true if np.isfinite(E_true) else None}
        landscape = compute_landscape(world, moment, MAP_DEG)
        if landscape is None:
            std_per_px = joint_uncertainty(*seen, theta)
            if std_per_px is None:
                return found | {"says": TOO_FEW}
            bars = draw_observability(world.scene.moving_joints, std_per_px)
            return found | {
                "bars": f'<svg class="vi" viewBox="0 0 {WIDTH} {HEIGHT}" preserveAspectRatio="xMinYMin">{bars}</svg>'
            }
        return found | _grid(landscape)


def _grid(landscape: Landscape) -> dict[str, Any]:
    """A landscape's size, minimum, and the logarithm of E, row by row, each as its difference from the one before."""
    level = np.log(np.maximum(landscape.E, 1e-9)) * SHARE
    known = np.isfinite(level)
    if not known.any():
        return {"says": "Nowhere are five points seen in all four pictures."}
    whole = np.where(known, level, level[known].max()).round().astype(int).ravel()
    return {
        "size": landscape.E.shape,
        "minimum": _angles(landscape.minimum),
        "level": np.diff(whole, prepend=0).tolist(),
        "unknown": np.flatnonzero(~known.ravel()).tolist(),
    }


def _pixels(values: NDArray[np.float64]) -> list[int | None]:
    flat = (np.asarray(values, float).ravel() * PX).clip(-MAX_WHOLE, MAX_WHOLE)
    known = np.isfinite(flat).tolist()
    return [round(value) if is_known else None for value, is_known in zip(flat.tolist(), known)]


def _angles(theta: NDArray[np.float64]) -> list[int]:
    return (np.nan_to_num(np.asarray(theta, float)) * RAD).round().astype(int).tolist()
