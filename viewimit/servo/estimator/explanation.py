"""What the estimator shows its users: its equations, and in words what it does."""

import numpy as np

from ...estimation.equations import HOLE, Equation, angles, number
from ...wording import plural, sentences
from ..misfit import MisfitKind
from ..servo import LastMotion
from ..status import TEST_MOVE, ServoStatus
from .state import EstimatorState, Purpose

_LIKELIHOOD = (
    r"-2\log L=\sum_{k,i}\frac{|\pi(𝐂𝐀^{-1}e^{\theta_{k1}𝐒_1}\cdots e^{\theta_{km}𝐒_m}𝐀𝐗_i)-𝐲_{ki}|^2}{\sigma^2}"
    r"+\sum_i\frac{|\pi(𝐂𝐀^{-1}𝐓e^{φ_1𝐒_1}\cdots e^{φ_m𝐒_m}𝐀𝐗_i)-𝐳_i|^2}{\sigma_D^2}"
)
_RULE = (
    r"\mathrm{loss}=\varepsilon+w\,Φ\!\left(\tfrac{\log(\varepsilon/\varepsilon_c)}{s}\right)"
    r"+a\cdot\mathrm{steps}+b\cdot\mathrm{way}"
)
DOES = {
    Purpose.PROBE: TEST_MOVE,
    Purpose.GROW: "It moves to see more, because the pictures so far are too few.",
    Purpose.NAME: "It looks at its own body again, because no naming of the demonstrator's points fits yet.",
    Purpose.LOOK: "It looks from elsewhere first, because that lowers the expected error.",
    Purpose.ARRIVE: "It goes to the likeliest pose.",
    Purpose.FOLLOW: "It follows the demonstrator, whose place it knows.",
    Purpose.NEAREST: "It goes to the smallest E, because the pictures leave a joint open.",
}
MOST_ODDS = 1_000_000  # that are told: beyond, the number says no more
HYPOTHESES = {
    MisfitKind.ANOTHER_BODY: "another body",
    MisfitKind.LINK_POINTS: "points of one link elsewhere",
    MisfitKind.POINT: "one point elsewhere",
    MisfitKind.TWO_HEADS: "another head",
    MisfitKind.MIRRORED: "a mirror image",
    MisfitKind.LENS: "a lens",
    MisfitKind.NEARLY_FLAT: "none, as the points lie too near a plane",
    MisfitKind.EPIPOLE: "none, as an epipole lies among the points",
    MisfitKind.NONE: "none of the known ones",
}


def equations(state: EstimatorState | None, motion: LastMotion) -> tuple[Equation, ...]:
    """Return likelihood and rule with the numbers of a motion, as `ServoMethod.equations`."""
    if state is None:
        return (
            Equation("", "no step yet", _LIKELIHOOD, wide=True),
            Equation("", "rule: the least expected loss", _RULE, wide=True),
        )
    n = len(state.visits)
    known = plural("{n} picture of its own body.", "{n} pictures of its own body.", n).format(n=n)
    note = sentences(known, _says(state))
    likelihood = Equation("", "all pictures, one likelihood", _LIKELIHOOD, note=note, wide=True)
    note = f"Step ({angles(motion.moved)}). {DOES[state.purpose]}" if motion.moved.any() else ""
    if state.certificate is None or not np.isfinite(error := state.certificate.std_error.max()):
        return likelihood, Equation("", "rule: the least expected loss", _RULE, note=note, wide=True)
    latex = rf"{_RULE},\quad\varepsilon={HOLE}"
    numbers = (number(float(np.degrees(error)), 2) + "°",)
    return likelihood, Equation("", "rule: the least expected loss", latex, numbers, note, wide=True)


def _says(state: EstimatorState) -> str:
    """Return which hypothesis is the likeliest."""
    if state.body is None:
        return "They do not determine a body yet."
    if state.best is None:
        return ""
    if (why := state.best.explanation) is not None:
        name, odds = HYPOTHESES[why.misfit.kind], np.exp(min(why.margin / 2, np.log(MOST_ODDS)))
        over = "over " if odds > 0.999 * MOST_ODDS else ""
        against = f", {over}{odds:,.0f} times as likely as the next one" if odds > 1 else ""
        return f"Likeliest hypothesis: {name}{against}."
    return (
        "Likeliest hypothesis: the same body, with swapped points."
        if state.exchanged
        else ("Likeliest hypothesis: the same body.")
    )


def describe_status(state: EstimatorState, status: ServoStatus) -> str:
    """Return what the servo does, or why it rests, as `ServoMethod.describe_status`."""
    if not status.is_at_rest:
        return DOES[state.purpose]
    if state.misfit is not None and not status.is_claim:
        return state.misfit.describe()
    if status == ServoStatus.CONVERGED:
        return "Noise explains all pictures, and nothing is worth another step."
    if status == ServoStatus.SETTLED and state.naming is not None and state.naming.is_ambiguous:
        return "There are two answers: other names of the points explain the pictures as well, in another pose."
    if status == ServoStatus.SETTLED:
        return "The expected error is too large for a claim, and nothing is worth another step."
    if status == ServoStatus.UNOBSERVABLE:
        return "The pictures leave a joint open."
    if state.purpose is Purpose.NAME:
        return "No naming of the demonstrator's points explains its pictures."
    if state.body is None:
        return sentences(
            "Choose another servo, such as Broyden's: no chain of rigid links explains the learner's own pictures.",
            "Perhaps one joint drags another.",
        )
    return "No hypothesis explains the pictures."
