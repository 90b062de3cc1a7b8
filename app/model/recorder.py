"""Recording and replaying the demonstrator's motion in real time. No page in here: `now` is any clock, in seconds."""

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.trajectory import MAX_FRAMES, STEP_S, Motion, make_motion
from viewimit.simulation.scene import Scene

NAME = "recorded"


class Recorder:
    """Postures of the demonstrator as they are sampled, and when. The motion begins with the first movement."""

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
        return self.seconds >= STEP_S * (MAX_FRAMES - 1)

    def sample(self, theta: NDArray, now: float) -> None:
        """theta: (m,) rad. Before the first movement only the latest moment is kept."""
        if len(self._times) == 1 and np.array_equal(theta, self._postures[0]):
            self._times = [now]
        elif now > self._times[-1] and not self.full:
            self._times.append(now)
            self._postures.append(theta)

    def finish(self) -> Motion:
        """What was recorded, in steps of STEP_S whenever it was sampled. Raises ValueError if nothing moved."""
        if len(self._times) < 2:
            raise ValueError("nothing was recorded: the demonstrator did not move")
        frames = min(int(np.ceil(self.seconds / STEP_S - 1e-6)) + 1, MAX_FRAMES)
        asked = self._times[0] + STEP_S * np.arange(frames)
        theta = [np.interp(asked, self._times, angle) for angle in np.transpose(self._postures)]
        return make_motion(NAME, self._scene, np.stack(theta, -1))


class Playback:
    """A motion, and the moment of it that is shown. frame: with fractions."""

    def __init__(self, played: Motion):
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
