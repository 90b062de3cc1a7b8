"""The servos by name, and a description of each: title, prose and LaTeX.

The mathematics of a servo is in its own module. Only `servo` is required of an entry; all other fields have defaults.
"""

from collections import UserDict

import numpy as np

from ..estimation.equations import HOLE, Equation, angles, column, each, number, row, short
from ..wording import plural, sentences
from .broyden import Broyden, BroydenState
from .estimator.explanation import describe_status as describe_estimator
from .estimator.explanation import equations as estimator_equations
from .estimator.servo import Estimator
from .gradient import RETUNED, Gradient, GradientOptions, GradientState
from .image_jacobian import MIN_STEP_RAD
from .recursive import KALMAN_GAIN, GaussNewton, GaussNewtonState, Kalman, RecursiveState
from .servo import LastMotion, Servo, ServoMethod, servo_method
from .status import TEST_MOVE, ServoStatus


class Servos(UserDict[str, ServoMethod]):
    """Servos by name. Assign a `ServoMethod`, or an object with `start` and `step`; TypeError for anything else."""

    def __setitem__(self, name: str, given: ServoMethod | Servo) -> None:
        super().__setitem__(name, servo_method(given))


NO_STEP = "no step yet"
_GRADIENT_LAW = r"𝐮=-𝐊\,\hat{𝐉}^{\top}E"
_BROYDEN_LAW = r"\hat{𝐲}(𝛉)=𝐲_c+𝐉\,(𝛉-𝐜),\quad 𝛉^{*}=\underset{|𝛉-𝐜|_{\infty}\le D}{\mathrm{arg\,min}}\;E(\hat{𝐲}(𝛉))"
_KALMAN_LAW, _KALMAN_FILTER = r"𝐮=-g\,\hat{𝐉}_e^{+}𝐞", r"𝐤=\frac{𝐏𝐡}{r+𝐡^{\top}𝐏𝐡}"
_GAUSS_NEWTON_LAW = r"𝐮=-(\hat{𝐉}_e^{\top}\hat{𝐉}_e+\mu 𝐃)^{-1}\hat{𝐉}_e^{\top}𝐞"
_WEIGHTED_LEAST_SQUARES = r"\hat{𝐉}=\mathrm{arg\,min}\sum_i\lambda^{k-i}\,|Δ𝐲_i-𝐉𝐡_i|^2"


def _gradient_equations(
    options: GradientOptions, state: GradientState | None, motion: LastMotion
) -> tuple[Equation, ...]:
    if state is None:
        first = tuple(number(value) for value in options.jacobian)
        return (Equation("(13), (14)", NO_STEP, rf"{_GRADIENT_LAW},\quad\hat{{𝐉}}_0={row(len(first))}", first),)
    u = -options.gain * state.jacobian * state.E
    m = len(u)
    note = "Ĵ is learned from the learner's own steps, in px² per degree; K is fixed."
    if np.any(np.abs(np.degrees(motion.moved) - u) > 0.005):
        if not np.isfinite(options.max_step_deg):
            made = "Ĵ is learned, K is fixed. Limits changed the step to ({step})."
        elif options.dither_deg:
            made = "Ĵ is learned, K is fixed. The bound of {bound}° and dither changed the step to ({step})."
        else:
            made = "Ĵ is learned, K is fixed. The bound of {bound}° changed the step to ({step})."
        note = made.format(bound=f"{options.max_step_deg:g}", step=angles(motion.moved))
    latex = rf"{_GRADIENT_LAW}=-{HOLE}\cdot{column(m)}\cdot{HOLE}={column(m)}"
    requested = (angle + "°" for angle in each(u, 2))
    numbers = (f"{options.gain:g}", *each(state.jacobian, 2), short(state.E), *requested)
    return (Equation("(13)", "this step", latex, numbers, note, wide=True),)


def _describe_gradient(state: GradientState, status: ServoStatus) -> str:
    return _not_lower(state.n_since_best) if status == ServoStatus.NO_PROGRESS else ""


def _not_lower(steps: int) -> str:
    return plural("No lower E in {n} step.", "No lower E in {n} steps.", steps).format(n=steps)


def _broyden_equations(state: BroydenState | None, motion: LastMotion) -> tuple[Equation, ...]:
    if state is None:
        return (Equation("", NO_STEP, _BROYDEN_LAW, wide=True),)
    if state.probe:
        note = _probe_note(motion, "J")
    else:
        note = sentences(f"D = {np.degrees(state.radius):.3g}°", _broyden_outcome(state, motion))
    return (Equation("", "servo: the pictures are learned, not E", _BROYDEN_LAW, note=note),)


def _broyden_outcome(state: BroydenState, motion: LastMotion) -> str:
    """Predicted and actual reduction of the last motion.

    If points are hidden, E at its ends is of different points. Then the motion before is shown, which has been judged
    on points known at both ends.
    """
    if motion.status in (ServoStatus.SETTLED, ServoStatus.NO_PROGRESS):
        return "The next step would be under {angle}: the servo rests.".format(angle=f"{np.degrees(MIN_STEP_RAD):g}°")
    if state.predicted_reduction is None or state.best_E is None or not np.isfinite(motion.E):
        return ""
    made = f"θ* − c = ({angles(motion.displacement - state.best.displacement)})."
    predicted = short(state.predicted_reduction)
    if motion.seen.all() and state.best.seen.all():
        text = "E was to fall by <b>{predicted}</b>, and fell by <b>{actual}</b> px²."
        return sentences(made, text.format(predicted=predicted, actual=short(state.best_E - motion.E)))
    text = f"E was to fall by <b>{predicted}</b> px²."
    if state.reductions is None:
        return sentences(made, text)
    expected, found = map(short, state.reductions)
    before = "Before, it was to fall by <b>{predicted}</b>, and fell by <b>{actual}</b> px²."
    return sentences(made, text, before.format(predicted=expected, actual=found))


