"""The cases of all studies, by group. A new case is a line in a group, or a function and a line."""

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from itertools import product
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ...estimation.transfers import TRANSFERS
from ...loop.session import Session
from ...loop.settings import PAPER_FIELDS, SENSORS, Settings
from ...loop.simulated_robot import OpenEyes, SimulatedRobot
from ...loop.snapshot import RunResult
from ...servo import SERVOS, MisfitKind
from ...simulation.eyes import open_eyes
from ...simulation.scene import Scene, load_scene
from ...simulation.scene_writing import whole_text
from . import demonstrators as other
from . import measures
from .draws import (
    DEMO_DEG,
    DISTANT_POINTS,
    MAX_BODIES,
    SurfaceEyes,
    draw_distant_scene,
    draw_marked_arm,
    draw_postures,
    draw_scene,
    open_resized,
    shared_eyes,
    surface_points,
)
from .engine import NEAR_DEG, Case, Draw, Group, Run, Says, arrives, claims_nothing, claims_nothing_false
from .intervals import rms

NOISY: dict[str, Any] = {"noise_px": 0.25, "frames": 25}
SEVEN: dict[str, Any] = {"joints": tuple(range(1, 8)), "points": 16}


def posed(
    draw: Draw, offset_deg: float | None = None, open_eyes: OpenEyes = open_eyes, tries: int = 1, **changes: Any
) -> Session:
    """Open a session with random postures and noise. offset_deg: as of `draw_postures`; tries: of eyes that draw."""
    settings = msgspec.structs.replace(draw.settings, **changes)
    scene = load_scene(settings.scene, settings.robot, settings.joints)
    changes |= {**draw_postures(scene, draw.rng, offset_deg), "seed": int(draw.rng.integers(2**32))}
    for _ in range(tries):
        session = draw.session(open_eyes, **changes)
        if session.snapshot.transfer is not None:
            break
    return session


def of_study(seed: int, number: int) -> np.random.Generator:
    """Return a generator from which all runs of a study draw, one after the other."""
    return np.random.default_rng(seed)


# Starts and demonstrators anywhere, without disturbances


def anywhere(draw: Draw) -> Session:
    """Start and demonstrator uniform over the range of all moving joints."""
    low, high = np.transpose(load_scene(draw.settings.scene).range_deg)
    start, demonstrator = draw.rng.uniform(low, high, (draw.number + 1, 2, len(low)))[-1].tolist()
    return draw.session(shared_eyes, start_deg=tuple(start), demonstrator_deg=tuple(demonstrator))


def on_grid(draw: Draw, counts: tuple[int, ...]) -> Session:
    """Start on a grid over the range, with the scene's demonstrator."""
    scene = load_scene(draw.settings.scene)
    axes = (np.linspace(*limits, count) for limits, count in zip(scene.range_deg, counts, strict=True))
    start = list(product(*axes))[draw.number]
    demonstrator = tuple(scene.posture_deg[joint] for joint in scene.moving)
    return draw.session(shared_eyes, start_deg=tuple(map(float, start)), demonstrator_deg=demonstrator)


def every_method(transfer: str | None, servos: Sequence[str]) -> list[tuple[str, str]]:
    """Return all transfers and servos, slow servos with the paper's transfer only, unless one is given by name."""
    if transfer or servos:
        return list(product([transfer] if transfer else TRANSFERS, servos or SERVOS))
    paper = PAPER_FIELDS["transfer"]
    return [(paper, servo) for servo in SERVOS] + [pair for pair in quick_methods(None, ()) if pair[0] != paper]


def quick_methods(transfer: str | None, servos: Sequence[str]) -> list[tuple[str, str]]:
    """Return all transfers, and the servos that need few motions."""
    quick = [name for name, servo in SERVOS.items() if not servo.slow]
    return list(product([transfer] if transfer else TRANSFERS, servos or quick))


