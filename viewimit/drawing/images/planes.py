"""The four image planes: their sizes, which part of each image is shown, and the arms in them.

An arm covers a small part of its image, so a window shows the arm's whole range instead of the whole frame.
"""

from base64 import b64encode
from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...estimation.views import FourViews
from ...simulation.appearance import ArmImages
from .. import svg

# width and height of each view's drawing, px, by whether whole frames are shown
SIZES = {
    False: {"l": (76, 140), "r": (76, 140), "L": (130, 209), "R": (130, 209)},
    True: dict.fromkeys("lrLR", (210, 79)),
}
MARGIN = 10  # image px around the points: about half a link's thickness
MIN_DIFFERENCE = 0.02  # in the share of points by which one corner is worse than another


class Window(NamedTuple):
    """The shown part of an image."""

    x: float  # px of the image, as y, w and h
    y: float
    w: float
    h: float
    scale: float  # px of the drawing per px of the image
    locator_left: bool  # whether the locator is in the left upper corner, as the arm is seen less there
    readout_left: bool  # whether the chosen point's residual is in the left lower corner


Windows = dict[bool, dict[str, Window]]


def image_windows(reach: Mapping[str, NDArray[np.float64]], frame: tuple[int, int]) -> Windows:
    """Choose the windows of the four views, by whether whole frames are shown.

    Parameters
    ----------
    reach
        Where points can be, (k, 2) px by view.
    frame
        Width and height of the images, px.
    """
    windows: Windows = {False: {}, True: {}}
    for whole, boxes in SIZES.items():
        for pair in ("lr", "LR"):
            spans = {view: _span(reach[view], frame, whole) for view in pair}
            scale = min(
                min(boxes[view][0] / (high - low)[0], boxes[view][1] / (high - low)[1])
                for view, (low, high) in spans.items()
            )
            sizes = {view: np.array(boxes[view]) / scale for view in pair}
            corners = {view: (low + high - sizes[view]) / 2 for view, (low, high) in spans.items()}
            free = _free_corners({view: (reach[view] - corners[view]) / sizes[view] for view in pair})
            for view in pair:
                (x, y), (w, h) = corners[view].tolist(), sizes[view].tolist()
                windows[whole][view] = Window(x, y, w, h, float(scale), *free)
    return windows


def holds(windows: Windows, points: Mapping[str, NDArray[np.float64]]) -> bool:
    """Say whether the windows show all these points, (k, 2) px by view."""
    for view, seen in points.items():
        x, y, w, h = windows[False][view][:4]
        place = (seen - (x, y)) / (w, h)
        if ((place < 0) | (place > 1)).any():
            return False
    return True


def _span(
    points: NDArray[np.float64], frame: tuple[int, int], whole: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if whole or len(points) == 0:
        return np.zeros(2), np.array(frame, float)
    return points.min(0) - MARGIN, points.max(0) + MARGIN


def _free_corners(places: dict[str, NDArray[np.float64]]) -> tuple[bool, bool]:
    """Say whether a pair's locator and readout are left. places: points, (k, 2), 0 … 1 over each window."""
    x, y = np.concatenate(list(places.values())).T
    share = lambda where: np.count_nonzero(where) / len(x)
    left, right, top, bottom = x < 0.35, x > 0.65, y < 0.1, y > 0.9
    return (
        bool(share(left & top) < share(right & top) - MIN_DIFFERENCE),
        bool(share(left & bottom) < share(right & bottom) + MIN_DIFFERENCE),
    )


def image_points(views: FourViews) -> NDArray[np.float64]:
    """Return all points by view, in the order lrLR, (4, N, 2) px."""
    return np.concatenate([views.demo, views.own], 1).reshape(-1, 4, 2).swapaxes(0, 1)


def placed(images: NDArray[np.float64], windows: Mapping[str, Window], views: str) -> NDArray[np.float64]:
    """Convert points of images, (views, ..., 2) px, to px of each view's drawing."""
    corner, scale = _corners_and_scales(tuple([windows[view] for view in views]))
    shape = (len(views),) + (1,) * (images.ndim - 2)
    return (images - corner.reshape(shape + (2,))) * scale.reshape(shape + (1,))


@lru_cache(64)
def _corners_and_scales(windows: tuple[Window, ...]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return np.array([window[:2] for window in windows]), np.array([window.scale for window in windows])


def draw_arm(arm: ArmImages, windows: Windows, whole: bool, views: str) -> dict[str, tuple[str, str]]:
    """Write path data of an arm's hulls and skeleton by view. The last result is cached with the arm."""
    kept = arm.memory.get(whole)
    if kept and kept[0] is windows:
        return kept[1]
    hulls, bones = placed(arm.hulls, windows[whole], views), placed(arm.origins, windows[whole], views)
    paths = dict(zip(views, zip(svg.polygons(hulls), svg.paths(bones))))
    arm.memory[whole] = windows, paths
    return paths


def photograph(jpeg: bytes, window: Window, frame: tuple[int, int]) -> str:
    """Place a picture of the whole frame, (width, height) px, so that the window's part fills the drawing."""
    k = window.scale
    return (
        f'<image class="vi-photograph" x="{-window.x * k:.2f}" y="{-window.y * k:.2f}" width="{frame[0] * k:.2f}"'
        f' height="{frame[1] * k:.2f}" preserveAspectRatio="none" decoding="sync"'
        f' href="data:image/jpeg;base64,{b64encode(jpeg).decode()}"/>'
    )


def plane(view: str, window: Window, whole: bool, frame: tuple[int, int], content: str) -> str:
    """Draw one image: background, the frame's border, clipped content, name, locator."""
    below, above = _plane(view, window, whole, frame)
    return f"{below}{content}{above}</svg>"


@lru_cache(256)
def _plane(view: str, window: Window, whole: bool, frame: tuple[int, int]) -> tuple[str, str]:
    """Draw the parts below the content and above it."""
    w, h = SIZES[whole][view]
    k = window.scale
    below = (
        f'<svg class="vi vi-at-{view}" viewBox="0 0 {w} {h}"><rect class="vi-plane" x=".5" y=".5" width="{w - 1}"'
        f' height="{h - 1}" rx="4"/><rect class="vi-rule" x="{-window.x * k:.1f}" y="{-window.y * k:.1f}"'
        f' width="{frame[0] * k:.1f}" height="{frame[1] * k:.1f}"/>'
    )
    name_x, end = (w - 5, " vi-end") if window.locator_left else (5, "")
    above = f'<text class="vi-name vi-halo{end}" x="{name_x}" y="15">{view}</text>'
    if not whole and view in "LR":
        above += _locator(window, w, frame)
    return below, above


def _locator(window: Window, w: float, frame: tuple[int, int]) -> str:
    """Draw the whole frame, small, with the part that the window shows."""
    k = 38 / frame[0]
    x, y, height = (5 if window.locator_left else w - 43), 5, frame[1] * k
    left, top = max(window.x, 0), max(window.y, 0)
    right, bottom = min(window.x + window.w, frame[0]), min(window.y + window.h, frame[1])
    return (
        f'<rect class="vi-plane" x="{x}" y="{y}" width="38" height="{height:.1f}" rx="1.5"/>'
        f'<rect class="vi-lens" x="{x + left * k:.1f}" y="{y + top * k:.1f}" width="{(right - left) * k:.1f}"'
        f' height="{(bottom - top) * k:.1f}"/>'
    )
