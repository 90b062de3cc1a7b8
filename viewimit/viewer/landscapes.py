"""Landscapes of E as they are drawn for a viewer: what they depend on, how finely they are computed."""

from dataclasses import dataclass

import numpy as np

from ..analysis.landscape import Landscape, conflict_at, grid_axes, landscape_over
from ..analysis.observability import joint_uncertainty
from ..drawing.landscape import LandscapePicture
from ..drawing.relief import shades
from ..loop.settings import disturbances
from ..loop.snapshot import Snapshot
from ..simulation.disturbances import ArmDisturbance
from ..simulation.world import World

HILLS = 12, 24  # rows and columns of a small landscape's shades
LEARNERS_OWN = ("start_deg", "servo", *disturbances(ArmDisturbance))
COARSE_DEG, FINE_DEG = 4.0, 1.0  # a tenth of the time or less; what is shown in the end
TOO_FEW = "fewer than five points are seen in all four images"


@dataclass(frozen=True, eq=False)
class MadeLandscape:
    """E over all postures, drawn. E_true: px², with the learner in the demonstrator's posture. about: what was seen, if
    that is to be made anew, finer; hills: as `shades` has them, b"" without a landscape."""

    world: World
    picture: LandscapePicture
    E_true: float | None
    about: Snapshot | None = None
    hills: bytes = b""


def landscape_key(snapshot: Snapshot, but: tuple[str, ...] = ()) -> tuple:
    """Everything that E over the postures depends on: all settings but where the learner starts and how it moves, and
    whether images are rectified and points exchanged back.

    but: further settings to leave out.
    """
    settings, but = snapshot.settings, (*LEARNERS_OWN, *but)
    chosen = (getattr(settings, name) for name in settings.__struct_fields__ if name not in but)
    return *chosen, snapshot.rectification is not None, snapshot.exchanged


def compute(world: World, snapshot: Snapshot, step_deg: float = FINE_DEG) -> Landscape | None:
    """E around the demonstrator as the learner has seen it; None unless two joints move."""
    if len(world.scene.moving_joints) != 2:
        return None
    views = snapshot.views
    return landscape_over(world, snapshot.fit, views.demo, views.visible[:, :2], grid_axes(world, step_deg))


def make_landscape(world: World, snapshot: Snapshot, step_deg: float = FINE_DEG) -> MadeLandscape:
    """For the transfer that is used."""
    made = compute(world, snapshot, step_deg)
    views, theta = snapshot.views, snapshot.theta_demo
    seen = world, snapshot.fit, views.demo, views.visible[:, :2]
    E_true = float(conflict_at(*seen, theta[:, None])[0, 0])
    spread = joint_uncertainty(*seen, theta)
    picture = LandscapePicture(made, world.scene, snapshot, TOO_FEW, spread)
    coarse = made is not None and step_deg > FINE_DEG
    hills = b"" if made is None else shades(made.E, HILLS)
    return MadeLandscape(world, picture, E_true if np.isfinite(E_true) else None, snapshot if coarse else None, hills)
