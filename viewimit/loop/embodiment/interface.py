"""What a person writes to put the loop on a robot and cameras of their own: an arm with four members, eyes with two."""

from typing import Protocol

from numpy.typing import NDArray

from ...estimation.views import FourViews


class Arm(Protocol):
    """An arm of m joints. Postures are (m,) rad, their joints always in the same order; that is all that is known."""

    @property
    def lower(self) -> NDArray:
        """(m,) rad: it is never sent below."""
        ...

    @property
    def upper(self) -> NDArray:
        """(m,) rad: it is never sent above."""
        ...

    @property
    def start(self) -> NDArray:
        """(m,) rad: where a session first sends it."""
        ...

    def move(self, theta: NDArray) -> NDArray:
        """Go to theta, (m,) rad, and return when at rest: (m,) rad, where it stands by its encoders, or theta if it has
        none. That is for viewers: the learner goes by where it sent the arm. A turn or more beyond the limits is
        refused, as what degrees would be."""
        ...


class Eyes(Protocol):
    """Two cameras, or one pair of pictures for each body, in which N points are found."""

    @property
    def noise_px(self) -> float:
        """Standard deviation of a coordinate beyond what can be measured with an arm at rest, px, from 0; mostly 0.
        Rounding to whole pixels, or to steps of any other grid, is found by itself."""
        ...

    def look(self) -> FourViews:
        """One picture of each view, taken now: N points matched by index, always the same N, px.
        `FourViews.from_images` makes it of four arrays (N, 2), NaN where a point is not seen. A point at (0, 0) or
        (-1, -1) px, or a hundred times as far from the others as those are from each other, and a body all of whose
        points are in one place or on one line, count as not seen."""
        ...
