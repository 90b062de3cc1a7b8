"""The nodes of one page's scene, from world to world."""

from functools import lru_cache
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw, ImageFont
from viewimit.assets import ROOT
from viser import ImageHandle, SceneApi, SceneNodeHandle
from viser.transforms import SO3

from viewimit.drawing.theme import rgb
from viewimit.simulation.scene_geometry import default_view

NO_SHADOWS: dict[str, Any] = {"cast_shadow": False, "receive_shadow": False}
Node = TypeVar("Node", bound=SceneNodeHandle)


class Nodes:
    """`begin` a world, `keep` each node as it is added, then `end`, which hides what has not come again. Nothing is
    removed: viser sends every pose of a node that takes another's place under its name. Where one is removed and comes
    again before the browser has heard of it, it sends no pose that is the default, and the old one stays."""

    def __init__(self) -> None:
        self._of_before: dict[str, SceneNodeHandle] = {}
        self._of_world: dict[str, SceneNodeHandle] = {}

    def begin(self) -> None:
        self._of_before |= self._of_world
        self._of_world = {}

    def keep(self, node: Node) -> Node:
        self._of_world[node.name] = node
        return node

    def end(self) -> None:
        for name, node in self._of_before.items():
            if name not in self._of_world:
                node.visible = False


def quaternion(rotation: NDArray) -> tuple[float, float, float, float]:
    """R (3, 3) → (w, x, y, z), as viser takes rotations."""
    w, x, y, z = SO3.from_matrix(rotation).wxyz.tolist()
    return w, x, y, z


def in_px(thickness: float) -> dict[str, Any]:
    """Return the options of lines that are as thick at any distance."""
    return {"thickness": thickness, "thickness_units": "screen"}


def linear(colour: ArrayLike) -> NDArray:
    """(..., 3) sRGB, 0 … 255 → uint8. Batched meshes, and segments of several colours, read them as linear light."""
    share = np.asarray(colour) / 255
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.round(255 * light).astype(np.uint8)


# Words in the 3-D scene. viser's own labels are black on white in every colour scheme; these have a role's colour.

# 40 px a line: twice the width that is seen at a pixel ratio of 1
FONT = ImageFont.truetype(str(ROOT / "fonts" / "Inter-SemiBold.ttf"), 40)
TEXT_ROLES = {"demonstrator": "demonstrator-edge", "learner": "learner"}  # that can be read


def add_text(
    scene: SceneApi, node: str, text: str, role: str, dark: bool, position: NDArray, line: float
) -> ImageHandle:
    """In the colour of an arm's role, turned to who looks from where the default view does. position: (3,) m, its
    middle; line: m, the height of a line."""
    picture, turn = lettering(text, rgb(TEXT_ROLES[role], dark)), quaternion(default_view())
    width = line * picture.shape[1] / picture.shape[0]
    return scene.add_image(node, picture, width, line, format="png", wxyz=turn, position=position, **NO_SHADOWS)


@lru_cache(64)
def lettering(text: str, color: tuple[int, int, int]) -> NDArray:
    """(h, w, 4) uint8, a line of text on nothing: one colour, and how much of each pixel it covers."""
    ascent, descent = FONT.getmetrics()
    cover = Image.new("L", (round(FONT.getlength(text)) + 4, ascent + descent))
    ImageDraw.Draw(cover).text((2, 0), text, 255, FONT)
    alpha = np.asarray(cover)[..., None]
    return np.concatenate([np.broadcast_to(np.array(color, np.uint8), (*alpha.shape[:2], 3)), alpha], axis=-1)
