"""The demonstrator's motions: which one is chosen, recording and replaying it, keeping it in a file."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis import trajectory
from viewimit.loop.session import Session
from viewimit.simulation.scene import Scene

from .queue import RunInBackground, Send

RECORDED = "recorded"  # a motion's name
TITLES = {"sinusoid": "sinusoid", "circle": "circle of the hand", RECORDED: "recorded"}
NAMES = {name: TITLES.get(name, name) for name in (*trajectory.MOTIONS, RECORDED)}
MOST_BYTES = 1 << 20  # of a file, which is read in the loop; seven joints in 5,000 frames have 0.7 MB
FILE = "viewimit-motion.json"


class Motions:
    """A made-up motion goes about the posture that the demonstrator has. pose(theta): moves the demonstrator;
    run_in_background(make, take): make what takes long, then take it in the page's own time."""

    def __init__(
        self, session: Session, pose: Callable[[NDArray], None], run_in_background: RunInBackground, send: Send,
        clock: Callable[[], float] = time.monotonic,
    ):  # fmt: skip
        self._session, self._pose, self._clock = session, pose, clock
        self._run_in_background, self._send = run_in_background, send
        self.name = next(iter(NAMES))
        self.recorded: trajectory.Motion | None = None
        self.recorder: Recorder | None = None
        self.shown: Playback | None = None
        self._at: NDArray | None = None  # posture that the motion shown has put the demonstrator in
        self._then: Callable[[Playback], None] | None = None  # what waits for a motion that is being made
        self._scene = session.scene

    @property
    def replaying(self) -> bool:
        return self._played is not None

    @property
    def _played(self) -> Playback | None:
        """The motion that is shown, while it plays."""
        return self.shown if self.shown is not None and self.shown.playing else None

    @property
    def moment(self) -> tuple[float, float]:
        """The time that is shown, and when the motion ends, s; the time is one of a frame."""
        known, frame = self._known, 0 if self.shown is None else round(self.shown.frame)
        last = trajectory.FRAMES - 1 if known is None else len(known.theta_deg) - 1
        return round(frame * self.step_s, 6), round(last * self.step_s, 6)  # without what multiplication adds

    @property
    def step_s(self) -> float:
        """Between two frames of the chosen motion."""
        known = self._known
        return trajectory.STEP_S if known is None else known.step_s

    @property
    def _known(self) -> trajectory.Motion | None:
        """The chosen motion; None for one that is still to be made."""
        return self.shown.motion if self.shown is not None else self.recorded if self.name == RECORDED else None

    def describe(self) -> tuple[str, str]:
        """State and sentence, as the line under the scene has them."""
        if self.recorder is not None:
            seconds, waits = self.recorder.seconds, "move the demonstrator by its sliders or its hand."
            return "recording", f"{seconds:.1f} s of the demonstrator's motion." if seconds else waits
        played = self._played
        if played is not None:
            now, last = self.moment
            return "replaying", f"{self._title(played.motion)}, {now:.1f} of {last:.1f} s."
        if self.name == RECORDED and self.recorded is not None:
            frames = len(self.recorded.theta_deg)
            words = f"{frames} frame{'' if frames == 1 else 's'}"
            return "ready", f"{self._title(self.recorded)}: {self.recorded.seconds:.1f} s, {words}"
        return "ready", "about the present pose"

    def _title(self, motion: trajectory.Motion) -> str:
        """Of the chosen motion; of one from a file, the beginning of its name there."""
        return motion.name[:40] if self.name == RECORDED != motion.name else NAMES[self.name]

    def tick(self) -> None:
        """Sample or pose the demonstrator, once a tick while there is a recorder or a motion is shown."""
        if self._session.scene is not self._scene:
            self._leave_scene()
        theta = self._session.snapshot.theta_demo
        if self.recorder is not None:
            self.recorder.sample(theta, self._clock())
            if self.recorder.full:
                self.record()
        elif (played := self._played) is not None:
            if self._at is None or not np.array_equal(theta, self._at):  # somebody else has moved it
                played.pause()
            else:
                played.advance(self._clock())
                self._show(played)

    def choose(self, name: str) -> None:
        """name: of NAMES"""
        if name == RECORDED:
            self._require_recorded()
        self._forget_shown()
        self.name = name

    def asked_for(self) -> str | trajectory.Motion:
        """The chosen motion, as Fig. 10 takes it."""
        return self._require_recorded() if self.name == RECORDED else self.name

    def record(self) -> None:
        """Begin, or end and choose the recorded motion."""
        if self.recorder is None:
            self._forget_shown()
            self._scene = self._session.scene
            self.recorder = Recorder(self._scene, self._session.snapshot.theta_demo, self._clock())
            return
        recorder, self.recorder = self.recorder, None
        self._keep(recorder.finish())

    def replay(self) -> None:
        """Play on from the moment that is shown, or stop."""
        self._require_no_recording()
        if (played := self._played) is not None:
            played.pause()
        else:
            self._with_motion(self._go_on)

    def _go_on(self, shown: Playback) -> None:
        shown.play(self._clock())
        self._show(shown)

    def scrub(self, seconds: float) -> None:
        """Show the frame at that time."""
        self._require_no_recording()
        last = self.moment[1]
        if not 0 <= seconds <= last:
            raise ValueError(f"the motion has no moment at {seconds:g} s; it lasts {last:g} s")
        if self.shown is not None:
            self.shown.pause()

        def go(shown: Playback) -> None:
            shown.frame = min(round(seconds / shown.motion.step_s), shown.last)
            self._show(shown)

        self._with_motion(go)

    def save(self) -> None:
        self._with_motion(lambda shown: self._send(FILE, trajectory.encode_motion(shown.motion)))

    def load(self, data: bytes | int) -> None:
        """data: what a file holds, or its size if that is too large."""
        self._require_no_recording()
        if not isinstance(data, bytes):
            raise ValueError(f"a motion's file has at most {MOST_BYTES >> 20} MB, this one {data / 2**20:.1f} MB")
        self._keep(trajectory.decode_motion(data, self._session.scene))

    def _take(self, made: tuple | Exception) -> None:
        """A motion that was made in the background, if it still goes about the demonstrator's posture in this scene."""
        then, self._then = self._then, None
        if isinstance(made, Exception):
            raise ValueError(f"there is no such motion here: {made}")
        name, scene, theta, found = made
        here = self._session.snapshot.theta_demo
        if then and name == self.name and scene is self._session.scene and np.array_equal(theta, here):
            self.shown, self._at, self._scene = Playback(found), theta, scene
            then(self.shown)

    def _with_motion(self, then: Callable[[Playback], None]) -> None:
        """Do this with the chosen motion, at once or as soon as it is made."""
        session, here = self._session, self._session.snapshot.theta_demo
        if self.name == RECORDED:
            if self.shown is None:
                self.shown, self._scene = Playback(self._require_recorded()), session.scene
            then(self.shown)
        elif self.shown is not None and self._at is not None and np.array_equal(self._at, here):
            then(self.shown)
        else:
            self._forget_shown()
            self._then = then
            name, world, scene = self.name, session.world, session.scene
            self._run_in_background(lambda: (name, scene, here, trajectory.MOTIONS[name](world, here)), self._take)

    def _show(self, shown: Playback) -> None:
        self._pose(shown.theta)
        self._at = self._session.snapshot.theta_demo

    def _keep(self, motion: trajectory.Motion) -> None:
        self._forget_shown()
        self.name, self.recorded = RECORDED, motion

    def _leave_scene(self) -> None:
        """Recording and replaying end with the scene; its recorded motion is kept."""
        self._scene, recorder, self.recorder = self._session.scene, self.recorder, None
        self._forget_shown()
        if recorder is not None and recorder.seconds > 0:
            self._keep(recorder.finish())

    def _forget_shown(self) -> None:
        self.shown = self._then = None

    def _require_recorded(self) -> trajectory.Motion:
        if self.recorded is None:
            raise ValueError("nothing is recorded yet: record a motion, or load one")
        trajectory.require_motion(self.recorded, self._session.scene)
        return self.recorded

    def _require_no_recording(self) -> None:
        if self.recorder is not None:
            raise ValueError("a motion is being recorded: stop that first")