_minimum: dict[str, Any] = {"measure": measures.minimum, "max_motions": 500, "patience": 1}
SUCCESS = Group(
    "Every transfer and servo, from the same random starts at the same random demonstrators.",
    (Case("random starts", anywhere, generator=of_study, **_minimum),),
    Settings.paper(),
    every_method,
    measures.OF_MINIMUM,
    in_scene=True,
)
GRID = Group(
    "The same from starts on a grid, at the scene's demonstrator.",
    tuple(
        Case(f"{m} x {n} starts", partial(on_grid, counts=(m, n)), max_runs=m * n, **_minimum)
        for m, n in ((10, 13), (4, 5))
    ),
    Settings.paper(),
    every_method,
    measures.OF_MINIMUM,
    in_scene=True,
)


# Disturbances, and more joints


def rehearsed(draw: Draw, count: int, offset_deg: float, **changes: Any) -> Session:
    """Pose a session whose learner has calibrated itself first, within reach of all starts."""
    session = posed(draw, offset_deg, **changes)
    posture, rest = session.settings, tuple(np.array(session.scene.posture_deg)[session.scene.moving].tolist())
    session.begin(msgspec.structs.replace(posture, start_deg=rest))
    session.calibrate(count, posture.seed, DEMO_DEG + offset_deg)
    session.begin(posture)
    return session


SPOILED: list[tuple[str, dict[str, Any]]] = [
    (f"{what} {share:.0%}, {frames} frame{'s' * (frames > 1)}", {what: share, "frames": frames})
    for what, share in (("missing", 0.1), ("missing", 0.3), ("outliers", 0.1))
    for frames in (1, 5)
]
ROBUSTNESS = Group(
    "Noise, missing, wrong and swapped points, an inexact arm, and seven joints.",
    (
        Case("undisturbed", posed),
        *(Case(f"noise {px} px, 25 frames", partial(posed, noise_px=px, frames=25)) for px in (0.25, 0.5, 1.0)),
        *(Case(name, partial(posed, **changes)) for name, changes in SPOILED),
        Case(
            "all of these: 0.5 px, 10%, 10%, 25 frames",
            partial(posed, noise_px=0.5, missing=0.1, outliers=0.1, frames=25),
        ),
        *(Case(f"swapped {share:.0%}", partial(posed, swapped=share)) for share in (0.1, 0.2)),
        Case("gain error 5 %", partial(posed, gain_error=0.05)),
        Case("steps of 0.2°", partial(posed, encoder_step_deg=0.2)),
        *(Case(f"pictures {late} late", partial(posed, delay=late)) for late in (1, 3)),
        *(
            Case(f"seven joints, ±{offset}°, {n} points", partial(posed, offset_deg=offset, **{**SEVEN, "points": n}))
            for n in (16, 20)
            for offset in (30, 60)
        ),
        Case(
            "seven joints, ±30°, 16 points, noise 0.25 px, 25 frames", partial(posed, offset_deg=30, **SEVEN, **NOISY)
        ),
        Case("seven joints, ±30°, 16 points, 12 rehearsed", partial(rehearsed, count=12, offset_deg=30, **SEVEN)),
    ),
    in_scene=True,
    measures={"claimed_off_half_deg_and_3_expected": lambda runs: measures.share_of(
        [run.is_off(NEAR_DEG) for run in runs if run.claimed])},
)  # fmt: skip


# Demonstrators that move


SWING_DEG, PERIODS = 25.0, (1.0, 0.7)  # amplitude of the path; its periods for each joint, repeated for more joints
STEPS, SETTLING_STEPS = 150, 10  # of the path; not counted at its start


def on_path(draw: Draw, deg_per_step: float, **changes: Any) -> Session:
    """A demonstrator on a random path; its fastest joint moves so far a step."""
    scene = load_scene(draw.settings.scene)
    draw.notes["path"] = path = _path(scene, deg_per_step, draw.rng)
    seed = int(draw.rng.integers(2**32))
    return draw.session(seed=seed, demonstrator_deg=tuple(np.degrees(path[0])), **changes)


