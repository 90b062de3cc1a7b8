"""What a browser may send, carried out or refused; nothing is lost by a refusal."""

import numpy as np
import pytest
from page_fakes import Hands, QuietExperiments, call, link, quiet_model
from quiet_page import QuietPage
from viewimit.app.commands import COMMANDS
from viewimit.app.jobs.experiments import Run
from viewimit.app.model.choices import AS_STARTED, OF_ARMS, OF_IMAGES, PRESETS, joint_choices, presets_from
from viewimit.app.model.keeping import tab_link
from viewimit.app.model.queue import NOT_TAKEN, PENDING_LIMIT, Command, CommandQueue, add_command

from viewimit.experiments import EXPERIMENTS
from viewimit.loop.settings import Settings

AMOUNTS = {amount.name: amount for amount in (*OF_IMAGES, *OF_ARMS)}


@pytest.fixture
def page():
    """A model and a visitor of it: session, player, model, visitor."""
    model, _ = quiet_model(Settings.paper(seed=99))
    model.session.begin(Settings.paper(start_deg=(25, -25)))
    return model.session, model.player, model, Hands(model)


HOSTILE = [np.nan, np.inf, "1e9x", None, [1, 2], {"a": 1}, "<script>"]
REFUSED = [
    *((name, v) for name in ("joint0", *AMOUNTS, "joints", "seed", "history", "chosen") for v in HOSTILE),
    ("joint0", 1e9), ("joint1", 1.0), ("noise_px", -1), ("missing", 101), ("outliers", -1), ("frames", 0),
    ("frames", 51), ("gain_error", 51), ("encoder_step_deg", 6), ("joints", "all eight"), ("seed", -3),
    ("points", "7 points"), ("camera", "rendered"), ("camera", 1), ("chosen", 10), ("chosen", -1),
    ("transfer", "best"), ("servo", ["broyden"]), ("speed", "warp"), ("preset", "none such"),
    *((name, v) for name in ("experiment", "motion", "moment") for v in HOSTILE), ("experiment", "fig7"),
    ("motion", "sinusoid "), ("motion", "recorded"), ("moment", -1), ("moment", 6), ("moment", 1e300),
    ("motion file", b"[]"), ("motion file", b"\x00" * 1000), ("motion file", b" " * (3 << 20)),
    ("opponent's transfer", "best"), ("opponent's servo", 3),
]  # fmt: skip


def test_values_that_cannot_be_are_refused_and_change_nothing(page):
    session, _, model, visitor = page
    before, view = session.snapshot, model.view
    for name, value in REFUSED:
        with pytest.raises(ValueError):
            visitor.set(name, value)
            pytest.fail(f"{name}: {value!r}")
        assert session.snapshot is before and model.view == view, (name, value)
    assert (model.experiments.chosen, model.motions.name, model.motions.recorded) == ("fig7", "sinusoid", None)


def test_what_the_command_line_asked_for_is_a_preset_of_its_own(page):
    session, _, _, visitor = page
    visitor.set("preset", PRESETS[1].name)
    visitor.set("preset", AS_STARTED)
    assert session.settings.seed == 99
    assert list(presets_from(PRESETS[2].settings)) == [PRESETS[2].name, *(p.name for p in PRESETS if p != PRESETS[2])]


@pytest.mark.parametrize("scene, layout", [("panda", 16), ("iiwa", 10)])
def test_joints_are_freed_with_a_layout_for_them_and_held_again(page, scene, layout):
    session, _, model, visitor = page
    session.begin(Settings.paper(scene=scene, start_deg=(25, -25), points=10))
    two, seven = joint_choices(session.settings)
    visitor.set("joint0", 60.0)
    before = session.settings
    visitor.set("joints", seven)
    rest = np.array(session.scene.posture_deg)
    assert (
        model.generation == 1
        and session.scene.moving_joints == (1, 2, 3, 4, 5, 6, 7)
        and session.settings.points == layout
    )
    held = [k for k in range(7) if k not in (1, 3)]
    for angles, theirs in ((session.settings.demonstrator_deg, (60, -90)), (session.settings.start_deg, (25, -25))):
        assert (angles[1], angles[3]) == pytest.approx(theirs) and np.array(angles)[held] == pytest.approx(rest[held])
    visitor.set("joint6", 10.0)
    snapshot = session.snapshot
    visitor.set("joints", seven)  # as it is already
    assert session.snapshot is snapshot
    visitor.set("joints", two)
    assert session.settings == before


def test_a_resting_loop_wakes_when_the_demonstrator_moves(page):
    session, player, _, visitor = page
    player.toggle()
    player.speed = 0
    for now in range(200):
        player.advance(float(now))
    rested = session.snapshot
    player.advance(300.0)
    assert session.snapshot is rested and rested.status.is_at_rest
    visitor.set("joint0", 70)
    for now in range(400, 600):
        player.advance(float(now))
    assert session.snapshot.motion > rested.motion
    assert np.abs(np.degrees(session.snapshot.theta - session.snapshot.theta_demo)).max() < 5


