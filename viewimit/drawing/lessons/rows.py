"""Both images of one body beside each other, each match joined across them: level once the images are rectified."""

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from ...geometry.rectification import Rectification
from .. import svg
from ..theme import OBSERVED
from .mended import LAYERS as LAYERS

IMAGE, GAP, HEAD, FOOT = (150, 200), 20, 28, 18  # units
MARGIN = 16  # units around the points
LEAST = 0.01  # px that are stated


def draw_rows(images: NDArray, by: Rectification | None, layers: Collection[str]) -> str:
    """HTML. images: (N, 4) px, matches in [l, r]; by: None while it is not known."""
    each, width = HEAD + IMAGE[1] + FOOT, 2 * IMAGE[0] + GAP
    pairs = {"as seen": images, "rectified": None if by is None else by.apply(images)}
    shown = [(name, found) for name, found in pairs.items() if name in layers and found is not None]
    drawn = "".join(
        f'<g transform="translate(0 {k * each})">{_pair(name, found)}</g>' for k, (name, found) in enumerate(shown)
    )
    label = "Matches of the left and the right eye: " + ", ".join(name for name, _ in shown)
    box = f"0 0 {width} {each * max(len(shown), 1)}"
    return f'<svg class="vi vi-rows" viewBox="{box}" role="img" aria-label="{label}">{drawn}</svg>'


def _pair(name: str, images: NDArray) -> str:
    """Equally large, and at one height."""
    low, high = images.min(0), images.max(0)
    low[[1, 3]], high[[1, 3]] = low[[1, 3]].min(), high[[1, 3]].max()
    scale = float(((np.tile(IMAGE, 2) - 2 * MARGIN) / np.maximum(high - low, 1.0)).min())
    corner = (low + high) / 2 - np.tile(IMAGE, 2) / (2 * scale)
    placed = (images - corner) * scale + np.array([0, HEAD, IMAGE[0] + GAP, HEAD])
    off = float(np.sqrt(np.mean((images[:, 3] - images[:, 1]) ** 2)))
    words = f"rows differ by {'less than ' if off < LEAST else ''}{svg.number(max(off, LEAST), 2)} px"
    parts = [
        svg.text(0, 18, name, "vi-b vi-line-words"),
        svg.text(2 * IMAGE[0] + GAP, 18, words, "vi-end vi-line-words"),
    ]
    for side, view in enumerate("lr"):
        x = side * (IMAGE[0] + GAP)
        parts.append(f'<rect class="vi-plane" x="{x}" y="{HEAD}" width="{IMAGE[0]}" height="{IMAGE[1]}" rx="4"/>')
        parts.append(f'<text class="vi-name vi-halo" x="{x + 8}" y="{HEAD + 18}">{view}</text>')
    parts.append(f'<path class="vi-rows-line" d="{svg.segments(placed[:, :2], placed[:, 2:])}"/>')
    both = np.concatenate([placed[:, :2], placed[:, 2:]])
    parts.append(f'<path class="vi-seen" d="{svg.diamonds(both, OBSERVED + 0.6)}"/>')
    return "".join(parts)
