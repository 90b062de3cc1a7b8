"""Where the four images stand in the panel, which part of each is shown, and the silhouettes in them.

An arm covers a small part of its image, so that a window follows the arm's whole range instead of the frame.
"""

from base64 import b64encode
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..simulation.world import World
from ..snapshot import Snapshot
from . import svg
from .silhouettes import Silhouettes

WIDTH = 424
# view: (x, y, width, height) in the drawing; by whether whole frames are shown
BOXES = {
    False: {"l": (296, 0, 62, 116), "r": (362, 0, 62, 116), "L": (0, 0, 143, 232), "R": (148, 0, 143, 232)},
    True: {"l": (0, 84, 210, 79), "r": (214, 84, 210, 79), "L": (0, 0, 210, 79), "R": (214, 0, 210, 79)},
}
MARGIN = 10  # image px around the points: about half a link's thickness
CLEARLY = 0.02  # share of the points by which one corner is worse than another
POSTURES_A_JOINT, POSTURES = 9, 200  # of the grid with two joints; drawn at random with more
NEAR = np.radians(20)  # of a posture, with more joints


class Window(NamedTuple):
    """Part (x, y, w, h) px of an image, drawn `scale` times as large. The arm is least seen in the corners
    where, if True, the locator stands left and the chosen point's residual stands left."""

    x: float
    y: float
    w: float
    h: float
    scale: float
    locator_left: bool
    readout_left: bool


Windows = dict[bool, dict[str, Window]]


def image_windows(world: World, held: Sequence[NDArray] = ()) -> Windows:
    """Windows of the four views by whether whole frames are shown.

    held: postures, (m,) rad. With more than two joints an arm reaches nearly everywhere, so that windows show what is
    near these postures, not the whole range.
    """
    theta = _postures(world, held)
    points = {}
    for pair, look in (("lr", world.demo_images), ("LR", world.own_images)):
        images, visible = look(theta)
        for side, view in enumerate(pair):
            points[view] = images[..., 2 * side : 2 * side + 2][visible[..., side]].reshape(-1, 2)
    width, height = world.scene.head.image
    windows: Windows = {False: {}, True: {}}
    for whole, boxes in BOXES.items():
        for pair in ("lr", "LR"):
            spans = {view: _span(points[view], (width, height), whole) for view in pair}
            scale = min(
                min(boxes[view][2] / (high - low)[0], boxes[view][3] / (high - low)[1])
                for view, (low, high) in spans.items()
            )
            sizes = {view: np.array(boxes[view][2:]) / scale for view in pair}
            corners = {view: (low + high - sizes[view]) / 2 for view, (low, high) in spans.items()}
            free = _free_corners({view: (points[view] - corners[view]) / sizes[view] for view in pair})
            for view in pair:
                numbers = map(float, (*corners[view], *sizes[view], scale))
                windows[whole][view] = Window(*numbers, *free)
    return windows


def holds(windows: Windows, world: World, snapshot: Snapshot) -> bool:
    """Whether the windows show both arms' points, as they would be without noise."""
    if len(snapshot.theta) <= 2:
        return True
    for pair, (points, visible) in (
        ("lr", world.demo_images(snapshot.theta_demo)),
        ("LR", world.own_images(snapshot.theta)),
    ):
        for side, view in enumerate(pair):
            x, y, w, h = windows[False][view][:4]
            place = (points[visible[:, side], 2 * side : 2 * side + 2] - (x, y)) / (w, h)
            if ((place < 0) | (place > 1)).any():
                return False
    return True


