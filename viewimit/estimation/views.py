"""The four views: image points of demonstrator and learner, which of them are visible, and whether they suffice."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry.affine import MIN_POINTS, centred, image_points

Pairs = tuple[tuple[int, int], ...]  # swapped points, by index
VIEWS = ("l", "r", "L", "R")  # the paper's names: demonstrator left, right; own left, right
# Names of the same views in files, columns, options and JSON: many file systems do not distinguish l from L
VIEW_NAMES = dict(zip(VIEWS, ("demo_left", "demo_right", "own_left", "own_right")))


@dataclass(frozen=True)
class FourViews:
    """N body points, matched by index, in the learner's two stereo pairs.

    Coordinates of invisible points mean nothing: transfers take `used`. The demonstrator's points may come unnamed:
    then they are matched in [l] and [r] only, and no point is usable until `named` puts them in order.
    """

    demo: NDArray[np.float64]  #: (..., N, 4) px, the demonstrator's points: 4 coordinates x_l, y_l, x_r, y_r
    own: NDArray[np.float64]  #: (..., N, 4) px, the learner's own points: 4 coordinates x_L, y_L, x_R, y_R
    visible: NDArray[np.bool_]  #: (..., N, 4), whether a point is visible, in each of the 4 views l, r, L, R
    matched: bool = True  #: whether row i of demo and own is one body point

    @classmethod
    def from_images(
        cls, demo_left: ArrayLike, demo_right: ArrayLike, own_left: ArrayLike, own_right: ArrayLike
    ) -> "FourViews":
        """Collect tracked points.

        Parameters
        ----------
        demo_left, demo_right, own_left, own_right : (..., N, 2) array_like
            Points of each view [px], or OpenCV's (..., N, 1, 2). A point that is NaN or masked is not visible there.

        Returns
        -------
        FourViews

        Raises
        ------
        ValueError
            If the views do not hold the same number of points.
        """
        return cls.from_arrays(*map(image_points, map(_unmasked, (demo_left, demo_right, own_left, own_right))))

    @classmethod
    def from_arrays(cls, *images: NDArray[np.float64]) -> "FourViews":
        """Collect points of four arrays, which are never taken for OpenCV's: N may be 1.

        Parameters
        ----------
        *images : (..., N, 2) arrays
            Points of l, r, L, R [px].

        Returns
        -------
        FourViews
        """
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
    def demo_left(self) -> NDArray[np.float64]:
        """[l]: (..., N, 2) px."""
        return self.demo[..., :2]

    @property
    def demo_right(self) -> NDArray[np.float64]:
        """[r]: (..., N, 2) px."""
        return self.demo[..., 2:]

    @property
    def own_left(self) -> NDArray[np.float64]:
        """[L]: (..., N, 2) px."""
        return self.own[..., :2]

    @property
    def own_right(self) -> NDArray[np.float64]:
        """[R]: (..., N, 2) px."""
        return self.own[..., 2:]

    @property
    def bodies(self) -> tuple[tuple[NDArray[np.float64], NDArray[np.bool_]], ...]:
        """Images (..., N, 4) px and visibility (..., N, 2), of the demonstrator and of the learner."""
        return (self.demo, self.visible[..., :2]), (self.own, self.visible[..., 2:])

    @cached_property
    def matches(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points of the demonstrator and of the learner that both cameras see: (..., M, 4) px each.

        Raises ValueError for a batch of postures that show different points.
        """
        if self.visible.all():
            return self.demo, self.own
        demo, own = (images[..., _same_in_all(np.asarray(visible.all(-1))), :] for images, visible in self.bodies)
        return demo, own

    @cached_property
    def complete(self) -> bool:
        """Whether every point is visible in every view, and named."""
        return bool(self.matched and self.visible.all())

    @cached_property
    def usable(self) -> NDArray[np.bool_]:
        """(..., N): visible in all four views and named, as every transfer needs it."""
        return np.asarray(self.visible.all(-1) & self.matched)

    @property
    def used(self) -> "FourViews":
        """Views of the usable points. Raises ValueError for a batch of postures that show different points."""
        return self if self.complete else self.select(_same_in_all(self.usable))

    def select(self, points: NDArray[np.bool_] | NDArray[np.int_]) -> "FourViews":
        """Select points, the same for all postures of a batch.

        Parameters
        ----------
        points : (N,) array of bool, or indices
            Which points.

        Returns
        -------
        FourViews
            These points only.
        """
        if np.ndim(points) != 1:
            raise ValueError(f"points must be (N,) bool or indices, for all postures, got shape {np.shape(points)}")
        images = self.demo[..., points, :], self.own[..., points, :]
        return FourViews(*images, self.visible[..., points, :], self.matched)

    def permuted(self, pairs: Pairs) -> "FourViews":
        """Swap the demonstrator's points of each pair.

        Parameters
        ----------
        pairs : tuple of pairs of int
            Points, by index.

        Returns
        -------
        FourViews
            The same points in another order.
        """
        if not pairs:
            return self
        order = permute(np.arange(self.demo.shape[-2]), pairs)
        visible = np.concatenate([self.visible[..., order, :2], self.visible[..., 2:]], -1)
        return FourViews(self.demo[..., order, :], self.own, visible, self.matched)

    def named(self, names: NDArray[np.int_]) -> "FourViews":
        """Put unnamed points of the demonstrator in order.

        Parameters
        ----------
        names : (N,) array
            The demonstrator's point of each own point, by index; -1 of a point without a partner.

        Returns
        -------
        FourViews
            Points that are matched by index. Without a partner they are NaN and invisible in [l] and [r].
        """
        partner = (names >= 0)[:, None]
        demo = np.where(partner, self.demo[..., names, :], np.nan)
        visible = np.concatenate([self.visible[..., names, :2] & partner, self.visible[..., 2:]], -1)
        return FourViews(demo, self.own, visible)

    def with_own(self, own: NDArray[np.float64]) -> "FourViews":
        """Replace the own images.

        Parameters
        ----------
        own : (..., N, 4) array
            Points in [L, R] [px].

        Returns
        -------
        FourViews
            The same demonstrator beside these images.
        """
        return replace(self, own=own)


