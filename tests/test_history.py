"""A history walked back and forth, dropped from its cursor on, thinned and let go of, without a session."""

import dataclasses

import pytest

from viewimit.loop.history import EARLY, RECENT, STRIDE, History
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

BEGUN = Session(Settings.paper(transfer="linear")).snapshot


def moment(motion, **changes):
    """Without anything that follows from its fields."""
    return dataclasses.replace(BEGUN, motion=motion, **changes)


def heavy(motion):
    """With all that follows from them."""
    made = moment(motion)
    assert made.e.shape == made.recovered.shape
    return made


def written(motions, dense=None, make=moment):
    history = History([make(0)], dense=dense)
    for motion in range(1, motions + 1):
        history.append(make(motion))
    return history


def test_a_moment_is_found_by_its_motion_and_the_cursor_is_on_the_last():
    history = written(5)
    assert len(history) == 6 and history.cursor == 5 and history.present is history[-1]
    assert [one.motion for one in history] == [one.motion for one in history[:]] == list(range(6))
    assert [one.motion for one in history.recent(3)] == [3, 4, 5]
    assert history.scrub(1) and [one.motion for one in history.recent(3)] == [0, 1]


def test_undo_and_scrub_stay_within_the_history_and_drop_nothing():
    history = written(3)
    back = lambda: history.scrub(history.cursor - 1)
    assert back() and back() and back() and not back() and history.cursor == 0
    assert not history.scrub(-1) and not history.scrub(4) and history.cursor == 0
    assert history.scrub(3) and history.present.motion == 3 and len(history) == 4


@pytest.mark.parametrize("dense", [0, 8, STRIDE + 8, RECENT, 5 * STRIDE])
def test_after_the_first_motions_every_stride_th_of_old_ones_stands_for_those_after_it(dense):
    motions = EARLY + 8 * STRIDE + 5
    history = written(motions, dense, heavy)
    thinned = EARLY + (motions - dense - EARLY) // STRIDE * STRIDE
    stands = [k // STRIDE * STRIDE if EARLY <= k < thinned else k for k in range(motions + 1)]
    assert [one.motion for one in history] == stands
    assert len(set(map(id, history))) == len(set(stands))
    assert history.scrub(EARLY + STRIDE + 3) and history.cursor == EARLY + STRIDE
    assert history.scrub(history.cursor - 1) and history.cursor == EARLY
