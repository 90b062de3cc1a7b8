"""How 1 px of noise disturbs each joint: bars, and sentences on weakly observable joints.

std_per_px: (m,) rad/px, the standard error of each joint per px of noise. joints: their numbers, from 1.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.observability import unobservable_joints, weak_joints
from ..servo.trust_region.options import MAX_STD_PER_PX
from . import svg

WIDTH, HEIGHT = 424, 229  # px of the drawing that replaces a landscape
LEFT, RIGHT = 34, 60  # px beside the bars
ROW, BAR = 24, 11  # px
TITLE = "What 1 px of noise costs at each joint"
NOTE = "in the own images, at the demonstrator's posture; from the curvature of E"


def draw_observability(joints: Sequence[int], std_per_px: NDArray[np.float64]) -> str:
    """Draw title, a bar per joint, and the sentence."""
    head = f'<text x="0" y="12"><tspan class="vi-b">{TITLE}</tspan></text>' + svg.text(0, 27, NOTE, "vi-2nd")
    row = min(ROW, (HEIGHT - 96) / len(joints))
    bars = f'<g transform="translate(0 38)">{draw_bars(joints, std_per_px, WIDTH, row)}</g>'
    y = 38 + row * len(joints) + 20
    words = [
        svg.text(0, y + 15 * k, line, "" if k else "vi-b")
        for k, line in enumerate(describe_weakness(joints, std_per_px))
    ]
    return head + bars + "".join(words)


def draw_bars(joints: Sequence[int], std_per_px: NDArray[np.float64], width: float, row: float) -> str:
    """Draw a row per joint: its name, a bar, its degrees. Rows are `row` px high, the drawing `width` px wide.

    Bars of weakly observable joints are amber with a diamond; those of unobservable ones take the whole width.
    """
    degrees, unobservable, weak = np.degrees(std_per_px), unobservable_joints(std_per_px), weak_joints(std_per_px)
    largest, longest = np.max(np.delete(degrees, unobservable), initial=1e-9), width - LEFT - RIGHT
    parts, thick = [], min(BAR, row - 3)
    for k, (joint, value) in enumerate(zip(joints, degrees)):
        y, amber = row * (k + 0.5), k in weak or k in unobservable
        length = longest if k in unobservable else longest * value / largest
        words, x = _cost(value), LEFT + 6 if k in unobservable else LEFT + length + 6
        kind = "vi-amber" if amber else "vi-bar-cost"
        parts.append(
            svg.text(LEFT - 8, y + 4, svg.joint_symbol(joint), "vi-end")
            + f'<rect class="{kind}" x="{LEFT}" y="{y - thick / 2:.1f}" width="{length:.1f}" height="{thick:.1f}"/>'
            + svg.text(x, y + 4, words, f"vi-b{' vi-halo' if k in unobservable else ''}" if amber else "")
        )
        if amber:
            mark = np.array([[max(LEFT + length + 8, x + 6 + 6.4 * len(words)), y]])
            parts.append(f'<path class="vi-amber" d="{svg.diamonds(mark, 4.5)}"/>')
    return "".join(parts)


def describe_weakness(joints: Sequence[int], std_per_px: NDArray[np.float64]) -> list[str]:
    """Say in short lines which joints are unobservable or weakly observable."""
    degrees, unobservable = np.degrees(std_per_px), unobservable_joints(std_per_px)
    weak = [k for k in weak_joints(std_per_px) if k not in unobservable]
    rest = np.delete(degrees, [*unobservable, *weak])
    most = f"{_cost(rest.max())} at most" if len(rest) else ""
    if unobservable:
        others = np.delete(degrees, unobservable)
        ending = (
            f"1 px costs {_cost(others.max())} at most at the others."
            if len(others)
            else "Its posture is anyone's guess."
        )
        return [f"{_named(joints, unobservable)} not observable: hardly anything in the images tells.", ending]
    if not weak:
        if len(joints) == 1:
            return [f"1 px costs {_cost(rest.max())}."]
        return [f"No joint is much weaker than the others: 1 px costs {most}."]
    costs = _listed([_cost(degrees[k]) for k in weak])
    return [f"{_named(joints, weak)} weakly observable:", f"1 px costs {costs} there, {most} at the others."]


def describe_costs(joints: Sequence[int], std_per_px: NDArray[np.float64]) -> str:
    """Write the degrees of all joints in a few words, for a caption."""
    unobservable, degrees = unobservable_joints(std_per_px), np.degrees(std_per_px)
    seen = [f"{svg.joint_symbol(joints[k])} {_cost(degrees[k])}" for k in range(len(joints)) if k not in unobservable]
    costs = f"1 px costs {', '.join(seen)}" if seen else ""
    words = (
        f"{', '.join(svg.joint_symbol(joints[k]) for k in sorted(unobservable))} not observable" if unobservable else ""
    )
    return "; ".join(filter(None, (costs, words)))


def _named(joints: Sequence[int], indices: Sequence[int]) -> str:
    numbers = [str(joints[k]) for k in indices]
    return f"Joint {numbers[0]} is" if len(numbers) == 1 else f"Joints {_listed(numbers)} are"


def _cost(degrees: float) -> str:
    return "not observable" if degrees >= np.degrees(MAX_STD_PER_PX) else svg.number(degrees) + "°"


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
