"""The one file of the lab: scenes, presets, meshes, styles and modules, as a page that asks nobody for anything."""

from functools import cache
from typing import Any

import msgspec
import numpy as np

from viewimit.simulation.scene import Scene, load_scene
from viewimit.simulation.world import World

from ..presets import LAB_PRESETS, Preset
from ..ways import Ways, about, header
from .engine_scene import can_compute, describe_hulls, engine_scene
from .recording import lab_settings
from .replay import lab_html
from .space import Shapes, describe_robot, describe_stage

SHIPPED = "panda"
TITLE = "viewimit lab: one robot copies another from pictures"
NO_WAYS = Ways()
MAX_FACES = 12_000  # of each link's mesh; the shipped robots have fewer


def lab_page(scene: Scene | None = None, name: str = SHIPPED, ways: Ways = NO_WAYS) -> str:
    """Return the lab as one HTML page. scene: of the lab, by default the shipped one, and `name` as settings name it;
    ways: where the header's verbs lead. Raises ValueError for a scene that the lab cannot compute."""
    given = scene or load_scene(SHIPPED)
    shapes, scenes, chosen = Shapes(), {}, []
    robot = describe_robot(given.robot, shapes, MAX_FACES)
    for preset in _offered(scene):
        used = _scene_of(preset, given)
        key = "given" if used is given else preset.key
        if key not in scenes:
            page = {"scene": name if used is given else preset.settings.scene, "layouts": list(used.points)}
            postures = [np.radians(used.start_deg), np.radians(used.posture_deg)[used.moving]]
            stage = describe_stage(World(used, min(map(int, used.points))), shapes, postures)
            scenes[key] = {**engine_scene(with_few_points(used)), "stage": stage, "page": page}
        chosen.append(_preset_of_lab(preset, key, list(scenes[key]["layouts"])))
    if scene is not None:
        chosen[0] |= {"title": given.title, "says": "Press Play, and the learner copies the pose of the demonstrator."}
    data = {"scenes": scenes, "presets": chosen, "robot": robot, "hulls": describe_hulls(given.robot)}
    return lab_html(TITLE, data, shapes.packed, ways=header(ways, "play", with_about=False), about=about(ways))


def _offered(scene: Scene | None) -> list[Preset]:
    """The presets of a lab that was given a scene, or None."""
    return [preset for preset in LAB_PRESETS if scene is None or preset.settings.scene == SHIPPED]


def _scene_of(preset: Preset, given: Scene) -> Scene:
    return given if preset.settings.scene == SHIPPED else load_scene(preset.settings.scene)


def _preset_of_lab(preset: Preset, scene: str, layouts: list[str]) -> dict[str, Any]:
    """A preset as app/lab/view/address.js documents it."""
    settings = preset.settings
    return {
        "name": preset.key,
        "title": preset.name,
        "says": preset.says,
        **lab_settings(settings),
        "scene": scene,
        **({} if settings.start_deg is None else {"start": np.radians(settings.start_deg).tolist()}),
        "points": min(map(int, layouts), key=lambda count: abs(count - settings.points)),
    }


def with_few_points(scene: Scene) -> Scene:
    """Return the scene with a layout of four points as well, the first ones of the smallest it has."""
    smallest = scene.points[min(scene.points, key=int)]
    return msgspec.structs.replace(scene, points={"4": smallest[:4], **scene.points})


def _served(name: str, robot: str | None) -> Scene | None:
    """The scene of a server's lab; None for the shipped one, also in place of one that the lab cannot compute."""
    if (name, robot) == (SHIPPED, None):
        return None
    scene = load_scene(name, robot)
    return scene if can_compute(scene) else None


@cache
def served_scenes(name: str = SHIPPED, robot: str | None = None) -> dict[str, dict[str, Any]]:
    """Return the scene of each preset in the lab that `served_page` returns, as the engine has it."""
    scene = _served(name, robot)
    given = scene or load_scene(SHIPPED)
    return {preset.key: engine_scene(with_few_points(_scene_of(preset, given))) for preset in _offered(scene)}


@cache
def served_page(name: str, robot: str | None, ways: Ways = NO_WAYS) -> str:
    """Return the lab of a server that was started with this scene; of the shipped one, if the lab cannot compute it."""
    scene = _served(name, robot)
    return lab_page(ways=ways) if scene is None else lab_page(scene, name, ways)
