"""The paper's equations with the numbers of a snapshot, as cards of MathML.

Eqs. (1) and (6) are written here, all others by the transfer and the servo. The conversion of LaTeX is cached; only the
numbers are filled in.
"""

from functools import cache

import numpy as np
from latex2mathml.converter import convert

from ..estimation.equations import HOLE, MARK, MISSING, Equation, matrix, number, short, signed
from ..estimation.rectification import RectifiedTransfer
from ..geometry.arrays import Floats
from ..geometry.rectification import Rectification
from ..loop.snapshot import Snapshot
from ..servo import LastMotion


def draw_equations(snapshot: Snapshot, chosen: int | None = None) -> str:
    """Draw `equations_of` a snapshot as HTML."""
    return f'<div class="vi-eqs">{"".join(map(_card, equations_of(snapshot, chosen)))}</div>'


def equations_of(snapshot: Snapshot, chosen: int | None = None) -> tuple[Equation, ...]:
    """List a snapshot's equations. chosen: the point of Eqs. (1), (4); None for the one with the largest residual."""
    recovery: tuple[Equation, ...] = ()
    if snapshot.transfer is not None:
        is_usable = chosen is not None and snapshot.usable[chosen]
        point = chosen if is_usable else int(np.nanargmax((snapshot.e**2).sum(1)))
        demo, own, name = snapshot.views.demo[point], snapshot.views.own[point], str(point)
        method, fitted = snapshot.method, snapshot.transfer
        if isinstance(fitted, RectifiedTransfer):
            demo, own = map(fitted.rectification.apply, (demo, own))
            recovery, fitted = (_rectification(fitted.rectification),), fitted.between
        recovery = *recovery, _constraint(snapshot, demo, own, name), *method.equations(fitted, demo, own, name)
    last = LastMotion(
        E=snapshot.E,
        seen=snapshot.views.visible[:, 2:],
        displacement=snapshot.commanded - snapshot.settings.start_rad,
        moved=snapshot.moved,
        status=snapshot.status,
    )
    return *recovery, _conflict(snapshot), *snapshot.servo.equations(snapshot.servo_state, last)


_CONFLICT = r"E=\frac{1}{2N}\sum_{i=1}^{N}\left({}^{L}𝐞_i^{\top}\,{}^{L}𝐞_i+{}^{R}𝐞_i^{\top}\,{}^{R}𝐞_i\right)"


def _conflict(snapshot: Snapshot) -> Equation:
    """Write Eq. (6), or the equation that the transfer has instead."""
    if snapshot.transfer is None:
        note = "All four pictures show too few points."
        return Equation("(6)", "", f"{_CONFLICT}={HOLE}", (MISSING,), note)
    own_equation = snapshot.method.conflict_equation
    if own_equation is not None:
        return own_equation(snapshot.E)
    e = snapshot.e[snapshot.usable]
    sums = short((e[:, :2] ** 2).sum()), short((e[:, 2:] ** 2).sum())
    latex = rf"{_CONFLICT}=\frac{{{HOLE}+{HOLE}}}{{{HOLE}}}={HOLE}"
    return Equation("(6)", "conflict, sums over L and over R", latex, (*sums, str(2 * len(e)), short(snapshot.E)))


def _constraint(snapshot: Snapshot, demo: Floats, own: Floats, name: str) -> Equation:
    """Write Eq. (1) for a point's images in l and L. demo, own: (4,) px, rectified if the transfer is."""
    pairs = snapshot.fundamental
    assert pairs is not None  # there is a transfer, so there are enough points
    f, f33 = pairs.f[0], float(pairs.f33[0])  # of l and L
    u = np.concatenate([demo[:2], own[:2]])
    terms = "".join(signed(factor, 3) + f"·{number(x, 0)}" for factor, x in zip(f.tolist(), u.tolist()))
    sum_of_terms = (terms + signed(f33, 0)).removeprefix(" + ")
    latex = rf"{{}}^{{lL}}𝐮_{{{HOLE}}}^{{\top}}\;{{}}^{{lL}}𝐟+{{}}^{{lL}}f_{{33}}\approx{HOLE}\approx{HOLE}"
    title = f"point {name} in l and L, px; 0 where the geometry fits"
    return Equation("(1)", title, latex, (name, sum_of_terms, number(float(u @ f + f33), 1)), long=True)


def _rectification(by: Rectification) -> Equation:
    """Write the homographies that rectify the left and the right images."""
    latex = rf"𝐇_l={matrix(3, 3)},\;𝐇_r={matrix(3, 3)}"
    note = "The matched points rectify the pictures. Below, px are those of rectified pictures."
    rows = [row for H in (by.left, by.right) for row in H.tolist()]
    numbers = [number(value, digits) for row in rows for value, digits in zip(row, (4, 4, 1))]
    return Equation("", "rectification: matched points get equal rows", latex, tuple(numbers), note, wide=True)


def _card(equation: Equation) -> str:
    head = f"<b>{equation.number}</b> {equation.title}".strip()
    tail = f'<span class="vi-note">{equation.note}</span>' if equation.note else ""
    lines = f' data-lines="{" ".join(equation.lines)}"' if equation.lines else ""
    hint = '<span class="vi-note">Point at a row of 𝐀: its line lights up in the pictures.</span>' if lines else ""
    return f'<div class="vi-eq"{lines}>{head}{filled(equation)}{tail}{hint}</div>'


def mathml(latex: str) -> str:
    """Convert LaTeX without holes."""
    return _mathml(latex)[0]


def filled(equation: Equation) -> str:
    """Convert an equation to MathML and fill in its numbers."""
    pieces = _mathml(equation.latex)
    text = "".join(piece + value for piece, value in zip(pieces, [*equation.numbers, ""], strict=True))
    classes = "vi-long" if equation.long else "vi-broad" if equation.wide else ""
    return text.replace("<math ", f'<math class="{classes}" ', 1) if classes else text


@cache
def _mathml(latex: str) -> tuple[str, ...]:
    """Convert LaTeX and cut the result at its holes."""
    return tuple(convert(latex, display="block").replace(f"<mtext>{MARK}</mtext>", f"<mn>{MARK}</mn>").split(MARK))