class Recorder:
    """Sampled postures of the demonstrator, and when, in real time, from the first movement on. now: any clock, s"""

    def __init__(self, scene: Scene, theta: NDArray, now: float):
        self._scene = scene
        self._times, self._postures = [now], [theta]

    @property
    def seconds(self) -> float:
        """Since the first movement."""
        return self._times[-1] - self._times[0]

    @property
    def full(self) -> bool:
        """Whether it holds as much as a motion may."""
        return self.seconds >= trajectory.STEP_S * (trajectory.MAX_FRAMES - 1)

    def sample(self, theta: NDArray, now: float) -> None:
        """theta: (m,) rad. Before the first movement only the latest moment is kept."""
        if len(self._times) == 1 and np.array_equal(theta, self._postures[0]):
            self._times = [now]
        elif now > self._times[-1] and not self.full:
            self._times.append(now)
            self._postures.append(theta)

    def finish(self) -> trajectory.Motion:
        """The recorded motion, resampled in steps of STEP_S. Raises ValueError if nothing moved."""
        if len(self._times) < 2:
            raise ValueError("nothing was recorded: the demonstrator did not move")
        frames = min(int(np.ceil(self.seconds / trajectory.STEP_S - 1e-6)) + 1, trajectory.MAX_FRAMES)
        asked = self._times[0] + trajectory.STEP_S * np.arange(frames)
        theta = [np.interp(asked, self._times, angle) for angle in np.transpose(self._postures)]
        return trajectory.make_motion(RECORDED, self._scene, np.stack(theta, -1))


class Playback:
    """A motion, and the moment of it that is shown. frame: with fractions."""

    def __init__(self, played: trajectory.Motion):
        self.motion, self._theta = played, played.theta
        self.frame = 0.0
        self._began: float | None = None  # when frame 0 was, while it plays

    @property
    def playing(self) -> bool:
        return self._began is not None

    @property
    def last(self) -> int:
        return len(self._theta) - 1

    def play(self, now: float) -> None:
        """From the moment that is shown, or from the beginning once it is over."""
        self.frame = 0.0 if self.frame >= self.last else self.frame
        self._began = now - self.frame * self.motion.step_s

    def pause(self) -> None:
        self._began = None

    def advance(self, now: float) -> None:
        """Show the moment that is due; it stops by itself at the last."""
        if self._began is None:
            return
        self.frame = float(np.clip((now - self._began) / self.motion.step_s, 0, self.last))
        if self.frame >= self.last:
            self.pause()

    @property
    def theta(self) -> NDArray:
        """(m,) rad at the moment; between two frames on the straight line from one to the other."""
        before = int(self.frame)
        after = min(before + 1, self.last)
        return self._theta[before] + (self.frame - before) * (self._theta[after] - self._theta[before])
