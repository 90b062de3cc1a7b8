"""What the trust region shows its users: its equations, and in words what it does."""

import numpy as np

from ...estimation.equations import Equation, angles, short
from ...wording import plural, sentences
from ..servo import LastMotion
from ..status import TEST_MOVE, ServoStatus
from .options import DEFAULTS, TrustRegionOptions
from .state import Phase, TrustRegionState

_LAW = (
    r"\hat{𝐲}(𝛉)=𝐲_c+\sum_{k}𝛂_k\,\kappa(𝛉-𝐜,\,𝛉_k-𝐜),\quad "
    r"𝛉^{*}=\underset{|𝛉-𝐜|_{\infty}\le D}{\mathrm{arg\,min}}\;E(\hat{𝐲}(𝛉))"
)
_BY_KINEMATICS = (
    r"\hat{𝐲}_i(𝛉)=\pi\left(𝐂\,e^{\theta_1𝐆_1}\cdots e^{\theta_m𝐆_m}\,𝐗_i\right),\quad "
    r"𝛉^{*}=\underset{𝛉}{\mathrm{arg\,min}}\;E(\hat{𝐲}(𝛉))"
)
AT_JOINT_LIMIT = "A joint was sent to its limit. If the arm moves less than commanded, begin nearer."


def equations(state: TrustRegionState | None, motion: LastMotion) -> tuple[Equation, ...]:
    """Return the law with the numbers of a motion, as `ServoMethod.equations`."""
    if state is None:
        return (Equation("", "no step yet", _LAW, wide=True),)
    n = len(state.visits)
    if state.kinematics is None:
        law, radius = _LAW, f"{np.degrees(state.region.radius):.3g}°"
        known = plural(
            "The images are predicted from {n} posture visited; D = {radius}.",
            "The images are predicted from {n} postures visited; D = {radius}.",
            n,
        ).format(n=n, radius=radius)
    else:
        law = _BY_KINEMATICS
        known = plural(
            "The images are predicted from {n} posture visited, which shows how each joint turns the points.",
            "The images are predicted from {n} postures visited, which show how each joint turns the points.",
            n,
        ).format(n=n)
    note = sentences(known, _outcome(state, motion))
    return (Equation("", "servo: the images are predicted, and E is minimised", law, note=note, wide=True),)


def describe_status(state: TrustRegionState, status: ServoStatus, options: TrustRegionOptions = DEFAULTS) -> str:
    """Return what the servo does, or why it rests, as `ServoMethod.describe_status`."""
    search, naming = state.search, state.naming
    if state.explanation is not None and status.is_at_rest:
        return state.explanation.misfit.describe()
    if state.refusal is not None and status.is_at_rest:
        return state.refusal.describe()
    if status == ServoStatus.NO_PROGRESS and state.phase is Phase.MATCH:
        found = "No naming of the demonstrator's points explains its images."
        if state.naming_grid <= options.naming_postures:
            return found
        tried = f"{options.naming_postures:,} random poses were tried, of {state.naming_grid:.3g} on the grid"
        return f"{found} {tried}: try fewer moving joints."
    if status == ServoStatus.SETTLED and naming is not None and naming.is_ambiguous:
        return "There are two answers: other names of the points explain the images as well, in another pose."
    if status == ServoStatus.CONVERGED and state.mismatch is not None:
        return "E rises in every direction, and no step leads nearer."
    if status == ServoStatus.CONVERGED:
        error = f"{np.degrees(options.xtol_converged):.1g}°"
        return f"An error of {error} would show, as E rises in every direction."
    if status == ServoStatus.SETTLED:
        return "There is no evidence yet that E rises in every direction."
    if status == ServoStatus.UNOBSERVABLE:
        return "E does not rise in every direction."
    if status == ServoStatus.NO_PROGRESS:
        n = search.n_restarts
        elsewhere = plural("No lower E in {n} search elsewhere.", "No lower E in {n} searches elsewhere.", n)
        found = elsewhere.format(n=n) if n else "No lower E nearby."
        return sentences(found, AT_JOINT_LIMIT if state.destination.at_joint_limit else "")
    if state.destination.status is not None:
        return "It goes back to the best pose."
    if search.min_points:
        text = "It looks for poses that show {n} points or more, because these leave a joint undetermined."
        return text.format(n=search.min_points)
    if search.n_restarts:
        text = "It searches for a smaller E elsewhere (search {n}), because noise does not explain this one."
        return text.format(n=search.n_restarts)
    if state.phase is Phase.MATCH:
        return "It learns more of its images, because no naming of the demonstrator's points explains them yet."
    if state.probe:
        return TEST_MOVE
    if state.mismatch is not None:
        return "The arm is not where it was sent, so its images determine its pose."
    if search.partial_points:
        return "It also uses points that only one camera sees, because the others leave a joint undetermined."
    if state.kinematics is not None:
        return "It knows how its joints turn its points, and goes to the smallest predicted E."
    transfer = options.ladder[search.rung][0]
    return f"It tries the {transfer} transfer." if transfer else ""


def _outcome(state: TrustRegionState, motion: LastMotion) -> str:
    """Return what the last motion was for, or why there is none."""
    if motion.status == ServoStatus.CONVERGED:
        return "A displacement worth a step would show in E: the servo rests."
    if motion.status == ServoStatus.NO_PROGRESS:
        return "Neither another transfer nor a restart led further: the servo rests."
    reduction = state.region.predicted_reduction
    if state.phase is Phase.PROBE:
        text = "This step, ({step}), is a test move: it shows how the joint moves the images."
    elif state.phase is Phase.MATCH:
        text = "This step, ({step}), helps to predict images: the demonstrator's points could not be named yet."
    elif state.phase is Phase.VERIFY:
        text = "This step, ({step}), is a check: it tests whether E rises where no visit shows that."
    elif reduction is not None:
        text = "This step, ({step}), was to lower E by <b>{reduction}</b> px²."
    else:
        return ""
    lower = "" if reduction is None else short(reduction * state.unit_px**2)
    return text.format(step=angles(motion.moved), reduction=lower)
