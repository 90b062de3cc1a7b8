"""What the learner sees: image points in four views, and which of them it sees."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry.affine import image_points

Pairs = tuple[tuple[int, int], ...]  # of points
VIEWS = ("l", "r", "L", "R")  # the paper's names: demonstrator left, right; own left, right
# Of the same views in files, columns, options and JSON: many a file system takes l for L
VIEW_NAMES = dict(zip(VIEWS, ("demo_left", "demo_right", "own_left", "own_right")))


@dataclass(frozen=True)
class FourViews:
    """N body points, matched by index, in the learner's two stereo pairs.

    demo: (..., N, 4) px, the demonstrator's points [l, r] as x_l, y_l, x_r, y_r.
    own: (..., N, 4) px, the learner's own points [L, R].
    visible: (..., N, 4) bool, seen in l, r, L, R. Coordinates of unseen points mean nothing: transfers take `used`.
    """

    demo: NDArray
    own: NDArray
    visible: NDArray

    @classmethod
    def from_images(cls, demo_left: ArrayLike, demo_right: ArrayLike, own_left: ArrayLike, own_right: ArrayLike):
        """Tracked points, (..., N, 2) px a view, or OpenCV's (..., N, 1, 2). A point with NaN in a view, or masked, was
        not seen there.

        Raises ValueError if the views do not hold the same number of points.
        """
        return cls.from_arrays(*map(image_points, map(_unmasked, (demo_left, demo_right, own_left, own_right))))

    @classmethod
    def from_arrays(cls, *images: NDArray) -> "FourViews":
        """The same of four arrays (..., N, 2) px that are never OpenCV's, as of T frames of one point."""
        for name, image in zip(VIEW_NAMES.values(), images):
            if image.ndim < 2 or image.shape[-1] != 2:
                raise ValueError(f"{name}: need points of shape (..., N, 2), got {image.shape}")
        counts = [image.shape[-2] for image in images]
        if len(set(counts)) > 1:
            found = ", ".join(f"{name}: {count}" for name, count in zip(VIEW_NAMES.values(), counts))
            raise ValueError(f"the views hold different numbers of points ({found}); they are matched by index")
        together = np.broadcast_arrays(*images)
        return cls(
            np.concatenate(together[:2], -1),
            np.concatenate(together[2:], -1),
            np.stack([np.isfinite(image).all(-1) for image in together], -1),
        )

    @property
    def demo_left(self) -> NDArray:
        """[l]: (..., N, 2) px"""
        return self.demo[..., :2]

    @property
    def demo_right(self) -> NDArray:
        """[r]: (..., N, 2) px"""
        return self.demo[..., 2:]

    @property
    def own_left(self) -> NDArray:
        """[L]: (..., N, 2) px"""
        return self.own[..., :2]

    @property
    def own_right(self) -> NDArray:
        """[R]: (..., N, 2) px"""
        return self.own[..., 2:]

    @property
    def bodies(self) -> tuple[tuple[NDArray, NDArray], tuple[NDArray, NDArray]]:
        """Images (..., N, 4) px of the demonstrator and of the learner, with whether points are seen, (..., N, 2)."""
        return (self.demo, self.visible[..., :2]), (self.own, self.visible[..., 2:])

    @cached_property
    def matches(self) -> tuple[NDArray, NDArray]:
        """Of the demonstrator and of the learner, the points that both cameras see: (..., M, 4) px each.

        Raises ValueError for a batch of postures that show different points.
        """
        if self.complete:
            return self.demo, self.own
        demo, own = (images[..., _same_in_all(np.asarray(visible.all(-1))), :] for images, visible in self.bodies)
        return demo, own

    @cached_property
    def complete(self) -> bool:
        """Whether every point is seen in every view."""
        return bool(self.visible.all())

    @cached_property
    def usable(self) -> NDArray:
        """(..., N) bool: seen in all four views, as every transfer needs it."""
        return np.asarray(self.visible.all(-1))

    @property
    def half_seen(self) -> NDArray:
        """(..., N) bool: points of the demonstrator that one camera alone sees."""
        return self.visible[..., 0] != self.visible[..., 1]

    @property
    def used(self) -> "FourViews":
        """The views of the usable points only. Raises ValueError for a batch of postures that show different points."""
        return self if self.complete else self.select(_same_in_all(self.usable))

    def select(self, points: NDArray) -> "FourViews":
        """The views of some points only. points: (N,) bool or indices, for all postures of a batch."""
        if np.ndim(points) != 1:
            raise ValueError(f"points must be (N,) bool or indices, for all postures, got shape {np.shape(points)}")
        return FourViews(self.demo[..., points, :], self.own[..., points, :], self.visible[..., points, :])

    def with_exchanged(self, pairs: Pairs) -> "FourViews":
        """The demonstrator's points of each pair taken for each other."""
        if not pairs:
            return self
        order = exchange(np.arange(self.demo.shape[-2]), pairs)
        visible = np.concatenate([self.visible[..., order, :2], self.visible[..., 2:]], -1)
        return FourViews(self.demo[..., order, :], self.own, visible)

    def with_own(self, own: NDArray) -> "FourViews":
        """The same demonstrator beside other own images: (..., N, 4) px."""
        return replace(self, own=own)


def view_of(name: str) -> str:
    """The paper's name of a view: l of demo_left, and of l. Raises ValueError for a name of no view."""
    for view, full in VIEW_NAMES.items():
        if name in (view, full):
            return view
    raise ValueError(f"{name!r} is none of {', '.join(VIEW_NAMES.values())}")


def _same_in_all(points: NDArray) -> NDArray:
    """(..., N) bool → (N,) bool, the points of every posture."""
    first: NDArray = points.reshape(-1, points.shape[-1])[0]
    if not (points == first).all():
        raise ValueError(
            "the postures of this batch show different points: fit each posture by itself, "
            "or views.select(points) those that all of them show"
        )
    return first


def exchange(order: NDArray, pairs: Pairs) -> NDArray:
    """(N,) with the entries of each pair exchanged."""
    order = order.copy()
    for pair in pairs:
        order[[*pair]] = order[[*reversed(pair)]]
    return order


def _unmasked(image: ArrayLike) -> NDArray:
    """As numbers, NaN in place of what a masked array hides."""
    if isinstance(image, np.ma.MaskedArray):
        return np.ma.filled(image.astype(float), np.nan)
    return np.asarray(image, float)
