"""The learner's posture read-out: a bar a joint with its own position, the demonstrator's mark and the gap.

Many joints stand in two columns, so that they are seen together with the demonstrator's sliders.
"""

import numpy as np
from numpy.typing import NDArray

from ..analysis.self_assessment import Assessment
from ..servo.trust_region.options import MAX_STD_PER_PX
from ..simulation.scene import Scene
from . import svg

WIDTH, NARROW, HEIGHT, INSET = 150, 74, 22, 8  # px of a bar's drawing, in one column and in two
MANY = 4  # joints


def draw_learner(scene: Scene, theta: NDArray, theta_demo: NDArray, assessment: Assessment | None = None) -> str:
    """theta, theta_demo: (m,) rad. The demonstrator's marks are the truth, for the viewer. assessment: the learner's
    own; what a pixel would turn a joint by that nothing tells is a hatched band."""
    rows, many = [], len(theta) >= MANY
    band = np.zeros(len(theta))
    if assessment is not None:
        band[assessment.unobservable] = np.maximum(assessment.std_per_px[assessment.unobservable], MAX_STD_PER_PX)
    width = NARROW if many else WIDTH
    limits = zip(scene.lower.tolist(), scene.upper.tolist())
    for k, (joint, own, demo, (low, high)) in enumerate(
        zip(scene.moving_joints, theta.tolist(), theta_demo.tolist(), limits)
    ):
        place = lambda angle, low=low, high=high: INSET + (width - 2 * INSET) * (angle - low) / (high - low)
        x, mark, y = place(own), place(demo), HEIGHT / 2
        value = svg.degrees(own)
        rows.append(
            f'<div class="vi-bar"><span>{svg.joint_symbol(joint)}</span><svg viewBox="0 0 {width} {HEIGHT}">'
            f'<line x1="{INSET}" x2="{width - INSET}" y1="{y}" y2="{y}" class="vi-bar-rail"/>'
            f"{_band(place(max(own - band[k], low)), place(min(own + band[k], high))) if band[k] else ''}"
            f'<line x1="{x:.1f}" x2="{mark:.1f}" y1="{y}" y2="{y}" class="vi-bar-gap"/>'
            f'<path d="M{mark:.1f} {y - 5.5}l5.5 5.5l-5.5 5.5l-5.5 -5.5z" class="vi-bar-demonstrator"/>'
            f'<circle cx="{x:.1f}" cy="{y}" r="5" class="vi-bar-learner"/></svg><b>{value}</b></div>'
        )
    return f'<div class="vi-bars{" vi-many" if many else ""}">{"".join(rows)}</div>'


def _band(left: float, right: float) -> str:
    """px. Hatched by strokes, as a pattern would need a name of its own on the page."""
    strokes = "".join(f"M{x:.1f} {HEIGHT - 4}l4-14" for x in np.arange(left, right - 4, 5))
    edge = f'<rect x="{left:.1f}" y="3.5" width="{right - left:.1f}" height="{HEIGHT - 7}" rx="3"/>'
    return f'<g class="vi-bar-untold">{edge}<path d="{strokes}"/></g>'
