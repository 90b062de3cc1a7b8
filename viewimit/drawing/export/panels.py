"""The page's drawings of a session, with the computations that they need: silhouettes and landscapes."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...analysis.construction import construct
from ...analysis.landscape import Landscape, conflict_at, grid_axes, landscape_over
from ...analysis.observability import joint_uncertainty
from ...analysis.self_assessment import assess
from ...loop.session import Session
from ...loop.settings import disturbances
from ...loop.snapshot import Snapshot
from ...simulation.appearance import Bodies, Silhouettes, arm_image_points, reachable_image_points
from ...simulation.disturbances import ArmDisturbance
from ...simulation.robot import link_meshes
from ...simulation.world import World
from .. import relief, svg
from ..curves import draw_curve_pair
from ..images import planes
from ..images.panel import draw_images
from ..images.planes import Windows, holds, image_windows
from ..landscape import LandscapePicture
from ..status import describe, describe_truth, draw_status

MAX_SNAPSHOTS = 150  # of a longer run, evenly spread
MAX_LANDSCAPES = 24  # of different demonstrators' postures; with more, a sentence says that the landscape follows
MAX_IMAGES = 2400  # over all points and snapshots
TREND = 5  # snapshots before a moment that its status may mention
FOLLOWS = "The landscape follows the demonstrator."
TOO_FEW = "fewer than five points are seen in all four images"
SHADES = 12, 24  # rows and columns of a coarse landscape
COARSE_DEG, FINE_DEG = 4.0, 1.0  # grids of a landscape: the coarse one takes a tenth of the time
START_AND_MOTION = ("start_deg", "servo", *disturbances(ArmDisturbance))  # settings without influence on E


class Appearance:
    """What both arms look like in the four images, and which part of each image is shown.

    Parameters
    ----------
    world
        The scene with its cameras.
    first
        A snapshot whose postures the windows must show.
    """

    def __init__(self, world: World, first: Snapshot):
        meshes = link_meshes(world.scene.robot)
        self._world = world
        self._silhouettes = Silhouettes({link: mesh.vertices for link, mesh in meshes.items()}, world)
        self._postures = [first.theta, first.theta_demo]
        self._windows = image_windows(reachable_image_points(world, self._postures), world.scene.head.image)

    def of(self, moment: Snapshot) -> tuple[Bodies, Windows]:
        """Return both arms' images at a moment, and the windows, which widen if an arm of many joints leaves them."""
        if len(moment.theta) > 2 and not holds(self._windows, arm_image_points(self._world, moment)):
            self._postures += [moment.theta, moment.theta_demo]
            self._windows = image_windows(
                reachable_image_points(self._world, self._postures), self._world.scene.head.image
            )
        return self._silhouettes.bodies(moment), self._windows


@dataclass(frozen=True, eq=False)
class MadeLandscape:
    """E over all postures, drawn."""

    world: World
    picture: LandscapePicture
    E_true: float | None  # px², with the learner in the demonstrator's posture
    to_refine: Snapshot | None = None  # of a coarse landscape: the snapshot from which a finer one can be computed
    shades: bytes = b""  # of SHADES, as `relief.shades` returns them; b"" without a landscape


def landscape_key(snapshot: Snapshot, ignored: tuple[str, ...] = ()) -> tuple:
    """Return everything on which E over the postures depends, as a key for caches.

    These are the settings without those of the start and of the motion, and whether images are rectified and points
    permuted. ignored: further settings to leave out.
    """
    settings, ignored = snapshot.settings, (*START_AND_MOTION, *ignored)
    chosen = (getattr(settings, name) for name in settings.__struct_fields__ if name not in ignored)
    return *chosen, snapshot.rectification is not None, snapshot.exchanged


def compute_landscape(world: World, snapshot: Snapshot, step_deg: float = FINE_DEG) -> Landscape | None:
    """Compute E around the demonstrator as the learner has seen it; None unless two joints move."""
    if len(world.scene.moving_joints) != 2:
        return None
    views = snapshot.views
    return landscape_over(world, snapshot.fit, views.demo, views.visible[:, :2], grid_axes(world, step_deg))


def make_landscape(world: World, snapshot: Snapshot, step_deg: float = FINE_DEG) -> MadeLandscape:
    """Compute and draw the landscape of the snapshot's transfer on a grid of step_deg degrees."""
    found = compute_landscape(world, snapshot, step_deg)
    views, theta = snapshot.views, snapshot.theta_demo
    seen = world, snapshot.fit, views.demo, views.visible[:, :2]
    E_true = float(conflict_at(*seen, theta[:, None])[0, 0])
    picture = LandscapePicture(found, world.scene, snapshot, TOO_FEW, joint_uncertainty(*seen, theta))
    coarse = found is not None and step_deg > FINE_DEG
    shades = b"" if found is None else relief.shades(found.E, SHADES)
    return MadeLandscape(world, picture, E_true if np.isfinite(E_true) else None, snapshot if coarse else None, shades)


@dataclass(frozen=True)
class DedupedHTML:
    """Drawings that differ little, as a list of the pieces that they share."""

    pieces: list[str]
    indices: list[list[int]]  # for each drawing, the indices of its pieces

    def __getitem__(self, k: int) -> str:
        return "".join(self.pieces[i] for i in self.indices[k])


