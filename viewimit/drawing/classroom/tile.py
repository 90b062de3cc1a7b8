"""One student's session, small: the landscape, the path in it, the state, and the truth. HTML."""

import base64
import io
import itertools
import secrets
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from PIL import Image

from ...servo import ServoStatus
from .. import svg
from ..status import DIAMOND, DOT, RING, SQUARE

SIZE = 180, 92  # units
SHAPES = {
    "lost": SQUARE,
    ServoStatus.MAX_MOTIONS: SQUARE,
    ServoStatus.NO_PROGRESS: DIAMOND,
    ServoStatus.UNOBSERVABLE: DIAMOND,
    ServoStatus.MOVING: DOT.format("learner"),
    "paused": RING.format("learner"),
    ServoStatus.READY: RING.format("secondary"),
    ServoStatus.SETTLED: RING.format("recovered"),
    "arrived": DOT.format("recovered"),
}
WORDS = {
    "lost": "lost",
    ServoStatus.MAX_MOTIONS: "stopped",
    ServoStatus.NO_PROGRESS: "stuck",
    ServoStatus.UNOBSERVABLE: "cannot tell",
    ServoStatus.MOVING: "moving",
    "paused": "paused",
    ServoStatus.READY: "not begun",
    ServoStatus.SETTLED: "settled",
    "arrived": "arrived",
}
STUCK = {"lost", ServoStatus.MAX_MOTIONS, ServoStatus.NO_PROGRESS, ServoStatus.UNOBSERVABLE}
_OWN, _ids = secrets.token_hex(3), itertools.count()


@dataclass(frozen=True)
class Tile:
    """state: of SHAPES; E: px²; off: degrees, the truth; path: postures in degrees, the last is now; demo: the
    demonstrator's; plane: (low, high) of both joints, degrees; hills: rows and columns, and their shades row for row
    from the lowest posture, a byte each; note: instead of the sentence about the motions."""

    name: str
    state: str
    E: float | None
    off: float | None
    motions: int
    path: tuple[tuple[float, float], ...] = ()
    demo: tuple[float, float] | None = None
    plane: tuple[tuple[float, float], tuple[float, float]] | None = None
    hills: tuple[int, int, bytes] = (0, 0, b"")
    note: str = ""


@lru_cache(2048)
def draw_tile(tile: Tile) -> str:
    """Of the class vi-tile."""
    E = "–" if tile.E is None else svg.short_E(tile.E)
    words = svg.escape(tile.note) or f"{tile.motions} · E {E}"
    off = "" if tile.off is None else f"{svg.number(tile.off, 1)}° off"
    name = f"<b>{svg.escape(tile.name)}</b>" if tile.name else f"<span>{WORDS[tile.state]}</span>"
    stuck = " vi-tile-stuck" if tile.state in STUCK else ""
    icon = f'<svg viewBox="0 0 22 22" aria-hidden="true">{SHAPES[tile.state]}</svg>'
    return (
        f'<div class="vi-tile{stuck}" data-state="{tile.state}">{_landscape(tile)}'
        f'<div class="vi-tile-words">{icon}{name}</div>'
        f'<div class="vi-tile-words"><span>{words}</span><i class="vi-tells">{off}</i></div></div>'
    )


def _landscape(tile: Tile) -> str:
    w, h = SIZE
    parts = [f'<rect class="vi-plane" width="{w}" height="{h}"/>']
    if tile.plane is None:
        parts.append(svg.text(w / 2, h / 2 + 4, "other joints move", "vi-2nd vi-mid"))
        return _wrapped(parts)
    parts.append(_hills(tile.hills))
    low, high = np.array(tile.plane, float).T
    place = lambda degrees: np.array([0, h]) + np.array([w, -h]) * ((degrees - low) / (high - low))[..., ::-1]
    if tile.demo is not None:
        parts.append(f'<path class="vi-seen vi-tells" d="{svg.diamonds(place(np.array(tile.demo))[None], 5)}"/>')
    if tile.path:
        path = place(np.array(tile.path, float))
        line = svg.path(path)
        parts.append(f'<path class="vi-tile-case" d="{line}"/><path class="vi-line-own" d="{line}"/>')
        x, y = path[-1]
        parts.append(f'<circle class="vi-now" cx="{x:.1f}" cy="{y:.1f}" r="6"/>')
    return _wrapped(parts)


def _wrapped(parts: list[str]) -> str:
    return f'<svg class="vi" viewBox="0 0 {SIZE[0]} {SIZE[1]}" aria-hidden="true">{"".join(parts)}</svg>'


def _hills(hills: tuple[int, int, bytes]) -> str:
    """A rectangle of one colour through a grey picture, which is coarse, and smoothed by the browser."""
    rows, columns, shades = hills
    if not shades or len(shades) != rows * columns:
        return ""
    w, h = SIZE
    name = f"vi-t{_OWN}-{next(_ids)}"
    dx, dy = w / (columns - 1), h / (rows - 1)
    return (
        f'<mask id="{name}"><image x="{-dx / 2:.2f}" y="{-dy / 2:.2f}" width="{w + dx:.2f}" height="{h + dy:.2f}"'
        f' preserveAspectRatio="none" href="{_picture(rows, columns, shades)}"/></mask>'
        f'<rect class="vi-hills vi-tells" width="{w}" height="{h}" mask="url(#{name})"/>'
    )


@lru_cache(256)
def _picture(rows: int, columns: int, shades: bytes) -> str:
    buffer = io.BytesIO()
    Image.fromarray(np.frombuffer(shades, np.uint8).reshape(rows, columns)[::-1]).save(buffer, "PNG")
    return f"data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}"
