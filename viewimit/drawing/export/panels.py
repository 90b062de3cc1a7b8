"""What drawings of a session need and is computed from its world: silhouettes and landscapes."""

from dataclasses import dataclass

import numpy as np

from ...analysis.landscape import Landscape, conflict_at, grid_axes, landscape_over, seen_from
from ...analysis.observability import joint_uncertainty
from ...geometry.arrays import Floats
from ...loop.settings import disturbances
from ...loop.snapshot import Snapshot
from ...simulation.appearance import Bodies, Silhouettes, points_in_images
from ...simulation.disturbances import ArmDisturbance
from ...simulation.robot import link_meshes
from ...simulation.world import World
from ..images.planes import Windows, holds, image_windows
from ..landscape import LandscapePicture

TOO_FEW = "fewer than five points are seen in all four pictures"
NO_NAMES = "the points have no names yet"
WIDER = 1.15  # factor by which a posture that leaves the windows is taken to be larger
COARSE_DEG, FINE_DEG = 4.0, 1.0  # grids of a landscape: the coarse one takes a tenth of the time
START_AND_MOTION = ("start_deg", "servo", *disturbances(ArmDisturbance))  # settings without influence on E


class Appearance:
    """What both arms look like in the four images, and which part of each image is shown.

    The windows fit what has been shown so far of the run and its goal. They widen when an arm leaves them, and fit
    again when the run begins again.
    """

    def __init__(self, world: World):
        meshes = link_meshes(world.scene.robot)
        self._silhouettes = Silhouettes({link: mesh.vertices for link, mesh in meshes.items()}, world)
        self._motion = 0  # of the last moment
        self._shown: dict[str, Floats] = {}  # (k, 2) px by view, which the windows hold
        self._windows: Windows = {}

    def of(self, moment: Snapshot) -> tuple[Bodies, Windows]:
        """Return both arms' images at a moment, and the windows."""
        bodies = self._silhouettes.bodies(moment.theta_demo, moment.theta, moment.transfer)
        shown = points_in_images(bodies)
        if not self._windows or moment.motion == 0 < self._motion:
            self._fit(shown, bodies)
        elif not holds(self._windows, shown):
            # stretched about its middle, so that a slow motion does not widen the windows at every step
            middles = {view: (points.min(0) + points.max(0)) / 2 for view, points in shown.items()}
            wider = {view: middles[view] + WIDER * (points - middles[view]) for view, points in shown.items()}
            self._fit({view: np.concatenate([self._shown[view], wider[view]]) for view in shown}, bodies)
        self._motion = moment.motion
        return bodies, self._windows

    def _fit(self, shown: dict[str, Floats], bodies: Bodies) -> None:
        self._shown, self._windows = shown, image_windows(shown, bodies.frame)


@dataclass(frozen=True, eq=False)
class MadeLandscape:
    """E over all postures, drawn."""

    world: World
    picture: LandscapePicture
    E_true: float | None  # px², with the learner in the demonstrator's posture
    to_refine: Snapshot | None = None  # of a coarse landscape: the snapshot from which a finer one can be computed


def landscape_key(snapshot: Snapshot, ignored: tuple[str, ...] = ()) -> tuple:
    """Return everything on which E over the postures depends, as a key for caches.

    These are the settings without those of the start and of the motion, and whether images are rectified and points
    permuted. ignored: further settings to leave out.
    """
    settings, ignored = snapshot.settings, (*START_AND_MOTION, *ignored)
    chosen = (getattr(settings, name) for name in settings.__struct_fields__ if name not in ignored)
    return *chosen, snapshot.rectification is not None, snapshot.correspondences


def compute_landscape(world: World, snapshot: Snapshot, step_deg: float = FINE_DEG) -> Landscape | None:
    """Compute E around the demonstrator as the learner has seen it; None unless two joints move."""
    if len(world.scene.moving_joints) != 2:
        return None
    return landscape_over(*seen_from(world, snapshot), grid_axes(world, step_deg))


def make_landscape(world: World, snapshot: Snapshot, step_deg: float = FINE_DEG) -> MadeLandscape:
    """Compute and draw the landscape of the snapshot's transfer on a grid of step_deg degrees."""
    if not snapshot.views.matched:
        return MadeLandscape(world, LandscapePicture(None, world.scene, snapshot, NO_NAMES), None)
    found = compute_landscape(world, snapshot, step_deg)
    theta, seen = snapshot.theta_demo, seen_from(world, snapshot)
    E_true = float(conflict_at(*seen, theta[:, None])[0, 0])
    picture = LandscapePicture(found, world.scene, snapshot, TOO_FEW, joint_uncertainty(*seen, theta))
    coarse = found is not None and step_deg > FINE_DEG
    return MadeLandscape(world, picture, E_true if np.isfinite(E_true) else None, snapshot if coarse else None)


def largest_residual(moment: Snapshot) -> int | None:
    """Return the index of the point with the largest residual; None without a transfer."""
    return None if moment.transfer is None else int(np.argmax(np.nansum(moment.e**2, -1)))
