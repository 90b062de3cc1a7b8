"""A transfer, a servo and an experiment from outside: all that is said of them is in this file, a line registers each,
and page, autosave, duel, comparison, figures, benchmarks and commands have them."""

import io
import json
import os
import re
import threading
import zipfile
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import Pipe

import numpy as np
import pytest
from drawn import ALL_TRANSFERS, DRAWING, E_CURVE, EQUATION, EXPERIMENT, OPPONENTS_PATH, TITLE, used
from quiet_page import QuietPage
from sameness import assert_same
from viewimit.app.jobs import experiment_child
from viewimit.app.page.page import KEPT_EVERY
from viewimit.app.panels.help import help_html
from viewimit.app.sessions.autosave import Autosave
from viewimit.app.sessions.codec import decode, encode
from viewimit.app.sessions.sqlite_store import SqliteStore

from viewimit.analysis import landscape
from viewimit.drawing import equations as drawing
from viewimit.drawing import status
from viewimit.estimation.equations import HOLE, Equation, number
from viewimit.estimation.transfers import TRANSFERS, TransferMethod
from viewimit.estimation.transfers.linear import AffineTransfer
from viewimit.experiments import EXPERIMENTS, Experiment
from viewimit.experiments.bench import speed
from viewimit.experiments.paper import fig7, fig9
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
    stored=(RidgeTransfer, Penalty),
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
    stored=(CautiousState, *SERVOS["broyden"].stored),
    equations=cautious_equations,
    describe_status=lambda state, status: "caution is satisfied" if status == "settled" else "",
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
    page.tick_until(lambda: "caution is satisfied" in page.shown)
    page.tick(1.0)
    last = page.page.memory().history[-1]
    assert (last.settings.transfer, last.settings.servo, last.status) == ("ridge", "cautious", "settled")
    assert np.abs(last.theta - last.theta_demo).max() < np.radians(5)
    assert "caution is satisfied" in page.shown
    assert f">{number(float(last.transfer.penalty.weight), 4)}<" in page.shown and "from outside" in page.shown
    assert last.servo_state.saved > 0 and f">{number(last.servo_state.saved, 6)}<" in page.shown
    assert page.shown.count(E_CURVE) == 1  # the curves
    assert all(
        words in help_html("") for words in (RIDGE.assumes, RIDGE.limitations, CAUTIOUS.assumes, CAUTIOUS.limitations)
    )


def test_too_large_a_condition_is_said_in_the_transfers_words(monkeypatch):
    now = stepped(1).snapshot
    ill = replace(TRANSFERS["linear"](now.views), sigma=np.array([300.0, 2, 1]))
    monkeypatch.setitem(TRANSFERS, now.settings.transfer, replace(TRANSFERS[now.settings.transfer], fit=lambda _: ill))
    assert status.describe(replace(now)).doubt == "cond ridge 300, far too high: the ridge is too narrow."


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


def test_what_is_kept_goes_on_as_if_nothing_had_been(tmp_path):
    settings = outside(noise_px=0.2, missing=0.02)
    autosave = Autosave(SqliteStore(tmp_path))
    autosave.claim("key", settings)
    page = QuietPage(settings, lambda memory: autosave.keep("key", memory))
    for _ in range(8):
        page.choose("Motion", "Step")
    page.tick(KEPT_EVERY)
    autosave.flush("key")
    assert autosave.problem("key") is None
    autosave.stop()
    other = Autosave(SqliteStore(tmp_path))
    memory = other.claim("key", settings)
    other.stop()
    again = QuietPage(settings, resumed=memory)
    for each in (page, again):
        for _ in range(4):
            each.choose("Motion", "Step")
    kept, resumed = page.page.memory().history, again.page.memory().history
    assert len(kept) > 8 and isinstance(resumed[3].servo_state, CautiousState) and resumed[3] is not kept[3]
    assert_same(kept, resumed)


def test_the_transfer_frozen_at_convergence_is_kept():
    history = stepped(40).history
    back = decode(encode(history))
    assert isinstance(back[-1].converged_transfer.penalty, Penalty)
    assert_same(tuple(back), tuple(history))


@pytest.mark.parametrize("methods, name, without", [(TRANSFERS, "ridge", Penalty), (SERVOS, "cautious", BroydenState)])
def test_what_is_not_said_to_be_stored_is_not(monkeypatch, methods, name, without):
    history, method = stepped(3).history, methods[name]
    stored = tuple(kind for kind in method.stored if kind is not without)
    monkeypatch.setitem(methods, name, replace(method, stored=stored))
    monkeypatch.setitem(SERVOS, "broyden", replace(SERVOS["broyden"], stored=()))
    with pytest.raises(TypeError, match=f"cannot keep a {without.__name__}"):
        encode([replace(moment, converged_transfer=fit_ridge(moment.views)) for moment in history])


def test_two_stored_classes_of_one_name_are_refused(monkeypatch):
    monkeypatch.setitem(TRANSFERS, "ridge", replace(RIDGE, stored=(*RIDGE.stored, type("Visit", (), {}))))
    with pytest.raises(TypeError, match="two classes named Visit"):
        encode(stepped(1).history)