def _postures(world: World, held: Sequence[NDArray]) -> list[NDArray]:
    """The moving joints' angles, one flat array a joint: over the range of two, or near the postures to be held."""
    lower, upper = world.scene.lower, world.scene.upper
    if len(lower) <= 2:
        axes = [np.linspace(low, high, POSTURES_A_JOINT) for low, high in zip(lower, upper)]
        return [axis.ravel() for axis in np.meshgrid(*axes)]
    centres = np.array([np.radians(world.scene.posture_deg)[world.scene.moving], *held])
    near = np.random.default_rng(0).uniform(-NEAR, NEAR, (len(centres), -(-POSTURES // len(centres)), len(lower)))
    return list(np.clip(centres[:, None] + near, lower, upper).reshape(-1, len(lower)).T)


def _span(points: NDArray, frame: tuple[int, int], whole: bool) -> tuple[NDArray, NDArray]:
    if whole or len(points) == 0:
        return np.zeros(2), np.array(frame, float)
    return points.min(0) - MARGIN, points.max(0) + MARGIN


def _free_corners(places: dict[str, NDArray]) -> tuple[bool, bool]:
    """Whether a pair's locator and readout stand left. places: points (k, 2) of each view, 0 … 1 over its window."""
    x, y = np.concatenate(list(places.values())).T
    share = lambda where: np.count_nonzero(where) / len(x)
    left, right, top, bottom = x < 0.35, x > 0.65, y < 0.1, y > 0.9
    return (
        share(left & top) < share(right & top) - CLEARLY,
        share(left & bottom) < share(right & bottom) + CLEARLY,
    )


def placed(images: NDArray, windows: dict[str, Window], views: str) -> NDArray:
    """images: (views, ..., 2) px → the same in px of each view's box."""
    corner, scale = _corners_and_scales(tuple([windows[view] for view in views]))
    shape = (len(views),) + (1,) * (images.ndim - 2)
    return (images - corner.reshape(shape + (2,))) * scale.reshape(shape + (1,))


@lru_cache(64)
def _corners_and_scales(windows: tuple[Window, ...]) -> tuple[NDArray, NDArray]:
    return np.array([window[:2] for window in windows]), np.array([window.scale for window in windows])


def draw_arm(snapshot: Snapshot, silhouettes: Silhouettes, windows: Windows, whole: bool, arm: str):
    """Paths of an arm's two images, by view: (hulls, skeleton); and its links' origins, (2, n + 1, 2) px.

    What was drawn last is kept: the demonstrator rests while the learner moves.
    """
    world = silhouettes.world
    views, theta, T_world_base, cameras = (
        ("LR", snapshot.theta, world.T_world_own, world.own_pair)
        if arm == "learner"
        else ("lr", snapshot.theta_demo, world.T_world_demo, world.demo_pair)
    )
    key = theta.tobytes(), whole
    kept = silhouettes.memory.get(arm)
    if kept and kept[0] == key and kept[1] is windows:
        return kept[2]
    hulls, origins = silhouettes.seen(world.link_frames(theta, T_world_base), cameras)
    hulls, bones = placed(hulls, windows[whole], views), placed(origins, windows[whole], views)
    paths = dict(zip(views, zip(svg.polygons(hulls), map(svg.path, bones))))
    silhouettes.memory[arm] = key, windows, (paths, origins)
    return paths, origins


def photograph(jpeg: bytes, window: Window, frame: tuple[int, int]) -> str:
    """A picture of the whole frame, (width, height) px, so placed that what the window shows of it fills the box."""
    k = window.scale
    return (
        f'<image class="vi-photograph" x="{-window.x * k:.2f}" y="{-window.y * k:.2f}" width="{frame[0] * k:.2f}"'
        f' height="{frame[1] * k:.2f}" preserveAspectRatio="none" decoding="sync"'
        f' href="data:image/jpeg;base64,{b64encode(jpeg).decode()}"/>'
    )


def plane(view: str, window: Window, whole: bool, frame: tuple[int, int], caption: str, content: str) -> str:
    """One image in its box: background, the frame's border, content that is clipped, name, locator."""
    below, above = _plane(view, window, whole, frame, caption)
    return f"{below}{content}{above}</svg>"


@lru_cache(256)
def _plane(view: str, window: Window, whole: bool, frame: tuple[int, int], caption: str) -> tuple[str, str]:
    """What lies under the content, and over it."""
    x, y, w, h = BOXES[whole][view]
    k = window.scale
    below = (
        f'<svg x="{x}" y="{y}" width="{w}" height="{h}"><rect class="vi-plane" x=".5" y=".5" width="{w - 1}"'
        f' height="{h - 1}" rx="4"/><rect class="vi-rule" x="{-window.x * k:.1f}" y="{-window.y * k:.1f}"'
        f' width="{frame[0] * k:.1f}" height="{frame[1] * k:.1f}"/>'
    )
    name_x, end = (w - 5, " vi-end") if window.locator_left else (5, "")
    above = f'<text class="vi-name vi-halo{end}" x="{name_x}" y="15">{view}</text>'
    if caption and not window.locator_left:
        above += f'<text class="vi-2nd vi-halo" x="17" y="15">{caption}</text>'
    if not whole and view in "LR":
        above += _locator(window, w, frame)
    return below, above


def _locator(window: Window, w: float, frame: tuple[int, int]) -> str:
    """The whole frame, small, and what part of it the window shows."""
    k = 38 / frame[0]
    x, y, height = (5 if window.locator_left else w - 43), 5, frame[1] * k
    left, top = max(window.x, 0), max(window.y, 0)
    right, bottom = min(window.x + window.w, frame[0]), min(window.y + window.h, frame[1])
    return (
        f'<rect class="vi-plane" x="{x}" y="{y}" width="38" height="{height:.1f}" rx="1.5"/>'
        f'<rect class="vi-lens" x="{x + left * k:.1f}" y="{y + top * k:.1f}" width="{(right - left) * k:.1f}"'
        f' height="{(bottom - top) * k:.1f}"/>'
    )
