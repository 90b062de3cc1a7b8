"""The paper's equations with the numbers of this moment. MathML: its conversion is cached, the numbers are put in."""

from collections.abc import Sequence
from functools import cache

import numpy as np
from latex2mathml.converter import convert
from numpy.typing import NDArray

from ..evaluation import conflict, residual
from ..geometry.affine import fit_affine_fundamental
from ..servo import SERVOS
from ..servo.broyden import BroydenState
from ..servo.gradient import GradientState
from ..servo.trust_region import TrustState
from ..snapshot import Snapshot
from ..transfer import TRANSFERS
from ..transfer.epipolar import constraints, linear_system
from . import svg

HOLE = "@"  # stands in LaTeX, as \text{@}, where a number goes
_N = r"\text{@}"


def draw_equations(snapshot: Snapshot, chosen: int | None = None) -> str:
    """HTML. chosen: the point that Eqs. (1) and (4) are shown for, by default the one with the largest residual."""
    cards = []
    if snapshot.transfer is not None:
        point = _shown_point(snapshot, chosen)
        cards = [_constraint(snapshot, point), _transfer(snapshot, point)]
    return _cards(*cards, _conflict(snapshot), _law(snapshot))


def draw_conflict(snapshot: Snapshot) -> str:
    """HTML of Eq. (6) alone, for the room under the images of a wide window."""
    return _cards(_conflict(snapshot))


def draw_law(snapshot: Snapshot) -> str:
    """HTML of the servo's law alone, for the room under the landscape of a wide window."""
    return _cards(_law(snapshot))


def _shown_point(snapshot: Snapshot, chosen: int | None) -> int:
    if chosen is not None and snapshot.usable[chosen]:
        return chosen
    return int(np.nanargmax((snapshot.e**2).sum(1)))


# Eq. (6), the conflict

_CONFLICT = r"E=\frac{1}{2N}\sum_{i=1}^{N}\left({}^{L}𝐞_i^{\top}\,{}^{L}𝐞_i+{}^{R}𝐞_i^{\top}\,{}^{R}𝐞_i\right)"


_RANK3 = rf"E=\frac{{1}}{{2N}}\sum_{{k=1}}^{{5}}\lambda_k(𝐖)={_N}"


def _conflict(snapshot: Snapshot) -> str:
    if snapshot.transfer is None:
        return _card("(6)", "", _fill(_CONFLICT + rf"={_N}", [svg.MISSING]), "too few points are seen in all images")
    if snapshot.settings.transfer == "rank3":
        return _card(
            "", "in place of (6): what all four images leave beyond rank 3", _fill(_RANK3, [_short(snapshot.E)]), ""
        )
    e = snapshot.e[snapshot.usable]
    left, right = (e[:, :2] ** 2).sum(), (e[:, 2:] ** 2).sum()
    numbers = [*(_short(value) for value in (left, right)), str(2 * len(e)), _short(snapshot.E)]
    math = _fill(_CONFLICT + rf"=\frac{{{_N}+{_N}}}{{{_N}}}={_N}", numbers)
    return _card("(6)", "conflict, sums over L and over R", math, "")


# Eqs. (1) and (4), the epipolar geometry and what is solved for


def _constraint(snapshot: Snapshot, point: int) -> str:
    views = snapshot.views.select(snapshot.usable)
    f, f33 = fit_affine_fundamental(views.demo_left, views.own_left)
    u = np.concatenate([snapshot.views.demo_left[point], snapshot.views.own_left[point]])
    value = float(u @ f + f33)
    name = svg.point_name(point)
    terms = "".join(_signed(factor, 2) + f"·{svg.number(x, 0)}" for factor, x in zip(f.tolist(), u.tolist()))
    sum_of_terms = (terms + _signed(float(f33), 0)).removeprefix(" + ")
    math = _fill(
        rf"{{}}^{{lL}}𝐮_{{{_N}}}^{{\top}}\;{{}}^{{lL}}𝐟+{{}}^{{lL}}f_{{33}}={_N}={_N}",
        [name, sum_of_terms, svg.number(value, 2)],
        "vi-long",
    )
    return _card("(1)", f"point {name} in l and L, px; 0 where the geometry fits", math, "")