def _path(scene: Scene, deg_per_step: float, rng: np.random.Generator) -> np.ndarray:
    """Draw a path, (STEPS + 1, m) rad: swings about the scene's demonstrator."""
    centre = np.radians(np.array(scene.posture_deg)[scene.moving])
    swing = np.minimum(np.radians(SWING_DEG), (scene.upper - scene.lower) / 2)
    centre = np.clip(centre, scene.lower + swing, scene.upper - swing)
    periods, phase = np.resize(PERIODS, len(centre)), rng.uniform(0, 2 * np.pi, len(centre))
    curve = centre + swing * np.sin(phase + periods * np.linspace(0, 400, 200_000)[:, None])
    length = np.concatenate([[0.0], np.abs(np.diff(curve, axis=0)).max(1).cumsum()])
    distance = np.radians(deg_per_step) * np.arange(STEPS + 1)
    return np.stack([np.interp(distance, length, joint) for joint in curve.T], -1)


def track(session: Session, draw: Draw, max_motions: int, patience: int) -> RunResult:
    """Approach; then demonstrator and learner make one motion in turn."""
    result, errors = session.run(max_motions, patience), []
    for theta in draw.notes["path"][1:]:
        session.step()
        session.pose(theta)
        errors.append(np.degrees(np.abs(session.snapshot.theta - theta)).max())
    draw.notes["errors"] = errors[SETTLING_STEPS:]
    return result


def behind(session: Session, draw: Draw) -> dict[str, float]:
    """How far the learner is behind, degrees."""
    return {"behind_rms_deg": rms(draw.notes["errors"]), "behind_most_deg": max(draw.notes["errors"])}


def follows(run: Run) -> bool:
    """Promise: the learner is less than NEAR_DEG behind."""
    return run.measures["behind_rms_deg"] <= NEAR_DEG


PATHS: list[tuple[str, float, dict[str, Any]]] = [
    *((f"{rate:g}° a step", rate, {}) for rate in (0.5, 1.0, 3.0)),
    *((f"1° a step, noise {px} px", 1.0, {"noise_px": px}) for px in (0.25, 0.5)),
    ("1° a step, noise 0.25 px, 1 frame", 1.0, {"noise_px": 0.25, "frames": 1}),
]
TRACKING = Group(
    "A moving demonstrator, along random paths.",
    tuple(
        Case(name, partial(on_path, deg_per_step=rate, **changes), follows, track, behind, 200, patience=1)
        for name, rate, changes in PATHS
    ),
    Settings(),
    measures={
        "behind_rms_deg": measures.over("behind_rms_deg", rms),
        "behind_most_deg": measures.over("behind_most_deg", max),
    },
    runs=8,
    in_scene=True,
)  # fmt: skip


# Scenes drawn at random


def any_head(draw: Draw, **changes: Any) -> Session:
    """A new random scene for each run, with any head."""
    drawn = draw_scene(draw.rng, any_head=True)
    eyes = changes.pop("open_eyes", open_resized)
    return posed(draw, open_eyes=partial(eyes, size=drawn.size), scene=whole_text(drawn.scene), points=drawn.points,
                 **changes)  # fmt: skip


PAIRS_PER_SCENE = 5  # of start and demonstrator


@lru_cache(2)
def _pairs(seed: int, scene: int, any_head: bool) -> tuple[str, int, float, list, list[int]]:
    """Text of a random scene, its points and the learner's size; pairs of postures there, and seeds."""
    rng = np.random.default_rng([seed, scene])
    drawn = draw_scene(rng, any_head)
    low, high = np.transpose(drawn.scene.range_deg)
    pairs = rng.uniform(low, high, (PAIRS_PER_SCENE, 2, 2)).tolist()
    seeds = [int(rng.integers(2**32)) for _ in pairs]
    return whole_text(drawn.scene), drawn.points, drawn.size, pairs, seeds


