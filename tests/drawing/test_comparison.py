"""All transfers are computed only while they are shown, and shown only once they are of one demonstrator."""

import re

import numpy as np
import pytest
from viewimit.app.drawing.landscapes import draw_compared, draw_together
from viewimit.app.model.computed import Comparison
from viewimit.app.model.queue import Beside, CommandQueue

from viewimit.analysis.minima import study_transfer
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings


class LaterWorker(dict):
    """Keeps each kind's newest wish until it is told to make it."""

    def ask(self, page_id, make, done, kind):
        self[kind] = make, done

    def make(self, count):
        for kind in list(self)[:count]:
            make, done = self.pop(kind)
            done(make())


@pytest.fixture
def compared():
    session, shown, worker, queue = Session(Settings.paper()), [], LaterWorker(), CommandQueue({})
    comparison = Comparison(Beside(1, worker, queue))

    def tick():
        before = comparison.html
        for command in queue.take():
            command.apply(None, 0.0)
        comparison.ask(session.world, session.snapshot)
        if comparison.html != before:
            shown.append(comparison.html)

    return session, shown, worker, comparison, tick


def test_nothing_is_computed_unless_it_is_shown_and_would_differ(compared):
    session, shown, worker, comparison, tick = compared
    tick()
    assert not worker
    comparison.toggle()
    tick()
    assert len(worker) == len(TRANSFERS) and "computing" in shown[-1]
    worker.make(4)
    tick()
    assert shown[-1].count("basin") == 4 and len(shown) == 2
    session.step()
    session.change(servo="trust-region", transfer="rank3")
    tick()
    assert not worker and len(shown) == 2  # neither posture nor method of the learner matters
    session.pose(np.radians([60.0, -60.0]))
    tick()
    assert len(worker) == 4
    comparison.toggle()
    shown.append(comparison.html)
    worker.make(4)
    tick()
    assert shown[2:] == [None] and not worker


def test_a_moving_demonstrator_is_followed_and_its_last_posture_is_what_remains(compared):
    session, shown, worker, comparison, tick = compared
    comparison.toggle()
    tick()
    worker.make(4)
    tick()
    assert len(shown) == 2
    for angle in (50.0, 60.0):
        session.pose(np.radians([angle, -60.0]))
        tick()
        worker.make(2)
        tick()
    assert len(shown) == 3  # two of either posture
    worker.make(2)
    tick()
    assert len(shown) == 4 and not worker
    drawn = [
        draw_compared(session.scene, study_transfer(session.world, session.snapshot, name), session.snapshot.theta_demo)
        for name in TRANSFERS
    ]
    assert plain(shown[-1]) == plain(draw_together(drawn)) != plain(shown[-2])


def plain(html):
    """Without the ids that differ from drawing to drawing."""
    return re.sub(r"vi-[mh][\w-]+", "", html)


def test_what_was_made_in_another_scene_is_not_shown(compared):
    session, shown, worker, comparison, tick = compared
    comparison.toggle()
    tick()
    late = [make() for make, _ in worker.values()]
    session.change(scene="panda-facing", demonstrator_deg=None)
    tick()
    count = len(shown)
    for transfer, made in zip(TRANSFERS, late):
        comparison.take(transfer, made)
    assert len(shown) == count and "computing" in shown[-1] and comparison.html == shown[-1]
    with pytest.raises(ValueError, match="nothing to compare for the rank3 transfer: no luck"):
        comparison.take("rank3", RuntimeError("no luck"))
