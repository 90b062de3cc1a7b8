"""Editing the body points: which there are, what they tell, which one more would tell most, a file with them. Both arms
wear the same points. It uses what the simulation knows, as a person who marks an arm sees it; the learner gets only the
images of the points."""

from collections.abc import Callable
from dataclasses import dataclass

import msgspec
from numpy.typing import NDArray

from viewimit.analysis.observability import PointInformation, Proposal, best_next, find_candidates, point_information
from viewimit.estimation.views import FourViews
from viewimit.geometry.affine import MIN_POINTS
from viewimit.loop.session import Session
from viewimit.loop.settings import BodyPoint
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.scene_writing import saved_scene
from viewimit.simulation.world import World

from .choices import MAX_POINTS
from .queue import RunInBackground, Send

Lay = Callable[[tuple[BodyPoint, ...]], None]
DIGITS = 4  # of a metre
HEADING = "Body points by hand, from viewimit's page: use it by --scene, or edit it"


@dataclass(frozen=True, eq=False)
class EditedPoints:
    """on: whether they are being edited; information: what they tell, None unless they are; proposal: a point that is
    shown hollow until it is taken, proposed_in: the images of it; searching: one is on its way."""

    on: bool = False
    information: PointInformation | None = None
    proposal: Proposal | None = None
    proposed_in: FourViews | None = None
    searching: bool = False


NOT_EDITED = EditedPoints()


class PointEditing:
    """Of one session. lay(points): restarts it with these; run_in_background(make, take): make what takes
    long, then take it in the page's own time; send(name, data): a file for the visitor."""

    def __init__(self, session: Session, lay: Lay, run_in_background: RunInBackground, send: Send):
        self._session, self._lay, self._run_in_background, self._send = session, lay, run_in_background, send
        self.begun = False  # and not ended by the visitor
        self._asked: tuple[World, NDArray] | None = None  # for what a proposal is being made
        self._made: tuple[World, NDArray, Proposal] | None = None
        self._shown: tuple[tuple, EditedPoints] = (), NOT_EDITED

    @property
    def on(self) -> bool:
        return self.begun and self._session.settings.sensor == "projected"

    def toggle(self) -> None:
        """Begin or end. Raises ValueError where pictures show markers."""
        self._asked = self._made = None
        if self.on:
            self.begun = False
            return
        if self._session.settings.sensor == "rendered":
            raise ValueError("camera pictures show the markers that the arm wears: switch them off to edit points")
        self.begun = True

    def let_go(self) -> bool:
        """Of a proposal, or else of editing. Whether there was one of them."""
        if self.proposal is None and self.on:
            self.begun = False
            return True
        there, self._made = self.proposal is not None, None
        return there

    def place(self, link: int, local: tuple[float, float, float]) -> None:
        """Another point, (3,) m in the frame of a link, 0 = base. Raises ValueError."""
        self._require_on()
        points = self._points()
        if len(points) >= MAX_POINTS:
            raise ValueError(f"there are {MAX_POINTS} points already: remove one first")
        x, y, z = (round(value, DIGITS) for value in local)
        self._lay((*points, (link, x, y, z)))

    def remove(self, point: int | None) -> None:
        """By its index. Raises ValueError for none, and for one of the last that any transfer needs."""
        self._require_on()
        points = self._points()
        if point is None:
            raise ValueError("no point is chosen: click one, or press N")
        if len(points) <= MIN_POINTS:
            raise ValueError(f"no transfer can do with fewer than {MIN_POINTS} points: place another one first")
        self._lay((*points[:point], *points[point + 1 :]))

    def propose_or_take(self) -> bool:
        """Ask for the point that would tell most; or place the one that is proposed. Whether one was placed."""
        self._require_on()
        if (proposal := self.proposal) is not None:
            x, y, z = proposal.point.local[0].tolist()
            self.place(int(proposal.point.link[0]), (x, y, z))
            return True
        if not self._searching:
            world, moment = self._session.world, self._session.snapshot
            self._asked = world, moment.theta_demo
            self._run_in_background(lambda: _search(world, moment), self._take)
        return False

    def _take(self, made: tuple[World, Snapshot, Proposal] | Exception) -> None:
        """A proposal that was made in the background, if it is still of these points in this posture."""
        searching, self._asked = self._searching, None
        if isinstance(made, Exception):
            raise ValueError(f"no point to propose: {made}")
        world, moment, proposal = made
        if searching and self.on and self._still(world, moment.theta_demo):
            self._made = world, moment.theta_demo, proposal

    @property
    def proposal(self) -> Proposal | None:
        if self._made is None or not self.on or not self._still(*self._made[:2]):
            self._made = None
            return None
        return self._made[2]

    @property
    def shown(self) -> EditedPoints:
        """What a page shows of it; the same object until something changes."""
        now = self._session.snapshot
        if not self.on:
            return NOT_EDITED
        key = now, self.proposal, self._searching
        if len(self._shown[0]) != len(key) or any(one is not other for one, other in zip(key, self._shown[0])):
            self._shown = key, self._seen(*key)
        return self._shown[1]

    def _seen(self, now: Snapshot, proposal: Proposal | None, searching: bool) -> EditedPoints:
        world, images = self._session.world, None
        if proposal is not None:
            images = World(world.scene, robot=world.robot, body=proposal.point).look(now.theta_demo, now.theta)
        return EditedPoints(True, point_information(world, now), proposal, images, searching)

    def save(self) -> None:
        """The scene as it is, with the points by hand alone if there are any; of a URDF no folder of the server's."""
        scene, by_hand = self._session.scene, self._session.settings.body_points is not None
        if by_hand:
            scene = msgspec.structs.replace(scene, title=f"{scene.title}, points by hand")
        name = "".join(c if c.isalnum() else "-" for c in self._session.world.robot.name)
        file = f"viewimit-{name}-{self._session.settings.points}-points.toml"
        self._send(file, saved_scene(scene, HEADING).encode())

    @property
    def _searching(self) -> bool:
        return self._asked is not None and self.on and self._still(*self._asked)

    def _still(self, world: World, theta_demo: NDArray) -> bool:
        """Whether world and demonstrator are these."""
        return self._session.world is world and self._session.snapshot.theta_demo is theta_demo

    def _points(self) -> tuple[BodyPoint, ...]:
        body = self._session.world.body
        return tuple((int(link), x, y, z) for link, (x, y, z) in zip(body.link, body.local.tolist()))

    def _require_on(self) -> None:
        if not self.on:
            raise ValueError("the points are not being edited: press E, or Edit points")


def _search(world: World, moment: Snapshot) -> tuple[World, Snapshot, Proposal] | ValueError:
    try:
        return world, moment, best_next(world, moment, find_candidates(world, moment.theta_demo))
    except ValueError as reason:
        return reason