def in_scenes(draw: Draw, any_head: bool, **changes: Any) -> Session:
    """A random scene for every PAIRS_PER_SCENE runs."""
    scene, pair = divmod(draw.number, PAIRS_PER_SCENE)
    text, points, size, pairs, seeds = _pairs(draw.seed, scene, any_head)
    start, demonstrator = map(tuple, pairs[pair])
    changes |= {"seed": seeds[pair]} if any_head else {}
    eyes = partial(open_resized, size=size)
    return draw.session(eyes, scene=text, points=points, start_deg=start, demonstrator_deg=demonstrator, **changes)


SCENES = Group(
    "Random scenes, with parallel cameras and with any head, beside the Cramér-Rao bounds.",
    tuple(
        Case(name, partial(in_scenes, any_head=any_head, **changes), measure=measures.of_scene, max_motions=500)
        for name, any_head, changes in (
            ("parallel, equal cameras", False, {}),
            ("any head, not rectified", True, {"rectify": "off"}),
            ("any head, rectified", True, {}),
            ("any head, not rectified, 0.25 px, 25 frames", True, {"rectify": "off", **NOISY}),
            ("any head, rectified, 0.25 px, 25 frames", True, NOISY),
        )
    ),
    measures=measures.OF_SCENE,
)


# Bodies drawn at random


RIGID = ((4, 5, 6, 7), (2, 3, 4, 5, 6, 7), (0, 1, 2, 3))  # links: forearm and hand, all moving links, the others


def on_surface(
    draw: Draw, count: int, links: Sequence[Sequence[int]] = (), hidden: float | None = None, **changes: Any
) -> Session:
    """Points anywhere on the robot's surface. links: sets, one of which has all points; hidden: as of `SurfaceEyes`."""

    def eyes(sensor: str, scene: Scene, points: int) -> SurfaceEyes:
        chosen = links[int(draw.rng.integers(len(links)))] if links else range(len(scene.posture_deg) + 1)
        body, normals = surface_points(scene.robot, chosen, count, draw.rng)
        return SurfaceEyes(scene, body, None if hidden is None else normals, hidden or 0.0)

    return posed(draw, open_eyes=eyes, tries=MAX_BODIES, **changes)


def marked(draw: Draw, symmetric: bool, **changes: Any) -> Session:
    """Markers on both sides of an arm's plane, or between the sides."""
    text, body = draw_marked_arm(draw.rng, symmetric)
    return posed(draw, open_eyes=lambda sensor, scene, points: SurfaceEyes(scene, body, None), scene=text, **changes)


def distant(draw: Draw, **changes: Any) -> Session:
    """A demonstrator near or far, before a short or a long baseline."""
    return posed(draw, scene=draw_distant_scene(draw.rng), points=DISTANT_POINTS, **changes)


CLAIMS: list[tuple[str, Callable[[Draw], Session], Callable[[Run], bool]]] = [
    ("default scene", posed, arrives),
    ("16 points on rigid groups of links", partial(on_surface, count=16, links=RIGID), claims_nothing),
    *((f"{n} points, hidden by surfaces", partial(on_surface, count=n, hidden=0.0), arrives) for n in (20, 40)),
    ("20 points, hidden beyond the rim", partial(on_surface, count=20, hidden=-0.3), arrives),
    ("5 points", partial(on_surface, count=5), claims_nothing_false),
    *(
        (f"noise {px} px, {frames} frame{'s' * (frames > 1)}", partial(posed, noise_px=px, frames=frames), arrives)
        for frames in (25, 1)
        for px in (0.1, 0.25, 0.5, 1.0)
    ),
    *(
        (f"markers {where}, {px} px", partial(marked, symmetric=symmetric, noise_px=px, frames=25), arrives)
        for where, symmetric in (("on both sides", True), ("between the sides", False))
        for px in (0.0, 0.05, 0.25)
    ),
    ("demonstrator at 0.6 to 6 m, baseline 5 to 60 cm, 0.25 px", partial(distant, **NOISY), arrives),
]
CALIBRATION = Group(
    "What claims are worth: how often runs claim to have converged, how often that is true, and what they expect.",
    tuple(
        Case(name, opened, promise, measure=measures.of_claim, max_motions=300, patience=5)
        for name, opened, promise in CLAIMS
    ),
    measures=measures.OF_CLAIM,
)


