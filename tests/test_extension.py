"""A transfer, a servo and an experiment from outside: all that is said of them is in this file, a line registers each,
and page, autosave, duel, comparison, figures, benchmarks and commands have them."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from drawn import DRAWING, E_CURVE, EXPERIMENT
from quiet_page import QuietPage
from viewimit.app.panels.guide import help_html

from viewimit.estimation.equations import HOLE, Equation, number
from viewimit.estimation.transfers import TRANSFERS, TransferMethod
from viewimit.estimation.transfers.linear import AffineTransfer
from viewimit.experiments import EXPERIMENTS, Experiment
from viewimit.experiments.paper.common import Claims
from viewimit.geometry.affine import centred
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import SERVOS, Broyden, ServoMethod
from viewimit.servo.broyden import BroydenState

SHRINKAGE = 1e-6  # of the demonstrator's scatter


# A transfer: the affine map by ridge regression


@dataclass(frozen=True)
class Penalty:
    """weight: (...) px²"""

    weight: np.ndarray


@dataclass(frozen=True)
class RidgeTransfer(AffineTransfer):
    penalty: Penalty

    @property
    def condition(self):
        return np.broadcast_to(1 / SHRINKAGE**0.25, self.matrix.shape[:-2])


def fit_ridge(views):
    demo_mean, demo = centred(views.demo)
    own_mean, own = centred(views.own)
    scatter = np.swapaxes(demo, -1, -2) @ demo
    weight = SHRINKAGE * np.trace(scatter, axis1=-2, axis2=-1)
    normal = scatter + weight[..., None, None] * np.eye(4)
    matrix = np.swapaxes(np.linalg.solve(normal, np.swapaxes(demo, -1, -2) @ own), -1, -2)
    return RidgeTransfer(matrix, demo_mean, own_mean, Penalty(weight))


def ridge_equations(fitted, demo, own, name):
    weight = number(float(fitted.penalty.weight), 4)
    return (Equation("R", f"ridge of point {name}", rf"\lambda={HOLE}", (weight,), "from outside"),)


RIDGE = TransferMethod(
    title="Ridge regression",
    assumes="That a little shrinkage hurts nobody.",
    limitations="Where it does.",
    fit=fit_ridge,
    equations=ridge_equations,
    condition_name="cond ridge",
    degenerate_message="the ridge is too narrow",
)


# A servo: Broyden's motions, each made only in part


@dataclass(frozen=True)
class CautiousState:
    inner: BroydenState
    saved: float
    status: str = "moving"
    probe: bool = False


class Cautious:
    broyden, share = Broyden(), 0.9

    def start(self, seen):
        return CautiousState(self.broyden.start(seen), 0.0)

    def retarget(self, state, seen):
        return replace(state, inner=self.broyden.retarget(state.inner, seen), status="moving")

    def step(self, state, seen, residuals):
        inner, step = self.broyden.step(state.inner, seen, residuals)
        made = step if inner.probe else self.share * step
        return CautiousState(inner, state.saved + float(np.abs(step - made).sum()), inner.status, inner.probe), made


def cautious_equations(state, motion):
    if state is None:
        return (Equation("C", "no motion yet", r"𝐮=\frac{9}{10}𝐮_B"),)
    return (Equation("C", "caution", rf"\sum|𝐮_B-𝐮|={HOLE}", (number(state.saved, 6),)),)


CAUTIOUS = ServoMethod(
    servo=Cautious(),
    title="Cautious",
    assumes="That Broyden exaggerates.",
    limitations="Where haste is called for.",
    equations=cautious_equations,
    describe_status=lambda state, status: "Caution is satisfied" if status == "settled" else "",
)


# An experiment: E at the start, and after a motion of the demonstrator


@dataclass(frozen=True)
class Found:
    settings: Settings
    motion: str
    E: float

    @property
    def claims(self):
        claims = Claims(self.settings)
        claims.add("Fig. 11: E at the start", "–", f"{self.E:.3f} px²", "> 0", self.E > 0)
        return claims

    @property
    def tables(self):
        return {"E": {"E_px2": np.array([self.E])}}


def run_start(settings, tell=lambda share, partial: None, motion="sinusoid"):
    found = Found(settings, motion, Session(settings).snapshot.E)
    tell(0.5, found)
    tell(1.0, found)
    return found


def draw_start(scene, found=None):
    words = "E at the start?" if found is None else f"E {found.E:.3f} px² before the {found.motion}"
    return f'<svg class="{DRAWING} {EXPERIMENT}" viewBox="0 0 424 212"><text>{words}</text></svg>'


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    monkeypatch.setitem(TRANSFERS, "ridge", RIDGE)
    monkeypatch.setitem(SERVOS, "cautious", CAUTIOUS)
    monkeypatch.setitem(
        EXPERIMENTS, "fig11", Experiment("Fig. 11: the start", run_start, draw_start, options=("motion",))
    )


def outside(**settings):
    """Settings with the transfer and the servo from outside."""
    return Settings.paper(**{"transfer": "ridge", "servo": "cautious", "start_deg": (25, -45), **settings})


@pytest.fixture
def page():
    """At rest on the outside methods, chosen by their titles."""
    page = QuietPage(Settings.paper(start_deg=(25, -45)))
    page.tick()
    page.choose("Transfer", "Ridge regression")
    page.choose("Servo", "Cautious")
    page.tick(1.0)
    return page


def test_the_page_plays_with_them_and_shows_their_own_equations_and_words(page):
    assert "cond ridge" in page.shown and "𝐮_B" not in page.shown and "no motion yet" in page.shown
    page.click("Play")
    page.tick_until(lambda: "Caution is satisfied" in page.shown)
    page.tick(1.0)
    last = page.page.model.session.history[-1]
    assert (last.settings.transfer, last.settings.servo, last.status) == ("ridge", "cautious", "settled")
    assert np.abs(last.theta - last.theta_demo).max() < np.radians(5)
    assert "Caution is satisfied" in page.shown
    assert f">{number(float(last.transfer.penalty.weight), 4)}<" in page.shown and "from outside" in page.shown
    assert last.servo_state.saved > 0 and f">{number(last.servo_state.saved, 6)}<" in page.shown
    assert page.shown.count(E_CURVE) == 2  # the curves, and the small one beside E
    assert all(
        words in help_html("") for words in (RIDGE.assumes, RIDGE.limitations, CAUTIOUS.assumes, CAUTIOUS.limitations)
    )