def _transfer(snapshot: Snapshot, point: int) -> str:
    name = svg.point_name(point)
    recovered = snapshot.recovered[point]
    views = snapshot.views.select(snapshot.usable)
    mean = views.demo.mean(0)
    if snapshot.settings.transfer == "epipolar":
        demo, own = views.demo - mean, views.own - views.own.mean(0)
        A, B = _system(demo, own)
        side = -B @ (snapshot.views.demo[point] - mean)
        math = _fill(
            rf"𝐀\,{{}}^{{LR}}\hat{{𝐮}}_{{{_N}}}=-𝐁𝐜_{{{_N}}}:\;{_matrix(5, 4)}{_column(4)}\approx{_column(5)}",
            [name, name, *_each(A, 2), *_each(recovered - views.own.mean(0), 1), *_each(side, 1)],
            "vi-wide",
        )
        return _card("(4)", f"point {name} recovered, px about the centroids: so f₃₃ = 0", math, "")
    if snapshot.settings.transfer == "projective":
        return _projective(snapshot, point)
    M = snapshot.transfer.matrix
    math = _fill(
        rf"{{}}^{{LR}}\hat{{𝐮}}_{{{_N}}}={_column(4)}+{_matrix(4, 4)}{_column(4)}={_column(4)}",
        [
            name, *_each(views.own.mean(0), 0), *_each(M, 2), *_each(snapshot.views.demo[point] - mean, 1),
            *_each(recovered, 1),
        ],
        "vi-wide",
    )  # fmt: skip
    return _card("", f"in place of (4), point {name}: centroid + map · (c − its centroid), px", math, "")


def _projective(snapshot: Snapshot, point: int) -> str:
    fitted, name = snapshot.transfer, svg.point_name(point)
    u = (snapshot.views.demo[point] - fitted.demo_mean) @ fitted.basis
    shape = fitted.coefficients[0] + u @ fitted.coefficients[1:]
    math = _fill(
        rf"{{}}^{{LR}}\hat{{𝐮}}_{{{_N}}}=\bar{{𝐲}}+\frac{{𝐚_0+𝐀^{{\top}}𝐮_{{{_N}}}}}{{1+𝐩\cdot 𝐮_{{{_N}}}}}"
        rf"={_column(4)}+{_column(4)}\big/{_N}={_column(4)}",
        [
            name, name, name, *_each(fitted.own_mean, 0), *_each(shape, 1), svg.number(float(1 + u @ fitted.p), 3),
            *_each(snapshot.recovered[point], 1),
        ],
        "vi-wide",
    )  # fmt: skip
    return _card("", f"in place of (4), point {name}: one depth for L and R, px", math, "")


def _system(demo: NDArray, own: NDArray) -> tuple[NDArray, NDArray]:
    """A (5, 4) and B (5, 4) of Eq. (4). demo, own: (N, 4) px, centred."""
    A, B = linear_system(constraints(demo, own))
    return A[0], B[0]


# The servo that runs


def _law(snapshot: Snapshot) -> str:
    state = snapshot.servo_state
    if isinstance(state, GradientState):
        return _gradient(snapshot, state)
    if isinstance(state, BroydenState):
        return _broyden(snapshot, state)
    if isinstance(state, TrustState):
        return _trust_region(snapshot, state)
    if snapshot.settings.servo.startswith("gradient"):
        c = SERVOS[snapshot.settings.servo].constants
        first = [svg.number(value) for value in c.jacobian]
        math = _fill(_GRADIENT + rf",\quad\hat{{𝐉}}_0={_row(2)}", first)
        return _card("(13), (14)", "no motion yet", math, "")
    return _card(
        "", "no motion yet", _fill(_TRUST if snapshot.settings.servo == "trust-region" else _BROYDEN, [], "vi-wide"), ""
    )


_GRADIENT = r"𝐮=-𝐊\,\hat{𝐉}^{\top}E"
_BROYDEN = r"\hat{𝐲}(𝛉)=𝐲_c+𝐉\,(𝛉-𝐜),\quad 𝛉^{*}=\underset{|𝛉-𝐜|_{\infty}\le D}{\mathrm{arg\,min}}\;E(\hat{𝐲}(𝛉))"


def _gradient(snapshot: Snapshot, state: GradientState) -> str:
    c = SERVOS[snapshot.settings.servo].constants
    u = -c.gain * state.jacobian * state.E
    m = len(u)
    math = _fill(
        rf"{_GRADIENT}=-{_N}\cdot{_column(m)}\cdot{_N}={_column(m)}",
        [f"{c.gain:g}", *_each(state.jacobian, 2), _short(state.E), *(number + "°" for number in _each(u, 2))],
        "vi-wide",
    )
    note = "Ĵ learned from own motions, px² a degree; K fixed."
    made = np.degrees(snapshot.moved)
    if np.any(np.abs(made - u) > 0.005):
        bound = f"bound {c.max_step_deg:g}°" if np.isfinite(c.max_step_deg) else "limits"
        dither = ", dither" if c.dither_deg else ""
        note = f"Ĵ learned, K fixed. Made ({_degrees(made)}): {bound}{dither}."
    return _card("(13)", "this motion", math, note)