def dedupe(drawings: Sequence[str]) -> DedupedHTML:
    """Cut drawings before each tag, and keep each piece once."""
    cut = [re.split("(?=<)", drawing) for drawing in drawings]
    index = {piece: i for i, piece in enumerate(dict.fromkeys(piece for pieces in cut for piece in pieces))}
    return DedupedHTML(list(index), [[index[piece] for piece in pieces] for pieces in cut])


@dataclass
class Panels:
    """The drawings of a session as HTML: one entry per snapshot in each list, except `points` and `grounds`."""

    points: list[int | None] = field(default_factory=list)  # body points that can be chosen; None for no point
    images: list[DedupedHTML] = field(default_factory=list)  # the four images, for each of `points`
    places: list[list[list[list[float]]]] = field(default_factory=list)  # by view lrLR and point: px, [] if not visible
    claims: list[str] = field(default_factory=list)  # the learner's status beside the truth
    conflict: list[str] = field(default_factory=list)  # E over the motions
    angles: list[str] = field(default_factory=list)  # joint angles over the motions
    path: list[str] = field(default_factory=list)  # over the landscape
    ground: list[int] = field(default_factory=list)  # index of the landscape under the path
    grounds: list[str] = field(default_factory=list)  # the different landscapes


def kept_motions(history: Sequence[Snapshot]) -> list[int]:
    """Choose at most MAX_SNAPSHOTS motions of a history that a replay shows."""
    available = [k for k, moment in enumerate(history) if moment.motion == k]  # long histories are thinned out
    return [available[i] for i in svg.thinned(len(available), MAX_SNAPSHOTS)]


def largest_residual(moment: Snapshot) -> int | None:
    """Return the index of the point with the largest residual; None without a transfer."""
    return None if moment.transfer is None else int(np.argmax(np.nansum(moment.e**2, -1)))


def choosable_points(session: Session, motions: Sequence[int], chosen: int | None) -> list[int | None]:
    """List the points whose construction the images can show: all, unless these would be too many images."""
    everything = range(len(session.world.body))
    if len(everything) * len(motions) > MAX_IMAGES:
        return [chosen]
    return [*everything] if chosen is not None else [None, *everything]


def draw_panels(session: Session, motions: Sequence[int], chosen: int | None) -> Panels:
    """Draw a session in a scene at these motions. chosen: a body point, of `choosable_points`."""
    history, scene = session.history, session.scene
    panels = Panels(choosable_points(session, motions, chosen))
    appearance = Appearance(session.world, history[0])
    for k in motions:  # widen the windows before the first is drawn
        appearance.of(history[k])
    landscapes = _Landscapes(session, [history[k] for k in motions])
    last = history[-1].motion
    assessment = assess(session) if session.cursor == last and history[-1].status.is_at_rest else None
    for k in motions:
        moment, made = history[k], landscapes.of(history[k])
        bodies, windows = appearance.of(moment)
        panels.images.append(dedupe([_images(moment, bodies, windows, point) for point in panels.points]))
        panels.places.append(_places(moment, windows))
        before, joints = history[max(k - TREND, 0) : k], scene.moving_joints
        said = describe(moment, before, k < last, assessment if k == last else None, joints, advises=False)
        panels.claims.append(draw_status(said, describe_truth(joints, moment.theta, moment.theta_demo)))
        conflict, angles = draw_curve_pair(history, k, made.E_true, joints)
        panels.conflict.append(conflict)
        panels.angles.append(angles)
        panels.path.append(made.picture.draw_path(history, k))
        if made.picture.html not in panels.grounds:
            panels.grounds.append(made.picture.html)
        panels.ground.append(panels.grounds.index(made.picture.html))
    return panels


def _images(moment: Snapshot, bodies: Bodies, windows: Windows, point: int | None) -> str:
    if point is not None and point >= len(moment.views.demo):
        point = None  # the body had fewer points then
    built = None if point is None else construct(moment, point)
    return draw_images(moment, bodies, windows, point, construction=built)


def _places(moment: Snapshot, windows: Windows) -> list[list[list[float]]]:
    placed = np.round(planes.placed(planes.image_points(moment.views), windows[False], "lrLR"), 1).tolist()
    visible = moment.views.visible.T.tolist()
    return [[place if seen else [] for place, seen in zip(*each)] for each in zip(placed, visible)]


class _Landscapes:
    """Landscapes of a session, each computed at its first use."""

    def __init__(self, session: Session, snapshots: Sequence[Snapshot]):
        self._world = session.world
        self._too_many = len({landscape_key(snapshot) for snapshot in snapshots}) > MAX_LANDSCAPES
        self._made: dict[tuple, MadeLandscape] = {}

    def of(self, moment: Snapshot) -> MadeLandscape:
        key = () if self._too_many else landscape_key(moment)
        if key not in self._made:
            self._made[key] = self._make(moment)
        return self._made[key]

    def _make(self, moment: Snapshot) -> MadeLandscape:
        problem = FOLLOWS if self._too_many else TOO_FEW
        if self._too_many or (moment.transfer is None and not moment.usable.any()):
            return MadeLandscape(self._world, LandscapePicture(None, self._world.scene, moment, problem), None)
        return make_landscape(self._world, moment)
