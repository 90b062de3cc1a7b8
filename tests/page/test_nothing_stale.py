"""Whatever changes, a page shows what a page shows that is built and drawn from the beginning: every drawing declares
all that it depends on."""

import dataclasses

import msgspec
import pytest
from page_fakes import QuietExperiments
from quiet_client import QuietClient
from quiet_page import Gui, QuietPage
from viewimit.app.jobs.experiments import Run
from viewimit.app.model.choices import View
from viewimit.app.panels import PANELS
from viewimit.app.panels.panel import Layout

from viewimit.experiments import EXPERIMENTS
from viewimit.loop.settings import Settings

BEGUN = Settings.paper(start_deg=(25, -45))
SETTINGS = {  # each field, and another value of it, or all fields that change with it
    "scene": "panda-verged",
    "robot": {"scene": "iiwa", "robot": "panda", "demonstrator_deg": None, "start_deg": None},
    "joints": {"joints": (1, 2, 3, 4, 5, 6, 7), "demonstrator_deg": None, "start_deg": None},
    "points": 16,
    "body_points": (
        (3, 0.05, 0.08, 0.04),
        (4, 0.0, 0.05, 0.02),
        (5, 0.02, 0.06, -0.1),
        (6, 0.05, 0.0, 0.03),
        (7, 0.0, 0.03, 0.1),
        (7, 0.05, 0.0, 0.08),
    ),
    "demonstrator_deg": (60.0, -70.0),
    "start_deg": (70.0, -100.0),
    "transfer": "linear",
    "servo": "gradient",
    "noise_px": 0.5,
    "matched": {"servo": "likelihood", "matched": False},
    "missing": 0.1,
    "outliers": 0.1,
    "swapped": 0.1,
    "frames": 4,
    "gain_error": 0.1,
    "encoder_step_deg": 1.0,
    "delay": 2,
    "seed": 8,
    "undistort": (0.01, 0.0),
    "rectify": "off",
    "sensor": None,  # camera images come from a process of their own: tests/page/test_page.py
    "dynamics": None,  # an arm with mass needs PyBullet
    "max_step_deg": 3.0,
    "workspace_deg": ((10.0, 90.0), (-140.0, -20.0)),
}
VIEW = {
    "chosen": 7,
    "goal": False,
    "rays": True,
    "residuals": False,
    "gizmo": False,
    "whole_frames": True,
    "rectified": True,
    "shadows": True,
    "details": True,
    "dark": True,
    "prefers_dark": True,
    "help": True,
    "fits": 1,
    "flat": True,
    "look_only": True,
    "share": True,
    "large": "images",
    "picture": "Curves",
    "picture_as": "PNG",
    "truth": False,
    "unseen": None,  # what is not seen is not drawn: tests/page/test_unseen.py
}


def call(name, *values):
    """Does what a visitor does by this command."""
    return lambda page: page.page.queue.call(name, *values)


def run_done(page):
    """An experiment of the page is done."""
    name = page.page.model.experiments.chosen
    page.page.model.experiments.take(Run(name, "done", archive=b"zip"))


def failed(page):
    page.page.queue.call("seed", "no number")


def rest(page):
    """Until all that is due is drawn."""
    for _ in range(6):
        page.tick(3.0)


ACTIONS = {
    "play": [call("play")],
    "step": [call("step")],
    "undo": [call("step"), call("undo")],
    "scrub": [call("step"), call("step"), call("moment", 1)],
    "reset": [call("step"), call("reset")],
    "preset": [call("preset", "Seven joints")],
    "speed": [call("speed", "10 a second")],
    "rehearsal": [call("preset", "Beyond the paper"), call("rehearsal")],
    "duel": [call("duel"), call("step"), call("opponent_transfer", "Linear combination")],
    "paused duel": [call("duel"), call("step"), call("play"), call("play")],
    "still picture": [call("switch", "flat", True), call("step")],
    "preview": [call("switch", "look_only", True), call("posture", "70,-100")],
    "construction": [call("construction")],
    "compare": [call("compare")],
    "starts": [call("starts")],
    "edit points": [call("edit_points")],
    "a point less": [call("edit_points"), call("choose_point", "3"), call("remove")],
    "experiment": [call("experiment", EXPERIMENTS["fig10"].title)],
    "run": [call("run")],
    "run done": [call("run"), run_done],
    "motion": [call("motion", "circle of the hand")],
    "record": [call("record"), call("pose_joint", 0, 60.0)],
    "recorded": [call("record"), call("pose_joint", 0, 60.0), call("pose_joint", 0, 65.0), call("record")],
    "dismiss": [call("dismiss")],
    "a word": [call("show", "E")],
    "refused": [failed],
}


class AtOnce:
    """Makes what is asked of it before it returns."""

    def ask(self, page, kind, make, take, moves=False):
        try:
            made = make()
        except ValueError as error:
            made = error
        page.put_made(kind, take, made, moves=moves)


@pytest.fixture
def page():
    """At rest, all of it drawn."""
    page = QuietPage(BEGUN, landscapes=AtOnce(), experiments=QuietExperiments())
    rest(page)
    return page


def written(gui):
    """What each visible widget shows, whatever the order in which they were made."""
    told = ({k: v for k, v in vars(widget).items() if k != "callbacks"} for widget in gui.widgets)
    return sorted(repr(sorted(one.items(), key=str)) for one in told if one.get("visible", True))


def drawn_anew(page):
    """What the same model's panels write if they are built now, and every drawing is drawn."""
    client = QuietClient(1)
    client.gui = Gui()
    layout = Layout(client, page.page.queue, page.page.layout.info)
    layout.build(PANELS, page.page.model)
    for drawing in layout.drawings:
        drawing.draw(page.page.model)
    return written(client.gui)


def assert_nothing_is_stale(page):
    rest(page)
    shown, anew = written(page.gui), drawn_anew(page)
    assert [one for one in shown if one not in anew] == [one for one in anew if one not in shown] == []


def test_every_field_has_another_value_here():
    assert set(SETTINGS) == {field.name for field in msgspec.structs.fields(Settings)}
    assert set(VIEW) == {field.name for field in dataclasses.fields(View)}


@pytest.mark.parametrize("name", [name for name, value in SETTINGS.items() if value is not None])
def test_a_setting_that_changes_is_shown_everywhere(page, name):
    before, value = getattr(page.page.model.settings, name), SETTINGS[name]
    page.page.model.undoable.change(**(value if isinstance(value, dict) else {name: value}))
    assert getattr(page.page.model.settings, name) != before
    assert_nothing_is_stale(page)


@pytest.mark.parametrize("name", [name for name, value in VIEW.items() if value is not None])
def test_a_choice_of_the_view_is_shown_everywhere(page, name):
    assert getattr(page.page.model.view, name) != VIEW[name]
    page.page.model.show(**{name: VIEW[name]})
    assert_nothing_is_stale(page)


@pytest.mark.parametrize("what", ACTIONS)
def test_what_a_visitor_does_is_shown_everywhere(page, what):
    for act in ACTIONS[what]:
        act(page)
        page.tick(0.05)
    assert_nothing_is_stale(page)
