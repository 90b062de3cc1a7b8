"""The learner's posture read-out: a bar a joint with its own position, the demonstrator's mark and the gap.

Many joints stand in two columns, so that they are seen together with the demonstrator's sliders.
"""

from numpy.typing import NDArray

from ..simulation.scene import Scene
from . import svg

WIDTH, NARROW, HEIGHT, INSET = 150, 74, 22, 8  # px of a bar's drawing, in one column and in two
MANY = 4  # joints


def draw_learner(scene: Scene, theta: NDArray, theta_demo: NDArray) -> str:
    """theta, theta_demo: (m,) rad. The demonstrator's marks are the truth, for the viewer."""
    rows, many = [], len(theta) >= MANY
    width = NARROW if many else WIDTH
    for joint, own, demo, low, high in zip(scene.moving_joints, theta, theta_demo, scene.lower, scene.upper):
        place = lambda angle, low=low, high=high: INSET + (width - 2 * INSET) * (angle - low) / (high - low)
        x, mark, y = place(own), place(demo), HEIGHT / 2
        value = svg.degrees(own)
        rows.append(
            f'<div class="vi-bar"><span>{svg.joint_symbol(joint)}</span><svg viewBox="0 0 {width} {HEIGHT}">'
            f'<line x1="{INSET}" x2="{width - INSET}" y1="{y}" y2="{y}" class="vi-bar-rail"/>'
            f'<line x1="{x:.1f}" x2="{mark:.1f}" y1="{y}" y2="{y}" class="vi-bar-gap"/>'
            f'<path d="M{mark:.1f} {y - 5.5}l5.5 5.5l-5.5 5.5l-5.5 -5.5z" class="vi-bar-demonstrator"/>'
            f'<circle cx="{x:.1f}" cy="{y}" r="5" class="vi-bar-learner"/></svg><b>{value}</b></div>'
        )
    return f'<div class="vi-bars{" vi-many" if many else ""}">{"".join(rows)}</div>'
