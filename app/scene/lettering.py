"""Words in the 3-D scene. viser's own labels are black on white in every colour scheme; these have a role's colour."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from viewimit.assets import ROOT

FONT = ImageFont.truetype(str(ROOT / "fonts" / "Inter-SemiBold.ttf"), 48)  # px a line, far more than are seen


def lettering(text: str, color: tuple[int, int, int]) -> NDArray:
    """(h, w, 4) uint8, a line of text on nothing: one colour, and how much of each pixel it covers."""
    ascent, descent = FONT.getmetrics()
    cover = Image.new("L", (round(FONT.getlength(text)) + 4, ascent + descent))
    ImageDraw.Draw(cover).text((2, 0), text, 255, FONT)
    alpha = np.asarray(cover)[..., None]
    return np.concatenate([np.broadcast_to(np.array(color, np.uint8), (*alpha.shape[:2], 3)), alpha], axis=-1)
