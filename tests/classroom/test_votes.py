"""What a class has answered, counted and compared: against counts by hand."""

import random

import numpy as np
import pytest
from viewimit.app.classroom.protocol import Given
from viewimit.app.classroom.report import MIN_PERSONS, QUESTIONS, as_csv, learned
from viewimit.app.classroom.store import Row
from viewimit.app.classroom.votes import Round, Vote, results, tally

PEOPLE = [f"{k:032x}" for k in range(25)]


def voted(number, choices, step="eyes"):
    """A round in which a choice of 0 is right."""
    votes = {one: Vote(Given(choice=choice), choice == 0) for one, choice in choices.items()}
    return Round(number, "tour", step, "own", number, votes)


def test_choices_are_counted_and_moves_between_rounds():
    rng = random.Random(3)
    choices = [{one: rng.randrange(3) for one in rng.sample(PEOPLE, 20)} for _ in range(3)]
    rounds = [voted(k + 1, one) for k, one in enumerate(choices)]
    found = results(rounds[2], [*rounds, voted(9, choices[0], step="another")])
    assert found.now.counts == tuple(sum(one == k for one in choices[2].values()) for k in range(3))
    assert (found.now.total, found.first.total) == (20, 20)
    for before, moved in ((choices[1], found.moved), (choices[0], found.moved_since_first)):
        both = [(before[one] == 0, choices[2][one] == 0) for one in set(before) & set(choices[2])]
        counts = [both.count(pair) for pair in ((True, True), (False, True), (True, False), (False, False))]
        assert [moved.right, moved.gained, moved.lost, moved.wrong] == counts and sum(counts) < 20
    assert results(rounds[0], rounds).before is None and results(rounds[1], rounds).first is None


def test_what_is_neither_right_nor_wrong_has_no_moves():
    one, two = (Round(k, "tour", "servo", "own", k, {"a": Vote(Given(number=k))}) for k in (1, 2))
    found = results(two, [one, two])
    assert found.now.right is None and found.moved is None and found.now.values == ((2.0,),)


def test_values_come_sorted_so_that_their_order_tells_nobody():
    votes = {one: Vote(Given(place=(float(k % 7), 1.0))) for k, one in enumerate(PEOPLE)}
    values = tally(Round(1, "ray", "shadow", "own", 1, votes)).values
    assert list(values) == sorted(values) and len(values) == 25


@pytest.mark.parametrize("fields", [{}, {"choice": 1, "number": 1.0}, {"place": (1.0, 2.0), "values": ()}])
def test_an_answer_is_one_thing(fields):
    with pytest.raises(ValueError):
        Given(**fields)


def rows(before, after, persons=None):
    """Before and after: of each person, which of the questions were right."""
    for phase, given in (("before", before), ("after", after)):
        for person, right in enumerate(given):
            for item, one in enumerate(right):
                number = person if persons is None else persons[person]
                vote = Vote(Given(choice=0), bool(one))
                yield Row(f"{person}", number, QUESTIONS, f"item-{item}", phase, 0, vote)


def test_the_gain_is_that_of_the_shares_with_the_bootstraps_interval():
    rng = np.random.default_rng(5)
    before, after = rng.random((40, 8)) < 0.4, rng.random((40, 8)) < 0.7
    found = learned(rows(before, after))
    assert found.persons == 40 and len(found.items) == 8
    assert found.gain == pytest.approx((after.mean() - before.mean()) / (1 - before.mean()))
    assert [(one.before, one.after) for one in sorted(found.items, key=lambda one: one.item)] == [
        (int(before[:, k].sum()), int(after[:, k].sum())) for k in range(8)
    ]
    again = [rng.integers(40, size=40) for _ in range(2000)]
    gains = [(after[k].mean() - before[k].mean()) / (1 - before[k].mean()) for k in again]
    assert np.allclose([found.low, found.high], np.percentile(gains, [2.5, 97.5]), atol=0.02)


def test_nothing_is_said_of_few_or_of_who_is_not_linked():
    few = np.zeros((MIN_PERSONS - 1, 8))
    assert learned(rows(few, few + 1)).gain is None and learned(rows(few, few + 1)).items == ()
    enough = np.zeros((MIN_PERSONS, 8))
    assert learned(rows(enough, enough + 1)).gain == 1
    assert not learned(rows(enough, enough + 1, persons=[None, *range(1, MIN_PERSONS)])).enough
    assert learned(rows(enough + 1, enough)).gain is None, "all were right before"
    assert not learned(rows(enough, [])).enough


def test_the_table_of_answers_is_in_an_order_that_tells_nothing_of_time():
    made = list(rows(np.ones((3, 2)), np.zeros((3, 2)), persons=[30, 10, 20]))
    lines = as_csv(made).splitlines()
    assert lines[0] == "person,form,item,phase,answer,right,sure,seconds" and len(lines) == 13
    assert [line.split(",")[0] for line in lines[1:4]] == ["10", "20", "30"]
