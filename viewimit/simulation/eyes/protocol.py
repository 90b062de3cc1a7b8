"""What a session in a scene looks with and moves by, whatever is behind it."""

from typing import Protocol

from numpy.typing import NDArray

from ...loop.settings import Settings
from ..robot import Angles
from ..world import World


class SimulatedEyes(Protocol):
    """N body points, matched by index; arms of m moving joints."""

    @property
    def world(self) -> World:
        """The truth that they look at, for viewers only."""
        ...

    @property
    def noise_px(self) -> float:
        """Standard deviation of an image coordinate, as their maker states it; a disturbance comes on top."""
        ...

    def demo_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        """The demonstrator in [l], [r]. theta: m arrays of angles, rad, broadcast against each other to (...) →
        points (..., N, 4) px, visible (..., N, 2) bool. Coordinates of what is not visible mean nothing."""
        ...

    def own_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        """The learner in [L], [R], likewise."""
        ...

    def settle(self, theta: NDArray) -> NDArray:
        """Where an arm comes to rest that is told to stand at theta; (m,) rad each."""
        ...

    def drive(self, settings: Settings, theta: NDArray, sent: NDArray, commanded: NDArray) -> NDArray:
        """Where an arm at theta, last sent to `sent`, comes to rest once it is sent to `commanded`; (m,) rad each."""
        ...
