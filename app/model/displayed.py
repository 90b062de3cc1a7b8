"""The display of a page's arms, at rest and on the way between two postures."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.construction import construct
from viewimit.analysis.convergence import recent_errors_deg
from viewimit.analysis.self_assessment import Assessment, assess
from viewimit.analysis.trajectory import Imitation
from viewimit.drawing.export.panels import Appearance
from viewimit.drawing.images.panel import SPARK_MOTIONS, draw_images
from viewimit.drawing.images.planes import Windows, last_stage
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot
from viewimit.servo import SERVOS, ServoStatus
from viewimit.simulation.appearance import Bodies
from viewimit.simulation.camera import triangulate

from ..jobs.camera_images import RemoteEyes
from .choices import View
from .player import Player


class OnTheWay:
    """Of one session in one world. By points an arm is seen anywhere on its way; no picture of it is taken before it
    has arrived."""

    def __init__(self):
        self._key: tuple = ()
        self._looked: Snapshot | None = None  # shown last, of an arm at rest, or on its way by points
        self._heading: Snapshot | None = None  # the moment that the arm was seen at, or on its way to, last
        self._shown: Snapshot | None = None

    def of(self, session: Session, theta: NDArray, moving: bool) -> tuple[Snapshot, Snapshot]:
        """What the images show, and what all else does. theta: (m,) rad, where the arm is seen."""
        present, key = session.snapshot, (theta.tobytes(), moving)
        if self._key != key or present is not self._heading or self._looked is None or self._shown is None:
            self._key = key
            self._looked, self._shown = self._seen(session, theta, moving)
        return self._looked, self._shown

    def _seen(self, session: Session, theta: NDArray, moving: bool) -> tuple[Snapshot, Snapshot]:
        present = session.snapshot
        left, self._heading = self._heading, present
        if moving and present.settings.sensor == "projected":
            looked = session.observe(theta, present)
            return looked, looked
        if not moving or left is None or self._looked is None:
            return present, present
        # a motion has begun; the arm may have rested too shortly to be drawn where it began
        looked = self._looked if left is present else left
        return looked, replace(looked, theta=theta, theta_demo=present.theta_demo)


class SeeThrough:
    """A see-through arm: a posture that is looked at without a motion. It goes as soon as its session moves."""

    def __init__(self, session: Session):
        self._session = session
        self._theta: NDArray | None = None
        self._from: NDArray | None = None  # where the learner stood then
        self._seen: tuple[Snapshot, Snapshot] | None = None  # the present, and what would be seen instead

    def look(self, theta: NDArray) -> None:
        """theta: (m,) rad. Raises ValueError for a posture out of limits, or where every look is a picture."""
        if self._session.settings.sensor == "rendered":
            raise ValueError("a ghost arm has no camera pictures: switch them off to look without a step")
        self._theta = self._session.scene.require_posture(theta, "ghost arm's")
        self._from, self._seen = self._session.snapshot.theta, None

    def let_go(self) -> None:
        self._theta = None

    @property
    def moment(self) -> Snapshot | None:
        """What would be seen there now: nothing moves, nothing is kept."""
        present = self._session.snapshot
        if self._theta is None or present.theta is not self._from or present.settings.sensor == "rendered":
            self._theta = None
            return None
        if self._seen is None or self._seen[0] is not present:
            self._seen = present, self._session.observe(self._theta, present)
        return self._seen[1]


WORLD = "scene", "robot", "joints", "points"  # settings in which it is to be seen as it was


class Imitated:
    """A motion that was imitated in an experiment, seen in the scene and in the images: nothing of the session moves,
    and it goes as soon as that does. now: s"""

    def __init__(self, session: Session):
        self._session = session
        self._shown: Imitation | None = None
        self._from: Snapshot | None = None  # the present then
        self._began = 0.0
        self._seen: tuple[int, Snapshot] | None = None  # a frame, and its snapshot

    @property
    def playing(self) -> bool:
        return self._shown is not None

    def play(self, imitation: Imitation, now: float) -> None:
        """Raises ValueError if the session is in another world, or where every look is a picture."""
        settings = self._session.settings
        if settings.sensor == "rendered":
            raise ValueError("an imitation has no camera pictures: switch them off to see it")
        differs = [name for name in WORLD if getattr(settings, name) != getattr(imitation.settings, name)]
        if differs:
            raise ValueError(f"{imitation.name} was made with other {', '.join(differs)}: run it again, or go back")
        self._shown, self._from, self._began, self._seen = imitation, self._session.snapshot, now, None

    def stop(self) -> None:
        self._shown = self._from = self._seen = None

    def moment(self, now: float) -> Snapshot | None:
        """The displayed snapshot: None without an imitation, and after its end."""
        shown = self._shown
        frame = 0 if shown is None else int(np.floor((now - self._began) / shown.step_s))
        if shown is None or self._session.snapshot is not self._from or frame >= len(shown.theta):
            self.stop()
            return None
        if self._seen is None or self._seen[0] != frame:
            seen = self._session.observe(shown.theta[frame], self._from, theta_demo=shown.theta_demo[frame])
            self._seen = frame, seen.recovered_by(shown.transfer)
        return self._seen[1]

    def describe(self) -> str:
        """A sentence on the moment that was shown last."""
        if self._shown is None or self._seen is None:
            return ""
        now, end = (frame * self._shown.step_s for frame in (self._seen[0], len(self._shown.theta) - 1))
        return f"{self._shown.name}, imitated by a frozen transfer: {now:.1f} of {end:.1f} s."


STEP, STAYS = 2.0, 5.0  # s a step, so that its sentence can be read; s that the last one stays


@dataclass(frozen=True, eq=False)
class Displayed:
    """What a page displays at one time. Drawings read it and change nothing. present: the session's snapshot;
    image_snapshot, scene_snapshot: what the four images show, and what all else does; pictures: JPEGs by view, of those
    that were taken; interpolated_theta: (m,) rad, where the arm is shown while it moves, None where it rests; preview:
    what would be seen at another posture, which then is displayed too; playback: a sentence on an imitation that is
    displayed instead of the session; stage: up to which the chosen point's construction is shown, None for all."""

    session: Session
    present: Snapshot
    image_snapshot: Snapshot
    scene_snapshot: Snapshot
    pictures: Mapping[str, bytes]
    interpolated_theta: NDArray | None
    preview: Snapshot | None
    playback: str | None
    stage: int | None
    view: View
    playing: bool
    look_at: Callable[[Snapshot], tuple[Bodies, Windows]]
    assess: Callable[[], Assessment | None]  # the session's present

    @property
    def snapshot(self) -> Snapshot:
        """The session's snapshot, or the imitation's that is displayed in its place."""
        return self.present if self.playback is None else self.scene_snapshot

    @property
    def moving_snapshot(self) -> Snapshot | None:
        """What the images show of the arm on its way; None where it rests, or another is displayed."""
        if self.interpolated_theta is None or self.playback is not None or self.preview is not None:
            return None
        now = self.image_snapshot
        return now if now.transfer is None else now.with_fields(status=ServoStatus.MOVING)

    @property
    def learner_theta(self) -> NDArray:
        """(m,) rad, where the learner's own arm is displayed; a previewed one is another."""
        on_its_way = self.interpolated_theta is not None and self.playback is None
        return self.interpolated_theta if on_its_way else self.snapshot.theta  # type: ignore[return-value]

    @cached_property
    def arms_in_images(self) -> tuple[Bodies, Windows]:
        """What the arms look like in the four images, and the windows of these."""
        return self.look_at(self.image_snapshot)

    @cached_property
    def errors_deg(self) -> list[float]:
        """Largest joint errors of the last motions: the truth, for the viewer."""
        return recent_errors_deg(self.session.history, self.session.cursor)

    @cached_property
    def assessment(self) -> Assessment | None:
        """What the learner can tell of the posture in which it rests; None unless it does. Laws that move on although
        they have stalled rest when they are paused."""
        moves_on = self.playing and SERVOS[self.present.settings.servo].slow
        return self.assess() if self.present.status.is_at_rest and not moves_on else None

    @cached_property
    def recovered_world(self) -> NDArray:
        """(N, 3) m: where the learner's cameras would see the recovered points in space, NaN where there is none."""
        return triangulate(*self.session.world.own_cameras, self.scene_snapshot.recovered)

    def draw_images(self, stage: int | None = None, standing: Bodies | None = None, print_size: bool = False) -> str:
        """Draw the four images, as HTML. stage: up to which the chosen point's construction is shown; standing: the
        arms where they are, while a preview is displayed."""
        view, now, session = self.view, self.image_snapshot, self.session
        before = session.history[max(session.cursor + 1 - SPARK_MOTIONS, 0) : session.cursor + 1]
        return draw_images(
            now,
            *self.arms_in_images,
            view.chosen,
            view.whole_frames,
            pictures=self.pictures,
            construction=None if view.chosen is None else construct(now, view.chosen),
            stage=stage,
            standing=standing,
            goal=view.goal and view.truth,
            course=[moment.E for moment in before if moment.motion <= now.motion],
            print_size=print_size,
        )


