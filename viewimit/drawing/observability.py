"""What a pixel of noise costs at each joint: bars, and in words which joints are weakly observable."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.observability import unobservable_joints, weak_joints
from ..servo.trust_region.options import MAX_STD_PER_PX
from . import svg

WIDTH, HEIGHT = 424, 229  # px of the drawing where a landscape has no place
LEFT, RIGHT = 34, 60  # px beside the bars
ROW, BAR = 24, 11  # px
TITLE = "What 1 px of noise costs at each joint"
NOTE = "in the own images, at the demonstrator's posture; from the curvature of E"


def draw_observability(joints: Sequence[int], spread: NDArray) -> str:
    """Title, a bar a joint, the sentence. joints: numbers from 1; spread: (m,) rad/px."""
    head = f'<text x="0" y="12"><tspan class="vi-b">{TITLE}</tspan></text>' + svg.text(0, 27, NOTE, "vi-2nd")
    row = min(ROW, (HEIGHT - 96) / len(joints))
    bars = f'<g transform="translate(0 38)">{draw_bars(joints, spread, WIDTH, row)}</g>'
    y = 38 + row * len(joints) + 20
    words = [
        svg.text(0, y + 15 * k, line, "" if k else "vi-b") for k, line in enumerate(describe_weakness(joints, spread))
    ]
    return head + bars + "".join(words)


def draw_bars(joints: Sequence[int], spread: NDArray, width: float, row: float) -> str:
    """A row a joint: its name, a bar from 0, the degrees; weakly observable ones amber and with a diamond, those that
    are not observable as long as there is room."""
    degrees, untold, weak = np.degrees(spread), unobservable_joints(spread), weak_joints(spread)
    largest, longest = np.max(np.delete(degrees, untold), initial=1e-9), width - LEFT - RIGHT
    parts, thick = [], min(BAR, row - 3)
    for k, (joint, value) in enumerate(zip(joints, degrees)):
        y, amber = row * (k + 0.5), k in weak or k in untold
        length = longest if k in untold else longest * value / largest
        words, x = _cost(value), LEFT + 6 if k in untold else LEFT + length + 6
        kind = "vi-amber" if amber else "vi-bar-cost"
        parts.append(
            svg.text(LEFT - 8, y + 4, svg.joint_symbol(joint), "vi-end")
            + f'<rect class="{kind}" x="{LEFT}" y="{y - thick / 2:.1f}" width="{length:.1f}" height="{thick:.1f}"/>'
            + svg.text(x, y + 4, words, f"vi-b{' vi-halo' if k in untold else ''}" if amber else "")
        )
        if amber:
            mark = np.array([[max(LEFT + length + 8, x + 6 + 6.4 * len(words)), y]])
            parts.append(f'<path class="vi-amber" d="{svg.diamonds(mark, 4.5)}"/>')
    return "".join(parts)


def describe_weakness(joints: Sequence[int], spread: NDArray) -> list[str]:
    """Which joints are not observable, or weakly, in short lines."""
    degrees, untold = np.degrees(spread), unobservable_joints(spread)
    weak = [k for k in weak_joints(spread) if k not in untold]
    rest = np.delete(degrees, [*untold, *weak])
    most = f"{_cost(rest.max())} at most" if len(rest) else ""
    if untold:
        others = np.delete(degrees, untold)
        ending = (
            f"1 px costs {_cost(others.max())} at most at the others."
            if len(others)
            else "Its posture is anyone's guess."
        )
        return [f"{_named(joints, untold)} not observable: hardly anything in the images tells.", ending]
    if not weak:
        if len(joints) == 1:
            return [f"1 px costs {_cost(rest.max())}."]
        return [f"No joint is much weaker than the others: 1 px costs {most}."]
    costs = _listed([_cost(degrees[k]) for k in weak])
    return [f"{_named(joints, weak)} weakly observable:", f"1 px costs {costs} there, {most} at the others."]


def describe_costs(joints: Sequence[int], spread: NDArray) -> str:
    """All joints in a few words, for a caption."""
    untold, degrees = unobservable_joints(spread), np.degrees(spread)
    told = [f"{svg.joint_symbol(joints[k])} {_cost(degrees[k])}" for k in range(len(joints)) if k not in untold]
    costs = f"1 px costs {', '.join(told)}" if told else ""
    blind = f"{', '.join(svg.joint_symbol(joints[k]) for k in sorted(untold))} not observable" if untold else ""
    return "; ".join(filter(None, (costs, blind)))


def _named(joints: Sequence[int], indices: Sequence[int]) -> str:
    numbers = [str(joints[k]) for k in indices]
    return f"Joint {numbers[0]} is" if len(numbers) == 1 else f"Joints {_listed(numbers)} are"


def _cost(degrees: float) -> str:
    return "not observable" if degrees >= np.degrees(MAX_STD_PER_PX) else svg.number(degrees) + "°"


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