def _describe_broyden(state: BroydenState, status: ServoStatus) -> str:
    if status == ServoStatus.MOVING:
        return TEST_MOVE if state.probe else ""
    return ""


def _probe_note(motion: LastMotion, jacobian: str = "Ĵ") -> str:
    text = "This step, ({step}), is a test move: it teaches a first column of {jacobian}."
    return text.format(step=angles(motion.moved), jacobian=jacobian)


def _kalman_equations(state: RecursiveState | None, motion: LastMotion) -> tuple[Equation, ...]:
    if state is None:
        return (
            Equation("", NO_STEP, _KALMAN_LAW),
            Equation("", "filter of the image Jacobian", _KALMAN_FILTER),
        )
    latex, numbers = rf"𝐡^{{\top}}𝐤={HOLE},\quad {_KALMAN_FILTER}", (number(state.model.mean_gain, 2),)
    share = Equation("", "filter: share of the picture change that it believes", latex, numbers)
    title = "servo: a share of the residual in each step"
    if state.probe:
        return (Equation("", title, _KALMAN_LAW, note=_probe_note(motion)), share)
    latex = rf"{_KALMAN_LAW}={column(len(state.requested))},\quad g={HOLE}"
    requested = tuple(angle + "°" for angle in each(np.degrees(state.requested), 2))
    return (Equation("", title, latex, (*requested, f"{KALMAN_GAIN:g}"), wide=True), share)


def _gauss_newton_equations(state: GaussNewtonState | None, motion: LastMotion) -> tuple[Equation, ...]:
    fit = Equation("", "Jacobian: least squares with forgetting", _WEIGHTED_LEAST_SQUARES, wide=True)
    title = "servo: damped Gauss-Newton"
    if state is None:
        return (Equation("", NO_STEP, _GAUSS_NEWTON_LAW, wide=True), fit)
    if state.probe:
        return (Equation("", title, _GAUSS_NEWTON_LAW, note=_probe_note(motion), wide=True), fit)
    requested = tuple(angle + "°" for angle in each(np.degrees(state.requested), 2))
    latex = rf"{_GAUSS_NEWTON_LAW}={column(len(requested))},\quad\mu={HOLE}"
    return (Equation("", title, latex, (*requested, number(state.damping, 4)), wide=True), fit)


def _describe_recursive(state: RecursiveState, status: ServoStatus) -> str:
    if status == ServoStatus.NO_PROGRESS:
        return "There is no way on from here." if state.has_patience else _not_lower(state.n_since_best)
    return TEST_MOVE if state.probe and status == ServoStatus.MOVING else ""


def _gradient_method(servo: Gradient, title: str, assumes: str, limitations: str) -> ServoMethod:
    return ServoMethod(
        servo=servo,
        title=title,
        assumes=assumes,
        limitations=limitations,
        slow=True,
        mirror_columns=True,
        equations=lambda state, motion: _gradient_equations(servo.options, state, motion),
        describe_status=_describe_gradient,
    )


SERVOS = Servos(
    {
        "gradient": _gradient_method(
            Gradient(),
            title="Gradient (paper)",
            assumes="E is convex, and the gradient that it has learned stays true.",
            limitations="Its steps shrink with E, and the learned gradient goes out of date: it crawls.",
        ),
        "gradient-retuned": _gradient_method(
            Gradient(RETUNED),
            title="Gradient, retuned",
            assumes="The same, with a larger gain, bounded steps and small random moves.",
            limitations="It takes hundreds of steps. It never stands still, so it never claims to have converged.",
        ),
        "broyden": ServoMethod(
            servo=Broyden(),
            title="Broyden on pictures",
            assumes="The pictures follow the joints nearly linearly. It predicts E instead of trying it.",
            limitations="Flat valleys and missing points. It may stop degrees away without knowing it.",
            mirror_columns=True,
            equations=_broyden_equations,
            describe_status=_describe_broyden,
        ),
        "kalman": ServoMethod(
            servo=Kalman(),
            title="Kalman filter",
            assumes="The image Jacobian changes little from step to step, and the residuals are nearly linear.",
            limitations="Far from the goal, long steps change the Jacobian more than its filter allows.",
            mirror_columns=True,
            equations=_kalman_equations,
            describe_status=_describe_recursive,
        ),
        "gauss-newton": ServoMethod(
            servo=GaussNewton(),
            title="Damped Gauss-Newton",
            assumes="The pictures were linear in the joints over the last few steps, and E has one valley.",
            limitations="An old Jacobian misleads it. Then it damps its steps until it stands still.",
            mirror_columns=True,
            equations=_gauss_newton_equations,
            describe_status=_describe_recursive,
        ),
        "likelihood": ServoMethod(
            servo=Estimator(),
            title="Likelihood of all pictures",
            assumes="Joints turn points as rigid bodies. All pictures so far are one estimation problem.",
            limitations="Bodies without rigid links: it goes to the smallest E that it has seen, and claims nothing.",
            predicts=True,
            names_points=True,
            rigid=True,
            mirror_columns=True,
            equations=estimator_equations,
            describe_status=describe_estimator,
        ),
    }
)