def view_of(name: str) -> str:
    """Return the paper's name of a view: l for demo_left, Demo-Left and l. Raises ValueError for any other name."""
    plain = name.lower().replace(" ", "_").replace("-", "_")
    for view, full in VIEW_NAMES.items():
        if name == view or plain == full:
            return view
    raise ValueError(f"{name!r} is none of {', '.join(VIEW_NAMES.values())}")


def _same_in_all(points: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(..., N) → (N,), the points of every posture."""
    first: NDArray[np.bool_] = points.reshape(-1, points.shape[-1])[0]
    if not (points == first).all():
        raise ValueError(
            "the postures of this batch show different points: fit each posture by itself, "
            "or views.select(points) those that all of them show"
        )
    return first


def permute(order: NDArray[np.int_], pairs: Pairs) -> NDArray[np.int_]:
    """Swap the entries of each pair in (N,) indices."""
    order = order.copy()
    for pair in pairs:
        order[[*pair]] = order[[*reversed(pair)]]
    return order


def _unmasked(image: ArrayLike) -> NDArray[np.float64]:
    """Fill masked entries with NaN."""
    if isinstance(image, np.ma.MaskedArray):
        return np.ma.filled(image.astype(float), np.nan)
    return np.asarray(image, float)


def unique_matches(looks: Iterable[FourViews]) -> NDArray[np.float64]:
    """Pool the matches of left and right image, of both bodies and all looks, without repetitions: (M, 4) px."""
    unique: dict[bytes, NDArray[np.float64]] = {}
    for views in looks:
        for matches in views.matches:
            unique.setdefault(matches.tobytes(), matches)
    return np.concatenate(list(unique.values()))


# Degenerate configurations: E of such points is nearly 0 at any posture, so it would look best where it says nothing

FLAT_EXTENT = 1e-6  # extent that counts as none, over the largest extent
SHAPES = ("all points are in one place", "all points are on one line", "all points are in one plane")


def extents(images: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute σ1 to σ4 [px] of centred points in two images, (..., N, 4) px → (..., 4)."""
    return np.asarray(np.linalg.svd(centred(images)[1], compute_uv=False), float)


def dimensions(images: NDArray[np.float64]) -> NDArray[np.int_]:
    """Count the dimensions of points (..., N, 4) px: (...), 0 in one place, 1 on one line, 2 in a plane."""
    sigma, size = extents(images), np.abs(images).max((-2, -1))
    return (sigma > FLAT_EXTENT * np.maximum(sigma[..., :1], FLAT_EXTENT * size[..., None])).sum(-1)


def why_degenerate(views: FourViews) -> list[str]:
    """Explain for each of T frames why no transfer can be fitted, "" if one can. views: T x N visible points."""
    why = np.full(len(views.demo), "", object)
    for pair, images in (("[l, r]", views.demo), ("[L, R]", views.own)):
        found = dimensions(images)
        for count, shape in enumerate(SHAPES):
            why[(found == count) & (why == "")] = f"{shape} in {pair}"
    both = np.concatenate([views.demo, views.own], -1)
    repeats = (np.diff(np.sort(both[..., 0], -1), axis=-1) == 0).any(-1)  # else all points differ
    for k in np.flatnonzero(repeats & (why == "")):
        different = len(np.unique(both[k], axis=0))
        if different < MIN_POINTS:
            why[k] = f"only {different} points differ, at least {MIN_POINTS} must"
    return [str(words) for words in why]
