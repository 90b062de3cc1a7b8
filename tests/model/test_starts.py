"""Twenty learners beside the page: asked for, followed, cancelled when what they depend on changes."""

import pytest
from drawn import START
from page_fakes import Hands, QuietExperiments, call, quiet_model
from quiet_page import QuietPage
from viewimit.app.jobs.experiments import Run

from viewimit.loop.settings import Settings


@pytest.fixture
def visit():
    """A model, its visitor, and what stands for the worker."""
    worker = QuietExperiments()
    model, queue = quiet_model(Settings.paper(start_deg=(25, -45)), basins=worker)
    return model, Hands(model, queue), worker


def toggle(model):
    call("starts").apply(model, 0.0)


def test_it_is_asked_for_with_the_settings_but_the_start_and_by_points(visit):
    model, visitor, worker = visit
    toggle(model)
    (request,) = worker.asked
    assert request.settings.start_deg is None and request.settings.sensor == "projected"
    assert request.settings.servo == model.session.settings.servo and model.basins.run.goes_on
    worker.tell(Run(request.name, "running", figure="<p>some</p>"))
    visitor.arrive()
    assert model.basins.run.figure == "<p>some</p>"


CHANGES = {
    "demonstrator": lambda visitor: visitor.set("joint0", 60),
    "transfer": lambda visitor: visitor.set("transfer", "Projective combination"),
    "servo": lambda visitor: visitor.set("servo", "Gradient (paper)"),
    "noise": lambda visitor: visitor.set("noise_px", 1),
    "preset": lambda visitor: visitor.set("preset", "Five points"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_it_is_cancelled_when_what_it_depends_on_changes_and_what_comes_late_is_not_shown(visit, change):
    model, visitor, worker = visit
    toggle(model)
    late = Run(worker.asked[0].name, "running", figure="late")
    CHANGES[change](visitor)
    model.ask_for_landscapes()
    assert worker.cancelled == 1 and model.basins.run is None
    worker.tell(late)
    visitor.arrive()
    assert model.basins.run is None
    toggle(model)
    worker.tell(late)
    visitor.arrive()
    assert model.basins.run.figure == ""


def test_the_page_shows_where_they_end():
    page = QuietPage(Settings.paper(start_deg=(25, -45)))
    page.click("Try 20 starts")
    page.tick_until(lambda: "learners have come to rest" in page.shown or "to have converged" in page.shown, 60)
    page.tick_until(lambda: "to have converged" in page.shown, 60)
    assert page.shown.count(START) == 20 + 3  # and those of the sentence
    page.tick_until(lambda: any(widget.label == "Hide the starts" for widget in page.gui.widgets), 60)
    page.click("Hide the starts")
    page.tick(1.0)
    assert START not in page.shown
