"""The state that a step of a lesson shows: scene, world, and the images at its start. Scenes are those of the step's
settings, with other fields where the step gives some, or with the eyes moved."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from dataclasses import replace as changed
from functools import cached_property
from typing import Any

import msgspec
import numpy as np

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.eyes import open_eyes
from viewimit.simulation.scene import Head, Scene, extended, load_scene
from viewimit.simulation.world import World

replace = msgspec.structs.replace
EYE_SLIDERS = ("distance", "baseline")  # sliders that move the eyes


@dataclass(frozen=True, eq=False)
class Situation:
    """The state that a step shows. Scene, world and images are computed when first used. Two situations are equal if
    settings, scene and eyes are: then they have the same maps, clouds and runs."""

    settings: Settings
    scene_fields: Mapping[str, Any] = field(default_factory=dict)  # of the scene file, that the step changes
    chosen: int | None = None  # index of the body point that the step is about
    race: tuple[str, ...] = ()  # servos that are run from the step's start
    goal: float | None = None  # px², below which E is brought
    sliders: Mapping[str, float] = field(default_factory=dict)  # of EYE_SLIDERS, where they stand

    @cached_property
    def _key(self) -> bytes:
        return msgspec.json.encode([self.settings, self.scene_fields, self.sliders], order="deterministic")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Situation) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @cached_property
    def scene(self) -> Scene:
        """The scene of the settings, with the step's changes."""
        settings = self.settings
        scene = load_scene(settings.scene, settings.robot, settings.joints, body_points=settings.body_points)
        scene = extended(scene, dict(self.scene_fields)) if self.scene_fields else scene
        for name, value in self.sliders.items():
            scene = move_eyes(scene, name, value)
        return scene

    @property
    def points(self) -> int:
        """The layout of body points, by their number."""
        return self.scene.layout_near(self.settings.points)

    def session(self, **fields: Any) -> Session:
        """Begin a session in the scene, with some of the settings changed."""
        opener = lambda sensor, scene, points: open_eyes(sensor, self.scene, points)
        return Session(replace(self.settings, **fields), open_eyes=opener)

    @cached_property
    def start(self) -> Snapshot:
        """The snapshot at the start."""
        return self.session().snapshot

    @cached_property
    def world(self) -> World:
        """The scene with its layout of points."""
        return World(self.scene, self.points)

    def with_settings(self, **fields: Any) -> "Situation":
        """Return the same step with other settings."""
        return changed(self, settings=replace(self.settings, **fields))

    def with_eyes(self, **sliders: float) -> "Situation":
        """Return the same step with the eyes moved, by the names of EYE_SLIDERS."""
        return changed(self, sliders={**self.sliders, **sliders})


def move_eyes(scene: Scene, slider: str, value: float) -> Scene:
    """Return a scene with its eyes moved. slider: "distance", times the distance from the middle between the gaze
    points, with longer focal lengths, or "baseline", the distance of the eyes from each other [cm]."""
    if slider == "distance":
        return _at_distance(scene, value)
    if slider == "baseline":
        return replace(scene, head=replace(scene.head, baseline=value / 100))
    raise ValueError(f"no slider {slider!r} moves the eyes; there are {', '.join(EYE_SLIDERS)}")


def _at_distance(scene: Scene, times: float) -> Scene:
    """Return the scene after a dolly zoom: the head moves back from the middle between its gaze points, to `times` its
    distance (rms), and focal lengths grow until both arms' points spread as far in the images as before."""
    head = scene.head
    gazes = np.array([head.gaze_demonstrator, head.gaze_learner])
    middle = gazes.mean(0)
    back, spread = np.array(head.position) - middle, ((gazes - middle) ** 2).sum(1).mean()
    near = back @ back
    position = middle + np.sqrt((times**2 * (near + spread) - spread) / near) * back
    moved = replace(scene, head=replace(head, position=tuple(position.tolist())))
    return replace(moved, head=_zoomed(moved.head, _spread_px(scene) / _spread_px(moved)))


def _spread_px(scene: Scene) -> float:
    """Root mean square distance of both arms' points from their middle, at rest, over the four images."""
    world, theta = World(scene, scene.layout_near(10)), np.radians(scene.posture_deg)[scene.moving]
    images = np.concatenate([world.demo_images(theta)[0], world.own_images(theta)[0]], 1)
    return float(np.sqrt(((images - images.mean(0)) ** 2).sum(0).mean()))


def _zoomed(head: Head, by: float) -> Head:
    eye = lambda one: one if one.focal is None else replace(one, focal=(by * one.focal[0], by * one.focal[1]))
    return replace(head, focal=by * head.focal, left=eye(head.left), right=eye(head.right))
