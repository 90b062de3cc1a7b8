"""What a learner gets to see of two bodies: so many frames of each as are set, disturbed, merged, and perhaps late.

With equal seeds it sees the same to the last bit. Every look has a stream of the seed for itself.
"""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..estimation.views import FourViews
from ..sensing import frames
from ..sensing.frames import MOST_LAG, lag_of
from ..simulation.disturbances import (
    ImageDisturbance,
    MatchDisturbance,
    SightDisturbance,
    any_of,
    mismatch,
    spoil,
    spoil_frames,
)
from ..simulation.eyes import SimulatedEyes
from .settings import Settings
from .snapshot import Snapshot

DEMO_LOOK, OWN_LOOK, REST_LOOK, MATCH = 0, 1, 4, 5  # streams of the seed: demonstrator, once; own body, at every
# motion, at rest; which of the demonstrator's points are swapped
REST_LOOKS = 8  # images of the own body at rest, from which the learner knows their noise

Images = tuple[NDArray, NDArray]  # of one body in a pair of views: points (N, 4) px, visible (N, 2) bool


class Observer:
    """Looks with `eyes`. theta_rest: (m,) rad, the learner's start, where it measures the noise of its images."""

    anywhere: ClassVar[bool] = True

    def __init__(self, eyes: SimulatedEyes, theta_rest: NDArray):
        self._eyes, self._theta_rest = eyes, theta_rest
        self._demo: tuple[tuple, Images] | None = None  # what it depends on, what was seen
        self._noise: tuple[tuple, float] | None = None
        self._visible: NDArray | None = None

    def four_views(self, settings: Settings, theta: NDArray, theta_demo: NDArray, look: int) -> FourViews:
        """theta, theta_demo: (m,) rad; look: which one it is, of the own body."""
        demo, demo_visible = self.demo(settings, theta_demo)
        own, own_visible = self.own(settings, theta, look)
        visible = np.concatenate([demo_visible, own_visible], -1)
        if self._visible is None or self._visible.tobytes() != visible.tobytes():
            self._visible = visible  # mostly all, at every look: kept once
        return FourViews(demo, own, self._visible)

    def own(self, settings: Settings, theta: NDArray, look: int) -> Images:
        """The own body, looked at anew. theta: (m,) rad."""
        return merged_look(settings, self._eyes.own_images(theta), OWN_LOOK, look)

    def demo(self, settings: Settings, theta_demo: NDArray) -> Images:
        """The demonstrator, looked at anew only when it, or its disturbance, has changed. theta_demo: (m,) rad."""
        key = theta_demo.tobytes(), settings.amounts(SightDisturbance), settings.frames, settings.seed
        if self._demo is None or self._demo[0] != key:
            images = merged_look(settings, self._eyes.demo_images(theta_demo), DEMO_LOOK)
            self._demo = key, mismatch(settings.amounts(MatchDisturbance), *images, [settings.seed, MATCH])
        return self._demo[1]

    def noise_at_rest(self, settings: Settings) -> float:
        """Standard deviation of a coordinate, as averaged, from single images of the own body at the start, px."""
        amounts = settings.amounts(ImageDisturbance)
        key = amounts, settings.seed, settings.frames
        if self._noise is None or self._noise[0] != key:
            measured = 0.0
            if any_of(amounts):
                images = self._eyes.own_images(self._theta_rest)
                looks = spoil_frames(amounts, *images, [settings.seed, REST_LOOK], REST_LOOKS)
                measured = frames.noise(*looks) / np.sqrt(settings.frames)
            self._noise = key, float(np.hypot(measured, self._eyes.noise_px))
        return self._noise[1]

    def wait(self, now: Snapshot, theta: NDArray) -> tuple[int, int | None]:
        """After a motion from `now` to theta, (m,) rad → for how many looks to wait until an image shows it, and what
        is known of the lag, in looks: None if the motion does not show.

        Nobody tells how late images come: the first motion that shows does.
        """
        if now.lag is not None:
            return now.lag, now.lag

        def look(after: int) -> Images:
            return self.own(now.settings, theta if after >= now.settings.delay else now.theta, now.look + 1 + after)

        lag = lag_of((now.views.own, now.views.visible[:, 2:]), look, self.noise_at_rest(now.settings))
        return MOST_LAG if lag is None else lag, lag


def merged_look(settings: Settings, images: Images, *stream: int) -> Images:
    """What is seen of images: as many frames as are set, disturbed and merged. stream: of the seed."""
    seed, amounts = [settings.seed, *stream], settings.amounts(ImageDisturbance)
    if settings.frames == 1 or not any_of(amounts):
        return spoil(amounts, *images, seed)
    return frames.merge(*spoil_frames(amounts, *images, seed, settings.frames))