def _broyden(snapshot: Snapshot, state: BroydenState) -> str:
    if state.probe:
        made = _degrees(np.degrees(snapshot.moved))
        note = f"This motion, ({made}), is a probe: it teaches a first column of J."
        return _card("", "servo: the images are learned, not E", _fill(_BROYDEN, []), note)
    math = _fill(_BROYDEN, [])
    centre = state.best.displacement
    step = np.degrees(snapshot.theta - np.radians(snapshot.settings.start_deg) - centre)
    note = f"D = {np.degrees(state.radius):.3g}°. "
    if snapshot.status in ("converged", "stalled"):
        note += "The next step would be below 0.1°: the servo rests."
    elif state.promised is not None and snapshot.transfer is not None:
        measured = _E_of(snapshot, state.best.own) - snapshot.E
        note += (
            f"θ* − c = ({_degrees(step)}). E was to fall by <b>{_short(state.promised)}</b>, and fell by "
            f"<b>{_short(measured)}</b> px²."
        )
    return _card("", "servo: the images are learned, not E", math, note)


_TRUST = (
    r"\hat{𝐲}(𝛉)=𝐲_c+\sum_{k}𝛂_k\,\kappa(𝛉-𝐜,\,𝛉_k-𝐜),\quad "
    r"𝛉^{*}=\underset{|𝛉-𝐜|_{\infty}\le D}{\mathrm{arg\,min}}\;E(\hat{𝐲}(𝛉))"
)


def _trust_region(snapshot: Snapshot, state: TrustState) -> str:
    made, count = _degrees(np.degrees(snapshot.moved)), len(state.visits)
    note = f"The images are predicted from {count} postures visited; D = {np.degrees(state.radius):.3g}°. "
    if state.probe:
        note += f"This motion, ({made}), is a probe: it teaches what the predictions know least."
    elif snapshot.status == "converged":
        note += "What is left of E leaves no room for a displacement worth a motion: the servo rests."
    elif snapshot.status == "stalled":
        note += "Neither transfer nor restart led further: the servo rests."
    elif state.promised is not None:
        note += f"This motion, ({made}), was to lower E by <b>{_short(state.promised)}</b> px²."
    return _card("", "servo: the images are predicted, E is asked", _fill(_TRUST, [], "vi-wide"), note)


def _E_of(snapshot: Snapshot, own: NDArray) -> float:
    """E of images that were really seen, (N, 4) px, against the demonstrator as now seen."""
    views = snapshot.views.select(snapshot.usable).with_own(own[snapshot.usable])
    if not np.isfinite(views.own).all():
        return np.nan
    return float(conflict(residual(TRANSFERS[snapshot.settings.transfer](views), views)))


# MathML


def _cards(*cards: str) -> str:
    return f'<div class="vi-eqs">{"".join(cards)}</div>'


def _card(number: str, title: str, math: str, note: str) -> str:
    head = f"<b>{number}</b> {title}".strip()
    tail = f'<span class="vi-note">{note}</span>' if note else ""
    return f'<div class="vi-eq">{head}{math}{tail}</div>'


@cache
def _mathml(latex: str) -> tuple[str, ...]:
    """The conversion, cut at its holes."""
    return tuple(convert(latex, display="block").replace(f"<mtext>{HOLE}</mtext>", f"<mn>{HOLE}</mn>").split(HOLE))


def _fill(latex: str, numbers: Sequence[str], classes: str = "") -> str:
    pieces = _mathml(latex)
    if len(pieces) != len(numbers) + 1:
        raise ValueError(f"{len(numbers)} numbers for {len(pieces) - 1} holes in {latex}")
    filled = "".join(piece + number for piece, number in zip(pieces, [*numbers, ""]))
    return filled.replace("<math ", f'<math class="{classes}" ', 1) if classes else filled


def _matrix(rows: int, columns: int) -> str:
    body = r"\\".join("&".join([_N] * columns) for _ in range(rows))
    return rf"\begin{{bmatrix}}{body}\end{{bmatrix}}"


def _column(count: int) -> str:
    return _matrix(count, 1)


def _row(count: int) -> str:
    return _matrix(1, count)


def _each(values: NDArray, digits: int) -> list[str]:
    """A zero that is one by construction has no decimals."""
    return [svg.number(value, digits if value else 0) for value in np.asarray(values).ravel().tolist()]


def _signed(value: float, digits: int) -> str:
    text = svg.number(value, digits)
    return f" {text[0]} {text[1:]}" if text.startswith(svg.MINUS) else f" + {text}"


def _degrees(values: NDArray) -> str:
    return ", ".join(svg.number(value, 2 if abs(value) < 1 else 1) + "°" for value in values.tolist())


def _short(value: float) -> str:
    return svg.number(value, 2 if abs(value) < 10 else 1 if abs(value) < 100 else 0)
