"""What a step changes of its scene: fields of the scene's file, and sliders that move the eyes, by name.

Joints and their limits stay: what is changed is where eyes and arms are, and which points are marked.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import msgspec
import numpy as np

from viewimit.simulation.eyes import SimulatedEyes, open_eyes
from viewimit.simulation.scene import Eye, Head, Scene, extended
from viewimit.simulation.world import World

from .dealing import varied

replace = msgspec.structs.replace


def at_distance(scene: Scene, points: int, times: float) -> Scene:
    """A dolly zoom: the head moves back, away from the middle between its gaze points, until it is so many times as far
    from them (root mean square); focal lengths grow until both arms' points, at rest, spread as far in the images."""
    head = scene.head
    gazes = np.array([head.gaze_demonstrator, head.gaze_learner])
    middle = gazes.mean(0)
    back, aside = np.array(head.position) - middle, ((gazes - middle) ** 2).sum(1).mean()
    near = back @ back
    position = middle + np.sqrt((times**2 * (near + aside) - aside) / near) * back
    moved = replace(scene, head=replace(head, position=tuple(position.tolist())))
    return replace(moved, head=_zoomed(moved.head, spread(scene, points) / spread(moved, points)))


def spread(scene: Scene, points: int) -> float:
    """px, root mean square over the four images: of both arms' points about their middle, both at rest."""
    world = World(scene, points)
    theta = np.radians(scene.posture_deg)[scene.moving]
    images = np.concatenate([world.demo_images(theta)[0], world.own_images(theta)[0]], 1)
    return float(np.sqrt(((images - images.mean(0)) ** 2).sum(0).mean()))


def _zoomed(head: Head, by: float) -> Head:
    def eye(one: Eye) -> Eye:
        return one if one.focal is None else replace(one, focal=(by * one.focal[0], by * one.focal[1]))

    return replace(head, focal=by * head.focal, left=eye(head.left), right=eye(head.right))


def with_baseline(scene: Scene, points: int, cm: float) -> Scene:
    """The eyes so far apart."""
    return replace(scene, head=replace(scene.head, baseline=cm / 100))


SLIDERS: Mapping[str, Callable[[Scene, int, float], Scene]] = {  # scene, layout of points, where the slider stands
    "distance": at_distance,
    "baseline": with_baseline,
}


@dataclass(frozen=True)
class Staging:
    """fields: of a scene file, that a step changes; head: what is dealt of it, by the names of `HEAD`; sliders: of
    SLIDERS, where they stand."""

    fields: Mapping[str, Any] = field(default_factory=dict)
    head: Mapping[str, float] = field(default_factory=dict)
    sliders: Mapping[str, float] = field(default_factory=dict)

    def open_eyes(self, sensor: str, scene: Scene, points: int) -> SimulatedEyes:
        """What a session looks with that takes place in the changed scene."""
        if self.fields:
            scene = extended(scene, self.fields)
        scene = varied(scene, self.head)
        for name, value in self.sliders.items():
            scene = SLIDERS[name](scene, points, value)
        return open_eyes(sensor, scene, points)
