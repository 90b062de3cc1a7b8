"""The script and the styles of the article's live figures, with the scenes that all of them share."""

import json
from functools import cache
from pathlib import Path
from typing import Any

from viewimit.simulation.scene import Scene, extended, load_scene

from ..engine_scene import describe_hulls, engine_scene
from ..lessons.situation import move_eyes
from ..page import with_few_points
from ..replay import bundle

HERE = Path(__file__).parent
FIGURES = "lines", "crossing", "assumption", "bowl", "servo", "distance", "points"  # in the article's order
SCENE = "panda"
TURNED = {"demonstrator": {"position": [0.95, 0.825, 0.4], "yaw_deg": -45}}  # in which the smallest E is far off
TIMES = [10 ** (k / 24) for k in range(25)]  # the distance of the eyes from the arms
BASELINES_CM = range(10, 101, 5)


@cache
def script() -> str:
    """Return the figures and their data as one script, which asks nobody for anything."""
    data = json.dumps(_data(), separators=(",", ":"))
    return f"(() => {{\n{bundle('article/article.js')}\nbegin({data});\n}})();\n"


@cache
def styles() -> str:
    """Return what the figures need beside the styles of the drawings."""
    return "".join((HERE / name).read_text("utf-8") for name in ("../lessons/figures/figures.css", "article.css"))


def _data() -> dict[str, Any]:
    """What article.js documents as Data."""
    scene = load_scene(SCENE)
    turned = extended(scene, TURNED)
    return {
        "scene": engine_scene(with_few_points(scene)),
        "turned": engine_scene(turned),
        "hulls": describe_hulls(scene.robot),
        "distances": [_rig(turned, "distance", times) for times in TIMES],
        "baselines": [_rig(scene, "baseline", float(cm)) for cm in BASELINES_CM],
    }


def _rig(scene: Scene, slider: str, value: float) -> dict[str, Any]:
    """The cameras of a scene whose eyes are moved."""
    return {"value": value, "cameras": engine_scene(move_eyes(scene, slider, value))["cameras"]}
