"""What a pixel of noise costs at each joint: bars, and in words which joints are weakly observable."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.observability import weak_joints
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
    words = [svg.text(0, y + 15 * k, line, "" if k else "vi-b") for k, line in enumerate(sentences(joints, spread))]
    return head + bars + "".join(words)


def draw_bars(joints: Sequence[int], spread: NDArray, width: float, row: float) -> str:
    """A row a joint: its name, a bar from 0, the degrees; weakly observable ones amber and with a diamond."""
    degrees = np.degrees(spread)
    largest = np.max(degrees[np.isfinite(degrees)], initial=1e-9)
    weak, parts, thick = weak_joints(spread), [], min(BAR, row - 3)
    for k, (joint, value) in enumerate(zip(joints, degrees)):
        y = row * (k + 0.5)
        length = (width - LEFT - RIGHT) * min(value / largest, 1.0)
        kind = "vi-amber" if k in weak else "vi-bar-cost"
        parts.append(
            svg.text(LEFT - 8, y + 4, svg.joint_symbol(joint), "vi-end")
            + f'<rect class="{kind}" x="{LEFT}" y="{y - thick / 2:.1f}" width="{length:.1f}" height="{thick:.1f}"/>'
            + svg.text(LEFT + length + 6, y + 4, _degrees(value), "vi-b" if k in weak else "")
        )
        if k in weak:
            mark = np.array([[LEFT + length + 12 + 6.4 * len(_degrees(value)), y]])
            parts.append(f'<path class="vi-amber" d="{svg.diamonds(mark, 4.5)}"/>')
    return "".join(parts)


def sentences(joints: Sequence[int], spread: NDArray) -> list[str]:
    """Which joints are weakly observable, in short lines."""
    degrees, weak = np.degrees(spread), weak_joints(spread)
    if not weak:
        return [f"No joint is much weaker than the others: 1 px costs {_degrees(degrees.max())} at most."]
    named = [str(joints[k]) for k in weak]
    costs = _listed([_degrees(degrees[k]) for k in weak])
    rest = np.delete(degrees, weak)
    first = f"Joint {named[0]} is" if len(weak) == 1 else f"Joints {_listed(named)} are"
    return [f"{first} weakly observable:", f"1 px costs {costs} there, {_degrees(rest.max())} at most at the others."]


def described(joints: Sequence[int], spread: NDArray) -> str:
    """All joints in a few words, for a caption."""
    costs = (f"{svg.joint_symbol(joint)} {_degrees(value)}" for joint, value in zip(joints, np.degrees(spread)))
    return f"1 px costs {', '.join(costs)}"


def _degrees(value: float) -> str:
    return svg.number(value) + ("°" if np.isfinite(value) else "")


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