# Rendered pictures, and robots of a folder

PICTURES = Group(
    "Rendered pictures: how the servos do on them and on points.",
    tuple(Case(sensor, partial(posed, sensor=sensor)) for sensor in SENSORS),
    Settings.paper(),
    quick_methods,
    in_scene=True,
)


def of_robot(draw: Draw, path: str) -> Session:
    """The scene made for a URDF: its own start and demonstrator, then random ones over its ranges."""
    scene = load_scene(path)
    start, demonstrator = scene.start_deg, tuple(np.array(scene.posture_deg)[scene.moving].tolist())
    if draw.number:
        low, high = np.transpose(scene.range_deg)
        start, demonstrator = map(tuple, draw.rng.uniform(low, high, (draw.number, 2, len(low)))[-1].tolist())
    points = scene.layout_near(draw.settings.points)
    return draw.session(scene=path, points=points, start_deg=start, demonstrator_deg=demonstrator)


def robots(folder: Path) -> list[Case]:
    """Return a case for each URDF below a folder, in order. Raises ValueError if there is none."""
    found = [folder] if folder.suffix.lower() == ".urdf" else sorted(folder.rglob("*"))
    found = [path for path in found if path.suffix.lower() == ".urdf" and path.is_file()]
    if not found:
        raise ValueError(f"{folder}: no .urdf file there")
    return [
        Case(str(path), partial(of_robot, path=str(path)), max_motions=500, patience=100, generator=of_study)
        for path in found
    ]


ROBOTS = Group("Every URDF of a folder, in the scene made for it.", settings=Settings(), of_folder=robots)


# Points without names


def unnamed(
    draw: Draw,
    points: Sequence[int] = (16,),
    noises_px: Sequence[float] = (0.0, 0.1, 0.25),
    missing: int = 0,
    extra: int = 0,
    kind: str = "",
    **changes: Any,
) -> Session:
    """The demonstrator's points in an unknown order. Counts and noises take turns from run to run.

    missing: points of the demonstrator that are hidden; extra: points seen beside it that are not the body's.
    """
    count, noise_px = (cells := list(product(points, noises_px)))[draw.number % len(cells)]
    eyes = partial(other.OtherPoints.open, missing=missing, extra=extra, seed=[draw.seed, draw.number])
    changes |= {"noise_px": noise_px}
    if kind == "any head":
        return any_head(draw, open_eyes=eyes, **changes)
    if kind == "symmetric":
        text, markers = draw_marked_arm(draw.rng, symmetric=True)
        body = [(int(link), *place) for link, place in zip(markers.link, markers.local.tolist())]
        return posed(draw, open_eyes=eyes, scene=text, body_points=tuple(body), **changes)
    return posed(draw, open_eyes=eyes, points=count, **changes)


COUNTS = (10, 16, 20)
NAMINGS: list[tuple[str, dict[str, Any]]] = [
    *((f"{n} points, {px:g} px", {"points": [n], "noises_px": [px]}) for n, px in product(COUNTS, (0.0, 0.1, 0.25))),
    ("one missing", {"points": COUNTS, "missing": 1}),
    ("one extra", {"points": COUNTS, "extra": 1}),
    ("one missing and one extra", {"points": COUNTS, "missing": 1, "extra": 1}),
    ("two missing", {"points": COUNTS, "missing": 2}),
    ("iiwa", {"points": [10], "scene": "iiwa"}),
    *((scene, {"scene": scene}) for scene in ("panda-toed", "panda-verged", "panda-facing")),
    *((f"any head, {px:g} px", {"noises_px": [px], "kind": "any head"}) for px in (0.0, 0.25)),
    *((f"symmetric markers, {px:g} px", {"noises_px": [px], "kind": "symmetric"}) for px in (0.0, 0.1)),
]
UNMATCHED = Group(
    "Points without names: how often they are found, and whether runs end as with names.",
    tuple(
        Case(f"{name}{also}", partial(unnamed, matched=bool(also), **kind), measure=measures.of_names, max_motions=200,
             unnamed=not also)
        for name, kind in NAMINGS
        for also in ("", ", with names")
    ),
    Settings(),
    measures=measures.OF_NAMES,
)  # fmt: skip


