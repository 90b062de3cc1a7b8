"""A transfer, a servo and an experiment from outside: all that is said of them is in this file, a line registers each,
and page, autosave, duel, comparison, figures, benchmarks and commands have them."""

import re
from dataclasses import dataclass, replace

import numpy as np
import pytest
from drawn import ALL_TRANSFERS, DRAWING, E_CURVE, EXPERIMENT, OPPONENTS_PATH, TITLE, used
from quiet_page import QuietPage
from sameness import assert_same
from viewimit.app.panels.guide import help_html

from viewimit.drawing import status
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


def stepped(count):
    session = Session(outside())
    for _ in range(count):
        session.step()
    return session


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


def test_too_large_a_condition_is_said_in_the_transfers_words(monkeypatch):
    now = stepped(1).snapshot
    ill = replace(TRANSFERS["linear"](now.views), sigma=np.array([300.0, 2, 1]))
    monkeypatch.setitem(TRANSFERS, now.settings.transfer, replace(TRANSFERS[now.settings.transfer], fit=lambda _: ill))
    assert status.describe(replace(now)).doubt == "cond ridge is 300, far too high. The ridge is too narrow."


def test_a_duel_takes_them_as_opponent(page):
    page.choose("Transfer", "Linear combination")
    page.choose("Opponent's transfer", "Ridge regression")
    page.choose("Opponent's servo", "Cautious")
    page.click("Begin duel")
    page.tick_until(lambda: OPPONENTS_PATH in used(page.shown))
    assert "Opponent: Ridge regression" in page.shown and ">Cautious</text>" in page.shown


def test_all_transfers_are_compared_in_as_many_rows_as_needed(page):
    page.click("Compare all transfers")
    page.tick_until(lambda: "· basin" in page.shown)
    (compared,) = (widget.content for widget in page.gui.widgets if ALL_TRANSFERS in getattr(widget, "content", ""))
    for method in TRANSFERS.values():
        assert f">{method.title}</text>" in compared
    height = float(re.search(r'viewBox="0 0 \d+ (\d+)"', compared)[1])
    places = re.findall(rf'<g transform="translate\((\d+) (\d+)\)"><text class="{TITLE}"', compared)
    assert len(places) == len(set(places)) == len(TRANSFERS) and 2 < height / 131 <= 3
    assert all(float(top) < height for _, top in places)


def test_what_is_kept_goes_on_as_if_nothing_had_been():
    settings = outside(noise_px=0.2, missing=0.02, seed=1)
    page, again = QuietPage(settings), QuietPage(settings)
    page.restore()
    for _ in range(8):
        page.choose("Motion", "Step")
    again.restore(page.kept)
    for each in (page, again):
        for _ in range(4):
            each.choose("Motion", "Step")
    kept, restored = (tuple(each.page.model.session.history) for each in (page, again))
    assert len(kept) > 8 and isinstance(restored[3].servo_state, CautiousState) and restored[3] is not kept[3]
    assert_same(kept, restored)
