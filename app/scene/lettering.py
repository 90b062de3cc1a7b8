"""Words in the 3-D scene. viser's own labels are black on white in every colour scheme; these have a role's colour."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from viewimit.assets import ROOT
from viser import ImageHandle, SceneApi

from viewimit.drawing.theme import rgb
from viewimit.simulation.scene_geometry import default_view

from .rotations import quaternion

FONT = ImageFont.truetype(
    str(ROOT / "fonts" / "Inter-SemiBold.ttf"), 40
)  # px a line, twice what is seen at a pixel ratio of 1

TEXT_ROLES = {"demonstrator": "demonstrator-edge", "learner": "learner"}  # that can be read


def add_text(
    scene: SceneApi, node: str, text: str, role: str, dark: bool, position: NDArray, line: float
) -> ImageHandle:
    """In the colour of an arm's role, turned to who looks from where the default view does. position: (3,) m, its
    middle; line: m, the height of a line."""
    picture = lettering(text, rgb(TEXT_ROLES[role], dark))
    height, width, _ = picture.shape
    return scene.add_image(
        node,
        picture,
        line * width / height,
        line,
        format="png",
        cast_shadow=False,
        receive_shadow=False,
        wxyz=quaternion(default_view()),
        position=position,
    )


@lru_cache(64)
def lettering(text: str, color: tuple[int, int, int]) -> NDArray:
    """(h, w, 4) uint8, a line of text on nothing: one colour, and how much of each pixel it covers."""
    ascent, descent = FONT.getmetrics()
    cover = Image.new("L", (round(FONT.getlength(text)) + 4, ascent + descent))
    ImageDraw.Draw(cover).text((2, 0), text, 255, FONT)
    alpha = np.asarray(cover)[..., None]
    return np.concatenate([np.broadcast_to(np.array(color, np.uint8), (*alpha.shape[:2], 3)), alpha], axis=-1)