# Demonstrators and arms that are not as the method assumes

SHORT = 0.1, 0.3  # share of a motion by which an arm stops short
SEVERAL = 5  # postures of a demonstrator


def misfit(draw: Draw, eyes: Any = None, offset_deg: float | None = None, **changes: Any) -> Session:
    """A demonstrator seen by eyes of `demonstrators`, which draw the misfit of this run."""
    draw.notes["offset_deg"] = offset_deg
    opened = (lambda sensor, scene, points: eyes(draw.rng, scene, points)) if eyes else open_eyes
    return posed(draw, offset_deg, opened, **{"points": 16, **NOISY, **changes})


def short(draw: Draw) -> Session:
    """An arm that stops short of every commanded posture."""
    session = misfit(draw)
    if isinstance(session.embodiment, SimulatedRobot):
        session.embodiment.arm = other.StopsShort(session.scene, float(draw.rng.uniform(*SHORT)))
    return session


def several(session: Session, draw: Draw, max_motions: int, patience: int) -> RunResult:
    """Imitate SEVERAL postures of the demonstrator, one after the other; the last one counts."""
    result = session.run(max_motions, patience)
    for _ in range(1, SEVERAL):
        draw.notes.setdefault("earlier", []).append(session.snapshot.theta_demo)
        postures = draw_postures(session.scene, draw.rng, draw.notes["offset_deg"])
        session.pose(np.radians(postures["demonstrator_deg"]))
        result = session.run(session.snapshot.motion + max_motions, patience)
    return result


def _misfit_case(name: str, word: str, opened: Any, other_links: bool = False, **more: Any) -> Case:
    measure = partial(measures.of_misfit, word=word, other_links=other_links)
    return Case(name, opened, Says(word), measure=measure, **more)


ANOTHER_BODY = str(MisfitKind.ANOTHER_BODY)
MISFITS = Group(
    "Misfits: whether the learner notices that a body, a head or an arm is not as assumed, and names the reason.",
    (
        _misfit_case("none", "", misfit),
        *(
            _misfit_case(f"moving joints ±{share:.0%}{also}{postures}", ANOTHER_BODY,
                         partial(misfit, eyes=partial(other.moving_joints, share), **seven), True, **more)
            for postures, more in (("", {}), (", five postures", {"drive": several}))
            for share, also, seven in ((0.05, "", {}), (0.1, "", {}),
                                       (0.05, ", seven joints", {"joints": SEVEN["joints"], "offset_deg": 30.0}))
        ),
        *(
            _misfit_case(name, str(word), partial(misfit, eyes=eyes))
            for name, word, eyes in (
                ("every link ±5%", ANOTHER_BODY, partial(other.every_link, 0.05)),
                ("every link ±10%", ANOTHER_BODY, partial(other.every_link, 0.1)),
                ("one point elsewhere", MisfitKind.POINT, other.point),
                ("points of one link elsewhere", MisfitKind.LINK_POINTS, other.link_points),
                ("three to five points mixed up", MisfitKind.MIXED_UP, other.mixed_up),
                ("two heads", MisfitKind.TWO_HEADS, other.other_head),
                ("mirrored", MisfitKind.MIRRORED, other.mirrored),
                ("a lens bends the images", MisfitKind.LENS, other.lens),
            )
        ),
        _misfit_case("arm stops short", str(MisfitKind.ARM), short),
    ),
    Settings(),
    measures=measures.OF_MISFIT,
)  # fmt: skip

GROUPS: dict[str, Group] = {
    "success": SUCCESS,
    "grid": GRID,
    "robustness": ROBUSTNESS,
    "tracking": TRACKING,
    "scenes": SCENES,
    "calibration": CALIBRATION,
    "pictures": PICTURES,
    "robots": ROBOTS,
    "unmatched": UNMATCHED,
    "misfits": MISFITS,
}
