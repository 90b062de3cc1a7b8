"""Body points by hand on a page: what each edit does to the session, what is proposed, saved, undone and kept."""

import numpy as np
import pytest
from page_fakes import Hands, call, link, quiet_model

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene

PLACE = call("place_point", 3, (0.05, 0.08123456, 0.04))
ROW = (3, 0.05, 0.0812, 0.04)


class Worker:
    """Makes what it is asked for when told to."""

    def __init__(self):
        self.asked = []

    def ask(self, page, kind, make, take, moves=False):
        if kind == "point":
            self.asked.append((page, make, take))

    def work(self):
        for page, make, take in self.asked:
            page.put_made("point", take, make())
        self.asked = []


@pytest.fixture
def files():
    return []


@pytest.fixture
def worker():
    return Worker()


@pytest.fixture
def visit(files, worker):
    """A model in which points are being edited, and its visitor."""
    send = lambda *file: files.append(file)
    model, queue = quiet_model(Settings.paper(start_deg=(25, -45)), send=send, landscapes=worker)
    visitor = Hands(model, queue)
    visitor.act("edit points")
    return model, visitor


def rows(model):
    body = model.session.world.body
    return [(int(link), *local) for link, local in zip(body.link, body.local.tolist())]


def test_a_point_that_is_placed_is_on_both_arms_and_chosen_and_the_session_begins_anew(visit):
    model, visitor = visit
    before = rows(model)
    visitor.act("step")
    PLACE.apply(model, 0.0)
    assert rows(model) == [*before, ROW] and model.view.chosen == 10
    session = model.session
    assert session.settings.points == 11 and len(session.history) == 1 and session.cursor == 0
    views = session.snapshot.views
    assert len(views.demo) == len(views.own) == 11
    assert np.isfinite(session.snapshot.E) and model.modified and model.points.on


def test_the_chosen_point_is_removed_down_to_those_that_a_transfer_needs(visit):
    model, visitor = visit
    before = rows(model)
    visitor.set("chosen", "3")
    visitor.act("remove point")
    assert rows(model) == before[:3] + before[4:] and model.view.chosen is None
    with pytest.raises(ValueError, match="no point is chosen"):
        visitor.act("remove point")
    for _ in range(4):
        visitor.set("chosen", "0")
        visitor.act("remove point")
    visitor.set("chosen", "0")
    with pytest.raises(ValueError, match="fewer than 5 points"):
        visitor.act("remove point")
    assert rows(model) == before[-5:] and model.view.chosen == 0


def test_the_best_next_is_proposed_then_taken(visit, worker):
    model, visitor = visit
    before, was = rows(model), model.points.shown.information
    visitor.act("best next")
    assert model.points.shown.searching and rows(model) == before
    worker.work()
    visitor.arrive()
    shown = model.points.shown
    assert not shown.searching and rows(model) == before
    visitor.act("best next")
    assert rows(model)[:-1] == before and model.view.chosen == 10
    after = model.points.shown
    np.testing.assert_allclose(after.information.std_per_px, shown.proposal.after.std_per_px, rtol=1e-6)
    assert after.information.std_per_px.max() < was.std_per_px.max() and after.proposal is None


@pytest.mark.parametrize(
    "change",
    [
        lambda model, visitor: visitor.set("joint0", 20.0),
        lambda model, visitor: PLACE.apply(model, 0.0),
        lambda model, visitor: visitor.act("edit points"),
        lambda model, visitor: link("dismiss", "0").apply(model, 0.0),
    ],
    ids=["posed", "placed", "left", "let go"],
)
@pytest.mark.parametrize("late", [True, False], ids=["on its way", "there"])
def test_a_proposal_for_what_is_no_more_is_dropped(visit, worker, change, late):
    model, visitor = visit
    visitor.act("best next")
    if not late:
        worker.work()
        visitor.arrive()
        assert model.points.shown.proposal is not None
    change(model, visitor)
    worker.work()
    visitor.arrive()
    assert model.points.shown.proposal is None


def test_the_saved_scene_runs_with_those_very_points(visit, files, tmp_path, ask_json):
    model, visitor = visit
    visitor.set("chosen", "2")
    visitor.act("remove point")
    PLACE.apply(model, 0.0)
    PLACE.apply(model, 0.0)
    visitor.act("save scene")
    ((name, data),) = files
    path = tmp_path / name
    path.write_bytes(data)
    scene = load_scene(path)
    assert name == "viewimit-panda-11-points.toml" and [*scene.points["11"]] == rows(model)
    status, told = ask_json("imitate", "--scene", path, "--demonstrator", "45,-90", "--start", "25,-45")
    here = Session(Settings.paper(**{**BEST_FIELDS, "body_points": scene.points["11"]}))
    last = here.run().last
    assert status == 0 and told["settings"]["points"] == 11
    assert told["motions"] == last.motion and told["final_deg"] == pytest.approx(np.degrees(last.theta), abs=1e-6)


BEST_FIELDS = {
    **{name: getattr(Settings(), name) for name in Settings().__struct_fields__},
    "demonstrator_deg": (45, -90),
    "start_deg": (25, -45),
}