class Display:
    """The display of one session and its player, or of a preview or playback instead. now: s"""

    def __init__(self, session: Session, player: Player):
        self._session, self._player = session, player
        self._on_the_way = OnTheWay()
        self.preview, self.playback = SeeThrough(session), Imitated(session)
        self.construction_began: float | None = None  # s, while it is shown step by step; it ends by itself
        self._appearance: Appearance | None = None  # made when it is first shown
        self._assessed: tuple[Snapshot, Assessment | None] | None = None  # the last one, which is drawn many times

    def reset(self) -> None:
        """End previews, playbacks and constructions: the world was replaced."""
        self._on_the_way, self._appearance = OnTheWay(), None
        self.preview.let_go()
        self.construction_began = None
        self.playback.stop()

    def poses(self, now: float) -> tuple[NDArray, ...]:
        """Return (m,) rad each: where the learner is displayed, the demonstrator, and the opponent or the previewed arm
        if there is one."""
        if (played := self.playback.moment(now)) is not None:
            return played.theta, played.theta_demo
        learner, *others = [runner.theta(now)[0] for runner in self._player.runners]
        if not others and (moment := self.preview.moment) is not None:
            others = [moment.theta]
        return learner, self._session.snapshot.theta_demo, *others

    def at(self, now: float, shortest_motion: float, view: View) -> Displayed:
        """Return the display. shortest_motion: s; an arm that moves for less is displayed where it arrives."""
        session, eyes = self._session, self._session.eyes
        theta, moving = self._player.runners[0].theta(now, shortest_motion)
        looked, shown = self._on_the_way.of(session, theta, moving)
        played, preview = self.playback.moment(now), self.preview.moment
        last = last_stage(TRANSFERS[session.settings.transfer].crosses_lines)
        return Displayed(
            session=session,
            present=session.snapshot,
            image_snapshot=played or preview or looked,
            scene_snapshot=played or preview or shown,
            pictures=eyes.pictures(looked) if isinstance(eyes, RemoteEyes) else {},
            interpolated_theta=theta if moving else None,
            preview=None if played else preview,
            playback=self.playback.describe() if played else None,
            stage=None if view.chosen is None else self._stage(now, last),
            view=view,
            playing=self._player.playing,
            look_at=self._look_at,
            assess=self._assess,
        )

    def _stage(self, now: float, last: int) -> int | None:
        """From 0 to the last one; None before the construction and afterwards: all is shown."""
        since = np.inf if self.construction_began is None else now - self.construction_began
        if since >= (last + 1) * STEP + STAYS:
            self.construction_began = None
            return None
        return min(max(int(since / STEP), 0), last)

    def _assess(self) -> Assessment | None:
        if self._assessed is None or self._assessed[0] is not self._session.snapshot:
            self._assessed = self._session.snapshot, assess(self._session)
        return self._assessed[1]

    def _look_at(self, moment: Snapshot) -> tuple[Bodies, Windows]:
        """Return both arms in the images at a moment of the session's, and the windows that show them."""
        if self._appearance is None:
            self._appearance = Appearance(self._session.world)
        return self._appearance.of(moment)
