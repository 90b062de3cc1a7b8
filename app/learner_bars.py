"""The learner's posture read-out: a bar a joint with its own position, the demonstrator's mark and the gap."""

import numpy as np
from numpy.typing import NDArray

from viewimit.scene import Scene

WIDTH, HEIGHT, INSET = 150, 22, 8  # px of a bar's drawing


def draw_learner(scene: Scene, theta: NDArray, theta_demo: NDArray) -> str:
    """theta, theta_demo: (m,) rad. The demonstrator's marks are the truth, for the viewer."""
    rows = []
    for joint, own, demo, low, high in zip(scene.moving_joints, theta, theta_demo, scene.lower, scene.upper):
        place = lambda angle, low=low, high=high: INSET + (WIDTH - 2 * INSET) * (angle - low) / (high - low)
        x, mark, y = place(own), place(demo), HEIGHT / 2
        digits = "".join("₀₁₂₃₄₅₆₇₈₉"[int(digit)] for digit in str(joint))
        value = f"{np.degrees(own):.1f}°".replace("-", "−")
        rows.append(
            f'<div class="vi-bar"><span>θ{digits}</span><svg viewBox="0 0 {WIDTH} {HEIGHT}">'
            f'<line x1="{INSET}" x2="{WIDTH - INSET}" y1="{y}" y2="{y}" class="vi-bar-rail"/>'
            f'<line x1="{x:.1f}" x2="{mark:.1f}" y1="{y}" y2="{y}" class="vi-bar-gap"/>'
            f'<path d="M{mark:.1f} {y - 5.5}l5.5 5.5l-5.5 5.5l-5.5 -5.5z" class="vi-bar-demonstrator"/>'
            f'<circle cx="{x:.1f}" cy="{y}" r="5" class="vi-bar-learner"/></svg><b>{value}</b></div>'
        )
    return f'<div class="vi-bars">{"".join(rows)}</div>'


CSS = """
.vi-bars{padding:0 8px 2px;font-size:14px}
.vi-bar{display:flex;align-items:center;gap:8px;height:22px}
.vi-bar svg{flex:1;min-width:0;height:22px}
.vi-bar b{color:var(--learner);min-width:58px;text-align:right;font-variant-numeric:tabular-nums}
.vi-bar-rail{stroke:var(--rule);stroke-width:4;stroke-linecap:round}
.vi-bar-gap{stroke:var(--residual);stroke-width:2.4}
.vi-bar-learner{fill:var(--learner)}
.vi-bar-demonstrator{fill:var(--demonstrator);stroke:var(--demonstrator-edge);stroke-width:1}
.vi-keys{display:flex;flex-wrap:wrap;gap:5px 9px;padding:2px 12px;font-size:12.5px;color:var(--secondary)}
.vi-keys kbd{font:600 12px Inter,sans-serif;border:1px solid var(--rule);border-radius:4px;padding:1px 6px;
background:var(--card);color:var(--ink)}
.mantine-Slider-markLabel{display:none}
.vi-lesson{padding:0 14px 2px;font-size:13px;line-height:1.35;color:var(--secondary)}
"""