def test_imitate_and_landscape_take_them(ask_json, ask):
    chosen = "--transfer", "ridge", "--start", "25,-45"
    status, told = ask_json("imitate", *chosen, "--servo", "cautious", "--frames", "1")
    session = stepped(40)
    assert status == 1 and told["status"] == "settled" and told["E"] == pytest.approx(session.snapshot.E, rel=1e-6)
    status, told = ask_json("landscape", "--transfer", "ridge", "--step-deg", "10")
    assert status == 0 and told["transfer"] == "ridge"
    epipolar = ask_json("landscape", "--transfer", "epipolar", "--step-deg", "10")[1]
    assert told["E_at_demonstrator"] != epipolar["E_at_demonstrator"]
    assert "ridge" in ask("imitate", "--help")[1] and "cautious" in ask("imitate", "--help")[1]


def test_bench_times_them_and_counts_their_arrivals(ask, monkeypatch):
    for name, value in {"LOOP_SHARE": 50, "ROUNDS": 1, "SLOW_ROUNDS": 1, "MOTIONS": 5, "SINGLE_CALLS": 5}.items():
        monkeypatch.setattr(speed, name, value)
    for module in (speed, landscape):
        monkeypatch.setattr(module, "grid_axes", partial(landscape.grid_axes, step_deg=10.0))
    status, out, _ = ask("bench", "speed")
    assert status == 0 and "ridge" in out and "cautious" in out
    monkeypatch.setattr(os, "cpu_count", lambda: 1)  # in this process: another would not know what is registered here
    status, out, _ = ask("bench", "success", "--runs", 2, "--max-motions", 40, "--transfer", "ridge")
    assert status == 0 and all(re.search(rf"ridge +{servo}", out) for servo in SERVOS)


@pytest.mark.parametrize("name", ["fig7", "fig9", "fig11"])
def test_reproduce_runs_and_draws_them(ask_json, tmp_path, monkeypatch, name):
    quick = {
        "fig7": partial(fig7.run, step_deg=15.0, study=(1, 1)),
        "fig9": partial(fig9.run, starts=(0, 0), max_motions=12),
    }
    if name in quick:
        monkeypatch.setitem(EXPERIMENTS, name, replace(EXPERIMENTS[name], run=quick[name]))
    asked = "--transfer", "ridge", "--servo", "cautious", "--motion", "circle", "--out", tmp_path
    status, told = ask_json("reproduce", name, *asked)
    files = told["figures"][name]["files"]
    assert status == bool(told["missed"]) and str(tmp_path / f"{name}.json") in files
    table = {"fig7": "ridge", "fig9": "cautious", "fig11": "E_px2"}[name]
    assert any(table in path.read_text() for path in tmp_path.glob("*.csv"))


def test_figures_give_them_styles_of_their_own():
    found = fig7.run(outside(), step_deg=15.0, study=(1, 1))
    html = EXPERIMENTS["fig7"].figure(found)
    samples = re.findall(r'<g transform="translate\([\d.]+ 207\)"><path class="([^"]+)"', html)
    assert len(samples) == len(set(samples)) == len(TRANSFERS) and ">ridge</text>" in html
    assert ">Cautious</text>" in EXPERIMENTS["fig9"].figure(fig9.run(outside(), starts=(0, 0), max_motions=5))


def test_the_page_offers_the_experiment_and_its_option(page):
    assert not page.widget("Trajectory").visible
    page.choose("Experiment", "Fig. 11: the start")
    page.tick(1.0)
    assert "E at the start?" in page.shown and page.widget("Trajectory").visible


def test_its_own_process_runs_draws_and_packs_the_experiment(tmp_path, monkeypatch):
    """In this process: a spawned one would not know what was registered here."""
    monkeypatch.setattr(experiment_child, "stand_back", lambda niceness: None)
    ours, theirs = Pipe()
    ours.send(("fig11", outside(), {"motion": "circle"}))
    child = threading.Thread(target=experiment_child.work, args=(theirs, str(tmp_path)))
    child.start()
    news = {}
    while "files" not in news and "failed" not in news:
        kind, *content = ours.recv()
        news[kind] = content
    child.join()
    E = Session(outside()).snapshot.E
    assert news["found"][0] == draw_start(None, Found(outside(), "circle", E)) == news["figure"][0]
    (claim,) = news["found"][1]
    assert claim.here == f"{E:.3f} px²"
    with zipfile.ZipFile(io.BytesIO(news["files"][0])) as archive:
        assert json.loads(archive.read("fig11.json"))["settings"]["transfer"] == "ridge"


def test_equations_of_outside_are_drawn_beside_the_papers():
    html = drawing.draw_equations(stepped(2).snapshot)
    heads = re.findall(rf'<div class="{EQUATION}"><b>([^<]*)</b>', html)
    assert heads == ["(1)", "R", "(6)", "C"]
