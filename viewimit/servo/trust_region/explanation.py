"""What the trust region does, in a law and in words, for people."""

import numpy as np

from ...estimation.equations import Equation, angles, short
from ..servo import LastMotion
from ..status import ServoStatus
from .state import CERTAIN, PHASES, TrustState

_LAW = (
    r"\hat{𝐲}(𝛉)=𝐲_c+\sum_{k}𝛂_k\,\kappa(𝛉-𝐜,\,𝛉_k-𝐜),\quad "
    r"𝛉^{*}=\underset{|𝛉-𝐜|_{\infty}\le D}{\mathrm{arg\,min}}\;E(\hat{𝐲}(𝛉))"
)
_BY_KINEMATICS = (
    r"\hat{𝐲}_i(𝛉)=\pi\left(𝐂\,e^{\theta_1𝐆_1}\cdots e^{\theta_m𝐆_m}\,𝐗_i\right),\quad "
    r"𝛉^{*}=\underset{𝛉}{\mathrm{arg\,min}}\;E(\hat{𝐲}(𝛉))"
)
SENT_TO_LIMIT = "a joint was sent to its limit: if the arm moves less than it is told, begin nearer"


def equations(state: TrustState | None, moment: LastMotion) -> tuple[Equation, ...]:
    """As `Servo.equations`."""
    if state is None:
        return (Equation("", "no motion yet", _LAW, wide=True),)
    several = "s" if len(state.visits) > 1 else ""
    known = f"The images are predicted from {len(state.visits)} posture{several} visited"
    if state.kinematics is None:
        law, known = _LAW, f"{known}; D = {np.degrees(state.radius):.3g}°"
    else:
        law, known = _BY_KINEMATICS, f"{known}, which tell how each joint turns the points"
    note = f"{known}. {_outcome(state, moment)}"
    return (Equation("", "servo: the images are predicted, E is asked", law, note=note, wide=True),)


def says(state: TrustState, status: ServoStatus) -> str:
    """As `Servo.says`."""
    if status == ServoStatus.CONVERGED and state.strayed is not None:
        return "E rises every way, and its motions lead no nearer"
    if status == ServoStatus.CONVERGED:
        return f"E leaves no room for {np.degrees(CERTAIN):.1g}° and rises every way"
    if status == ServoStatus.SETTLED:
        return "no evidence yet that E rises every way"
    if status == ServoStatus.UNOBSERVABLE:
        return "E does not rise every way"
    if status == ServoStatus.NO_PROGRESS:
        found = f"nothing lower in {state.restarts} searches elsewhere" if state.restarts else "nothing lower nearby"
        return f"{found}; {SENT_TO_LIMIT}" if state.limited else found
    if state.ending:
        return "back to the best posture"
    if state.needed:
        return f"looks where more than {state.needed - 1} points are seen, as these do not tell every joint"
    if state.restarts:
        return f"looking for something lower, as noise explains less: search {state.restarts}"
    if state.probe:
        return "a probe, to learn how the images move"
    if state.strayed is not None:
        return "its arm does not stand where it was sent, so it goes by its images"
    if state.lines:
        return "asks points that one camera alone sees, too, as the others do not tell every joint"
    if state.kinematics is not None:
        return "knows how its joints turn its points, and goes where E should be least"
    other = PHASES[state.phase][0]
    return f"asks the {other} transfer for a way on" if other else ""


def _outcome(state: TrustState, moment: LastMotion) -> str:
    """What the last motion was for, or why there is none."""
    made = f"This motion, ({angles(moment.moved)}), "
    if state.probe:
        return f"{made}is a probe: it teaches what the predictions know least."
    if moment.status == ServoStatus.CONVERGED:
        return "What is left of E leaves no room for a displacement worth a motion: the servo rests."
    if moment.status == ServoStatus.NO_PROGRESS:
        return "Neither transfer nor restart led further: the servo rests."
    if state.promised is not None:
        return f"{made}was to lower E by <b>{short(state.promised * state.unit_px**2)}</b> px²."
    return ""
