"""What a step of a lesson shows, computed by the library: scene, world and what is seen at the start.

Scenes are those of the step's settings, with other fields where the step gives some, or with other eyes.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.eyes import SimulatedEyes, open_eyes
from viewimit.simulation.scene import Eye, Head, Scene, extended, load_scene
from viewimit.simulation.world import World

replace = msgspec.structs.replace


@dataclass(frozen=True, eq=False)
class Situation:
    """The state that a step shows, and what is computed from it on demand."""

    settings: Settings
    scene_fields: Mapping[str, Any] = field(default_factory=dict)  # of the scene file, that the step changes
    chosen: int | None = None  # index of the body point that the step is about
    race: tuple[str, ...] = ()  # servos that are run from the step's start
    goal: float | None = None  # px², below which E is brought
    sliders: Mapping[str, float] = field(default_factory=dict)  # "distance", "baseline": where the eyes are moved to

    @cached_property
    def scene(self) -> Scene:
        """The scene of the settings, with the step's changes."""
        settings = self.settings
        scene = load_scene(settings.scene, settings.robot, settings.joints)
        scene = extended(scene, dict(self.scene_fields)) if self.scene_fields else scene
        for name, value in self.sliders.items():
            scene = moved_eyes(scene, self.settings.points, name, value)
        return scene

    def session(self, **changes: Any) -> Session:
        """Begin a session in the scene, with some of the settings changed."""

        def opener(sensor: str, scene: Scene, points: int) -> SimulatedEyes:
            return open_eyes(sensor, self.scene, points)

        return Session(replace(self.settings, **changes), open_eyes=opener)

    @cached_property
    def start(self) -> Snapshot:
        """What is seen at the start."""
        return self.session().snapshot

    @cached_property
    def world(self) -> World:
        """The scene with the layout of points of the settings."""
        return World(self.scene, self.settings.points)

    def changed(self, **fields: Any) -> "Situation":
        """Return the same step with other settings."""
        return Situation(
            replace(self.settings, **fields), self.scene_fields, self.chosen, self.race, self.goal, self.sliders
        )

    def with_eyes(self, **sliders: float) -> "Situation":
        """Return the same step with the eyes moved."""
        moved = {**self.sliders, **sliders}
        return Situation(self.settings, self.scene_fields, self.chosen, self.race, self.goal, moved)


def moved_eyes(scene: Scene, points: int, slider: str, value: float) -> Scene:
    """Move the eyes of a scene.

    Parameters
    ----------
    scene : Scene
    points : int
        Layout of body points, whose size in the images a dolly zoom keeps.
    slider : {"distance", "baseline"}
        "distance": times the distance from the middle between the gaze points, with longer focal lengths;
        "baseline": distance of the eyes from each other [cm].
    value : float

    Raises
    ------
    ValueError
        For another slider.
    """
    if slider == "distance":
        return _at_distance(scene, points, value)
    if slider == "baseline":
        return replace(scene, head=replace(scene.head, baseline=value / 100))
    raise ValueError(f"no slider {slider!r} moves the eyes; there are distance, baseline")


EYE_SLIDERS = ("distance", "baseline")


def _at_distance(scene: Scene, points: int, times: float) -> Scene:
    """Dolly zoom: the head moves back from the middle between its gaze points until its distance from them, root mean
    square, is so many times as long. Focal lengths grow until both arms' points spread as far in the images as before.
    """
    head = scene.head
    gazes = np.array([head.gaze_demonstrator, head.gaze_learner])
    middle = gazes.mean(0)
    back, aside = np.array(head.position) - middle, ((gazes - middle) ** 2).sum(1).mean()
    near = back @ back
    position = middle + np.sqrt((times**2 * (near + aside) - aside) / near) * back
    moved = replace(scene, head=replace(head, position=tuple(position.tolist())))
    return replace(moved, head=_zoomed(moved.head, _spread_px(scene, points) / _spread_px(moved, points)))


def _spread_px(scene: Scene, points: int) -> float:
    """Root mean square distance of both arms' points from their middle, at rest, over the four images."""
    world, theta = World(scene, points), np.radians(scene.posture_deg)[scene.moving]
    images: NDArray[np.float64] = np.concatenate([world.demo_images(theta)[0], world.own_images(theta)[0]], 1)
    return float(np.sqrt(((images - images.mean(0)) ** 2).sum(0).mean()))


def _zoomed(head: Head, by: float) -> Head:
    def eye(one: Eye) -> Eye:
        return one if one.focal is None else replace(one, focal=(by * one.focal[0], by * one.focal[1]))

    return replace(head, focal=by * head.focal, left=eye(head.left), right=eye(head.right))
