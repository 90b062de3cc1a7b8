"""The page's drawings of every moment of a session."""

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
from .. import svg
from ..curves import draw_curve_pair
from ..images import planes
from ..images.panel import draw_images
from ..images.planes import Windows, holds, image_windows
from ..landscape import LandscapePicture
from ..relief import shades
from ..status import describe, describe_truth, draw_status
from .dedupe import Woven, weave

MOST_MOMENTS = 150  # of a longer run they are spread evenly
MOST_LANDSCAPES = 24  # one for each posture of the demonstrator that is looked at
LOOKS_BACK = 5  # motions
MOST_IMAGES = 2400  # of all points at all moments
FOLLOWS = "The landscape follows the demonstrator."
HILLS = 12, 24  # rows and columns of a small landscape's shades
LEARNERS_OWN = ("start_deg", "servo", *disturbances(ArmDisturbance))
COARSE_DEG, FINE_DEG = 4.0, 1.0  # a tenth of the time or less; what is shown in the end
TOO_FEW = "fewer than five points are seen in all four images"


class Appearance:
    """Of one world. first: a moment whose postures the windows are to show."""

    def __init__(self, world: World, first: Snapshot):
        meshes = link_meshes(world.scene.robot)
        self._world = world
        self._silhouettes = Silhouettes({link: mesh.vertices for link, mesh in meshes.items()}, world)
        self._held = [first.theta, first.theta_demo]
        self._windows = image_windows(reachable_image_points(world, self._held), world.scene.head.image)

    def of(self, moment: Snapshot) -> tuple[Bodies, Windows]:
        """With many joints an arm may leave the windows, which then widen."""
        if len(moment.theta) > 2 and not holds(self._windows, arm_image_points(self._world, moment)):
            self._held += [moment.theta, moment.theta_demo]
            self._windows = image_windows(reachable_image_points(self._world, self._held), self._world.scene.head.image)
        return self._silhouettes.bodies(moment), self._windows


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


@dataclass
class Panels:
    """One entry a moment, HTML: four images, for each of `points`, the chosen one, claims (what the learner says beside
    what is true), E and joint angles over the motions, the path over the landscape; places: of all points in l,
    r, L and R, px of the drawing, [] of one that is not seen there; ground: which of `grounds` lies under the path."""

    points: list[int | None] = field(default_factory=list)
    images: list[Woven] = field(default_factory=list)
    places: list[list[list[list[float]]]] = field(default_factory=list)
    claims: list[str] = field(default_factory=list)
    conflict: list[str] = field(default_factory=list)
    angles: list[str] = field(default_factory=list)
    path: list[str] = field(default_factory=list)
    ground: list[int] = field(default_factory=list)
    grounds: list[str] = field(default_factory=list)


def kept_motions(history: Sequence[Snapshot]) -> list[int]:
    """Of the moments that a replay shows: no more than MOST_MOMENTS."""
    there = [k for k, moment in enumerate(history) if moment.motion == k]  # others have been thinned out before
    return [there[i] for i in svg.thinned(len(there), MOST_MOMENTS)]


def farthest_off(moment: Snapshot) -> int | None:
    """The point with the largest residual, which shows best what a conflict is; None without a transfer."""
    return None if moment.transfer is None else int(np.argmax(np.nansum(moment.e**2, -1)))


def offered_points(session: Session, motions: Sequence[int], chosen: int | None) -> list[int | None]:
    """Body points whose construction the images can show, None for no construction: all, unless that were too many."""
    everything = range(len(session.world.body))
    if len(everything) * len(motions) > MOST_IMAGES:
        return [chosen]
    return [*everything] if chosen is not None else [None, *everything]


def draw_panels(session: Session, motions: Sequence[int], chosen: int | None) -> Panels:
    """Of a session in a scene, at these motions. chosen: a body point, of `offered_points`."""
    history, scene = session.history, session.scene
    panels = Panels(offered_points(session, motions, chosen))
    appearance = Appearance(session.world, history[0])
    for k in motions:  # windows have widened before the first is drawn
        appearance.of(history[k])
    landscapes = _Landscapes(session, [history[k] for k in motions])
    last = history[-1].motion
    assessment = assess(session) if session.cursor == last and history[-1].status.is_at_rest else None
    for k in motions:
        moment, made = history[k], landscapes.of(history[k])
        bodies, windows = appearance.of(moment)
        panels.images.append(weave([_images(moment, bodies, windows, point) for point in panels.points]))
        panels.places.append(_places(moment, windows))
        before, joints = history[max(k - LOOKS_BACK, 0) : k], scene.moving_joints
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
        point = None  # it had fewer then
    built = None if point is None else construct(moment, point)
    return draw_images(moment, bodies, windows, point, construction=built)


def _places(moment: Snapshot, windows: Windows) -> list[list[list[float]]]:
    views = moment.views
    images = np.concatenate([views.demo, views.own], 1).reshape(-1, 4, 2).transpose(1, 0, 2)
    placed = np.round(planes.placed(images, windows[False], "lrLR"), 1).tolist()
    return [[place if seen else [] for place, seen in zip(*each)] for each in zip(placed, views.visible.T.tolist())]


class _Landscapes:
    """Each computed when it is first asked for, and once."""

    def __init__(self, session: Session, moments: Sequence[Snapshot]):
        self._world = session.world
        self._many = len({landscape_key(moment) for moment in moments}) > MOST_LANDSCAPES
        self._made: dict[tuple, MadeLandscape] = {}

    def of(self, moment: Snapshot) -> MadeLandscape:
        key = () if self._many else landscape_key(moment)
        if key not in self._made:
            self._made[key] = self._make(moment)
        return self._made[key]

    def _make(self, moment: Snapshot) -> MadeLandscape:
        if self._many:
            return MadeLandscape(self._world, LandscapePicture(None, self._world.scene, moment, FOLLOWS), None)
        if moment.transfer is None and not moment.usable.any():
            return MadeLandscape(self._world, LandscapePicture(None, self._world.scene, moment, TOO_FEW), None)
        return make_landscape(self._world, moment)
