"""Scenes in which the demonstrator stands near or far, and the head's baseline is short or long.

The demonstrator is moved along the line of sight: the head looks in the same direction at it.
"""

import numpy as np

from ...simulation.scene import load_scene

SCENE = "panda"
DISTANCE_M = 0.6, 6.0  # on the ground, from the head to the demonstrator's base
BASELINE_M = 0.05, 0.60
POINTS = 16


def draw(rng: np.random.Generator) -> str:
    """Return a scene's text, distance and baseline each drawn evenly on a logarithmic scale."""
    distance, baseline = (float(np.exp(rng.uniform(*np.log(span)))) for span in (DISTANCE_M, BASELINE_M))
    return scene_text(distance, baseline)


def scene_text(distance_m: float, baseline_m: float) -> str:
    """Return the text of SCENE with the demonstrator so far from the head, and that baseline."""
    scene = load_scene(SCENE)
    head, base, gaze = map(np.array, (scene.head.position, scene.demonstrator.position, scene.head.gaze_demonstrator))
    away = base[:2] - head[:2]
    shift = (distance_m / np.linalg.norm(away) - 1) * np.append(away, 0.0)
    return (
        f'extends = "{SCENE}"\n'
        f"[head]\nbaseline = {baseline_m}\ngaze_demonstrator = {(gaze + shift).tolist()}\n"
        f"[demonstrator]\nposition = {(base + shift).tolist()}\n"
    )
