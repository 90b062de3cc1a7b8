"""A landscape is coarse at once, then fine; one that is not wanted any more is not made finer."""

import re

import numpy as np
import pytest
from page_fakes import call, quiet_model
from viewimit.app.model.computed import OwnLandscape

from viewimit.drawing.export.panels import make_landscape
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings


class Asked:
    """A worker that does nothing by itself."""

    def __init__(self):
        self.makes = []

    def ask(self, kind, make, take):
        self.makes.append(make)


@pytest.fixture
def session():
    return Session(Settings.paper(start_deg=(25, -45)))


@pytest.fixture
def worker():
    return Asked()


@pytest.fixture
def own(worker):
    return OwnLandscape(worker.ask)


def test_it_is_coarse_first_and_as_fine_as_ever_in_the_end(own, worker, session):
    own.ask(session.world, session.snapshot)
    for expected in (1, 2, 2):
        assert len(worker.makes) == expected
        own.take(worker.makes[-1]())
    whole = make_landscape(session.world, session.snapshot)
    drawn, expected = (re.sub(r"vi-\w+-\d+", "", made.picture.html) for made in (own.made, whole))  # without their ids
    assert drawn == expected and own.made.E_true == whole.E_true
    own.ask(session.world, session.snapshot)
    assert len(worker.makes) == 2


def test_while_the_demonstrator_is_dragged_only_coarse_ones_are_made(own, worker, session):
    for angle in (50, 55, 60):
        session.pose(np.radians((angle, -90)))
        own.ask(session.world, session.snapshot)
    first, second, last = worker.makes
    own.take(first())
    own.take(second())
    assert len(worker.makes) == 3
    own.take(last())
    assert len(worker.makes) == 4
    assert own.made.E_true == pytest.approx(float(make_landscape(session.world, session.snapshot).E_true))


def test_a_comparison_that_is_hidden_and_shown_between_two_drawings_is_computed(session):
    model, _ = quiet_model(session.settings)
    for presses in (1, 2):
        for _ in range(presses):
            call("compare").apply(model, 0.0)
        model.ask_for_landscapes()
    assert model.comparison.on and "computing" in model.comparison.html