def test_the_queue_keeps_the_newest_value_and_every_action_up_to_a_limit():
    done = []
    pose = Command("pose", lambda model, k, value: done.append((k, value)), (int, int), latest=True)
    queue = CommandQueue({"pose": pose, "step": Command("step", lambda model: done.append("step"))})
    for value in range(1000):
        queue.call("pose", 0, value)
        queue.call("step")
    queue.call("pose", 1, -3)
    told = []
    for entry in queue.take():
        try:
            entry.apply(None, 0.0)
        except ValueError as why:
            told.append(str(why))
    values = dict(one for one in done if one != "step")
    assert values == {0: 999, 1: -3} and done[0] == (0, 0) and len(done) <= PENDING_LIMIT + 1
    assert 1 <= done.count("step") <= PENDING_LIMIT and told == [NOT_TAKEN] and queue.take() == []


@pytest.mark.parametrize("parsers, options", [((), {}), ((int, int), {}), ((int,), {"order_indepedent": True})])
def test_a_command_with_other_parsers_than_parameters_or_a_misspelt_option_is_none(parsers, options):
    with pytest.raises((TypeError, ValueError)):
        add_command("unheard of", lambda model, value, *, now: None, *parsers, **options)
    assert "unheard of" not in COMMANDS


def test_what_a_person_did_is_done_in_that_order(page):
    """A step that a slider or a reset precedes is another than one that they follow."""
    session, _, model, visitor = page
    queue = CommandQueue(COMMANDS)

    def posture_after(*commands):
        visitor.set("joint0", 45.0)
        visitor.act("reset")
        for command in commands:
            queue.put(command)
        for command in queue.take():
            command.apply(model, 0.0)
        return session.snapshot.theta_demo[0], session.snapshot.motion, len(session.history)

    moved, preset = call("pose_joint", 0, 70.0), call("preset", PRESETS[1].name)
    assert posture_after(moved, call("step"), call("reset"))[1:] == (0, 1)
    assert posture_after(call("reset"), moved, call("step"))[1] == 1
    assert np.degrees(posture_after(moved, preset)[0]) == pytest.approx(45)
    assert np.degrees(posture_after(preset, moved)[0]) == pytest.approx(70)


@pytest.fixture
def experimenting():
    """A visitor with experiments and motions: session, worker, experiments, motions, visitor, what was sent."""
    worker, sent = QuietExperiments(), []
    model, queue = quiet_model(Settings.paper(), worker, lambda *file: sent.append(file))
    return model.session, worker, model.experiments, model.motions, Hands(model, queue), sent


@pytest.mark.parametrize("title, name", [(one.title, name) for name, one in EXPERIMENTS.items()])
def test_an_experiment_is_asked_for_with_what_the_session_has_now(experimenting, title, name):
    session, worker, _, _, visitor, _ = experimenting
    session.change(transfer="linear", noise_px=0.5, seed=3)
    session.pose(np.radians([60.0, -60.0]))
    visitor.set("experiment", title)
    visitor.set("motion", "circle of the hand")
    visitor.act("run", 0.0)
    (request,) = worker.asked
    assert (request.name, request.settings) == (name, session.settings)
    assert request.settings.demonstrator_deg == (60, -60)
    assert request.options == ({"motion": "circle"} if name == "fig10" else {})


def test_run_becomes_cancel_while_an_experiment_goes_on(experimenting):
    _, worker, experiments, _, visitor, sent = experimenting
    visitor.act("run", 0.0)
    for state in ("waiting", "running", "writing"):
        worker.tell(Run("fig7", state))
        visitor.arrive()
        assert experiments.going_on
        visitor.act("run", 0.0)
    assert len(worker.asked) == 1 and worker.cancelled == 3
    with pytest.raises(ValueError, match="nothing to download"):
        visitor.act("download", 0.0)
    worker.tell(Run("fig7", "done", archive=b"zip"))
    visitor.arrive()
    visitor.act("download", 0.0)
    assert sent == [("viewimit-fig7.zip", b"zip")] and not experiments.going_on
    visitor.act("run", 0.0)
    assert len(worker.asked) == 2


def test_what_the_browser_prefers_holds_until_the_visitor_chooses():
    model, _ = quiet_model(Settings.paper())
    for dark in ("1", "0", "1"):
        link("dark", dark).apply(model, 0.0)
        assert model.view.on("dark") == (dark == "1")
    Hands(model).set("dark", False)
    link("dark", "1").apply(model, 0.0)
    assert not model.view.on("dark") and ("dark=0" in tab_link(model)[0])


def test_why_something_could_not_be_is_said_until_something_can_be_that_is_no_view():
    page = QuietPage(Settings.paper())
    page.page.queue.call("load_motion", b"{}")
    for command, stays in ((call("fit_view"), True), (call("step"), False)):
        page.tick(0.5)
        assert "not a recorded motion" in page.page.model.message.text
        page.page.queue.put(command)
        page.tick(0.5)
        assert (page.page.model.message is not None) == stays
