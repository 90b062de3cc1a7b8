"""The one file of the lab: scenes, presets, meshes, styles and modules, as a page that asks nobody for anything."""

from functools import cache
from typing import Any
from urllib.parse import urlencode

import msgspec
import numpy as np
from numpy.typing import NDArray
from viewimit.assets import ROOT

from viewimit.drawing.export.engine_scene import describe_hulls, engine_scene, require_scene
from viewimit.drawing.export.lab_methods import lab_methods
from viewimit.drawing.export.recording import lacks
from viewimit.drawing.export.replay import lab_html
from viewimit.drawing.export.space import Shapes, describe_robot, describe_stage
from viewimit.loop.settings import DISTURBANCES, Settings
from viewimit.loop.snapshot import Snapshot
from viewimit.sensing.files import parse_toml
from viewimit.simulation.scene import Scene, extended, load_scene
from viewimit.simulation.world import World

SHIPPED = "panda"
TITLE = "viewimit lab: one robot copies another from pictures"
USUAL_POINTS = 10
MAX_FACES = 12_000  # of each link's mesh; the shipped robots have fewer


class Preset(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One of the lab's experiments, described in one sentence. Angles are in degrees."""

    name: str
    title: str
    says: str
    scene: str = ""  # the scene that the lab was given, if empty
    head: dict[str, Any] = {}  # fields of the scene's head that differ
    points: int = USUAL_POINTS
    transfer: str = "epipolar"
    servo: str = "broyden"
    noise_px: float = 0.0
    missing: float = 0.0  # share of points that a picture does not show
    seed: int = 7


@cache
def presets() -> tuple[Preset, ...]:
    """Return the shipped presets, in their order."""
    fields = parse_toml(ROOT.joinpath("lab", "presets.toml").read_bytes())
    return msgspec.convert(fields["preset"], tuple[Preset, ...])


def lab_page(scene: Scene | None = None, name: str = SHIPPED) -> str:
    """Return the lab as one HTML page.

    Parameters
    ----------
    scene
        The scene of the lab, the shipped one by default. Presets of other scenes are then left out.
    name
        As settings name that scene.

    Raises
    ------
    ValueError
        For a scene of other than two moving joints, or with lenses that distort.
    """
    given = scene or load_scene(SHIPPED)
    shapes, scenes, chosen = Shapes(), {}, []
    robot = describe_robot(given.robot, shapes, MAX_FACES)
    for preset in _offered(scene):
        used = _scene_of(preset, given)
        key = preset.name if preset.scene else "given"
        if key not in scenes:
            page = {"scene": _named_on_the_page(preset, name), "layouts": list(used.points)}
            scenes[key] = {**engine_scene(with_few_points(used)), "stage": _stage(used, shapes), "page": page}
        layout = min(map(int, scenes[key]["layouts"]), key=lambda count: abs(count - preset.points))
        fields = {
            name: getattr(preset, name) for name in ("name", "title", "says", "transfer", "servo", "missing", "seed")
        }
        chosen.append({**fields, "scene": key, "points": layout, "noisePx": preset.noise_px})
    if scene is not None:
        chosen[0] |= {"title": given.title, "says": "Press Play, and the learner copies the pose of the demonstrator."}
    data = {"scenes": scenes, "presets": chosen, "robot": robot, "hulls": describe_hulls(given.robot)}
    return lab_html(TITLE, data, shapes.packed)


def _offered(scene: Scene | None) -> list[Preset]:
    """The presets of a lab that was given a scene, or None."""
    return [preset for preset in presets() if scene is None or not preset.scene]


def _scene_of(preset: Preset, given: Scene) -> Scene:
    used = load_scene(preset.scene) if preset.scene else given
    return extended(used, {"head": preset.head}) if preset.head else used


def _named_on_the_page(preset: Preset, given: str) -> str:
    """A preset's scene as `Settings.scene` takes it: its name, or the text of a scene file."""
    if not preset.head:
        return preset.scene or given
    head = "".join(f"{field} = {value}\n" for field, value in preset.head.items())
    return f'extends = "{preset.scene or given}"\n[head]\n{head}'


def with_few_points(scene: Scene) -> Scene:
    """Return the scene with a layout of four points as well, the first ones of the smallest it has."""
    smallest = scene.points[min(scene.points, key=int)]
    return msgspec.structs.replace(scene, points={"4": smallest[:4], **scene.points})


def _stage(scene: Scene, shapes: Shapes) -> dict[str, Any]:
    world = World(scene, min(map(int, scene.points)))
    demo = np.radians(scene.posture_deg)[scene.moving]
    stage = describe_stage(world, shapes, [np.radians(scene.start_deg), demo])
    return stage


@cache
def served_scenes(name: str = SHIPPED, robot: str | None = None) -> dict[str, dict[str, Any]]:
    """Return the scene of each preset in the lab that `served_page` returns, as the engine has it."""
    if (name, robot) == (SHIPPED, None):
        scene = None
    else:
        try:
            scene = load_scene(name, robot)
            require_scene(scene)
        except ValueError:
            scene = None
    given = scene or load_scene(SHIPPED)
    return {preset.name: engine_scene(with_few_points(_scene_of(preset, given))) for preset in _offered(scene)}


@cache
def served_page(name: str, robot: str | None) -> str:
    """Return the lab of a server that was started with this scene; of the shipped one, if the lab cannot compute it."""
    if (name, robot) == (SHIPPED, None):
        return lab_page()
    try:
        return lab_page(load_scene(name, robot), name)
    except ValueError:
        return lab_page()


# The address at which the lab opens in a session's state, as app/lab/view/address.js reads it.

TOLD = {  # fields that the address carries, or that are told by what they do
    "scene", "robot", "joints", "body_points", "points", "demonstrator_deg", "start_deg", "transfer", "servo",
    "noise_px", "missing", "seed", "rectify", "sensor",
}  # fmt: skip
DIGITS = 2  # of an angle in degrees


def lab_address(now: Snapshot) -> str | None:
    """Return the lab's path and fragment for a moment; None for a scene that the lab does not have.

    A servo or a transfer that the lab does not have is left to its default there; `lab_lacks` says so.
    """
    settings, found = now.settings, _presets_of(now)
    if not found or _own_bodies(now) or settings.sensor != "projected":
        return None
    fields = {
        "preset": found[0].name,
        "demo": _degrees(now.theta_demo),
        "start": _degrees(now.theta),
        "servo": settings.servo if settings.servo in lab_methods().servos else None,
        "transfer": settings.transfer if settings.transfer in lab_methods().transfers else None,
        "points": settings.points,
        "noise": settings.noise_px,
        "missing": settings.missing,
        "seed": settings.seed,
    }
    return "/lab#" + urlencode({name: value for name, value in fields.items() if value is not None}, safe=",")


def lab_lacks(now: Snapshot) -> list[str]:
    """Say what of a moment the lab's address cannot carry, each in a few words."""
    scene = [] if _presets_of(now) else ["this scene"]
    usual = Settings.paper()
    fields = (name for name in usual.__struct_fields__ if name not in TOLD and name not in DISTURBANCES)
    other = [name.replace("_", " ") for name in fields if getattr(now.settings, name) != getattr(usual, name)]
    return [*scene, *_own_bodies(now), *lacks(now), *other]


def _presets_of(now: Snapshot) -> list[Preset]:
    return [preset for preset in presets() if (preset.scene or SHIPPED) == now.settings.scene and not preset.head]


def _own_bodies(now: Snapshot) -> list[str]:
    own = {"robot": "this robot", "joints": "these joints", "body_points": "these points"}
    return [words for field, words in own.items() if getattr(now.settings, field) is not None]


def _degrees(theta: NDArray[np.float64]) -> str:
    return ",".join(f"{angle:g}" for angle in np.degrees(theta).round(DIGITS))
