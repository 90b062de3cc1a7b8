"""The session of a lesson, at a step of it: in the step's scene, with what was seen since it began."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
from numpy.typing import NDArray

from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.appearance import Bodies, Silhouettes
from viewimit.simulation.robot import link_meshes
from viewimit.simulation.world import World

from .dealing import deal, deal_start
from .format import Step, settings_of
from .scenes import SLIDERS, Staging

replace = msgspec.structs.replace


class StepSession:
    """moments: what was seen since the step began, the last of them shown."""

    def __init__(self):
        self.session, self.staging = Session(), Staging()
        self.moments: list[Snapshot] = [self.session.snapshot]
        self._silhouettes: tuple[World, Silhouettes] | None = None

    @property
    def bodies(self) -> Bodies:
        """What both arms look like."""
        world = self.session.world
        if self._silhouettes is None or self._silhouettes[0] is not world:
            meshes = {link: mesh.vertices for link, mesh in link_meshes(world.scene.robot).items()}
            self._silhouettes = world, Silhouettes(meshes, world)
        return self._silhouettes[1].bodies(self.moments[-1])

    def rest(self) -> None:
        """Where it is; what was seen before does not count."""
        self.moments = [self.session.snapshot]

    def begin(
        self, step: Step, fields: Mapping[str, Any], sliders: Mapping[str, float], dealt: Step | None, seed: int
    ) -> None:
        """In the step's scene. fields: of `Settings`; sliders: where they stand, by name; dealt: the step whose scene
        and start are dealt by the seed, None for none."""
        settings = settings_of(fields)
        drawn, head = deal(dealt.dealt, settings, seed) if dealt and dealt.dealt else ({}, {})
        settings = replace(settings, **drawn)
        moved = {name: value for name, value in sliders.items() if name in SLIDERS}
        staging = Staging(step.scene, head, moved)
        if staging == self.staging:
            self.session.begin(settings)
        else:
            self.staging, self.session = staging, Session(settings, open_eyes=staging.open_eyes)
        if dealt:
            start = deal_start(self.session.scene, self.session.snapshot.theta_demo, seed)
            self.session.begin(replace(settings, start_deg=start))
        self.rest()

    def turn_learner(self, joint: int, angle: float) -> None:
        """By hand. joint: of those that move, from 1; angle: rad."""
        theta = self.moments[-1].theta.copy()
        theta[joint - 1] = angle
        self.move_learner(theta)

    def move_learner(self, theta: NDArray) -> None:
        """By hand. theta: (m,) rad."""
        now = self.moments[-1]
        where = {"motion": now.motion + 1, "commanded": theta, "look": now.look + 1}
        self.moments.append(self.session.observe(theta, now, **where))

    def turn_demonstrator(self, joint: int, angle: float) -> None:
        """joint: of those that move, from 1; angle: rad."""
        theta = self.session.snapshot.theta_demo.copy()
        theta[joint - 1] = angle
        self.session.pose(theta)
        self.moments = [self.moments[0], self.session.snapshot]

    def change(self, **fields) -> None:
        """Some of the settings."""
        self.session.change(**fields)
        self.rest()
