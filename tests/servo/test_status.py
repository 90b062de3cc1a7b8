"""The status of a learner: a word to whoever reads it, with what follows from it."""

import csv
import io
import json
import pickle

import numpy as np
import pytest

from viewimit.servo import ServoStatus


def test_a_status_is_its_word_wherever_it_is_written_and_read():
    for status in ServoStatus:
        word = status.value
        assert status == word == str(status) == f"{status}" and {word: 1}[status] == 1
        assert json.dumps({"status": status}) == json.dumps({"status": word})
        assert np.array([status]).tolist() == [word]
        csv.writer(text := io.StringIO()).writerow([status])
        assert text.getvalue().strip() == word
        assert ServoStatus(word) is pickle.loads(pickle.dumps(status)) is status


def test_an_unknown_word_is_refused():
    with pytest.raises(ValueError, match="busy"):
        ServoStatus("busy")


def test_a_claim_is_at_a_minimum_at_rest_and_an_end():
    said = lambda asked: {status.value for status in ServoStatus if asked(status)}
    claims, least = said(lambda one: one.is_claim), said(lambda one: one.is_at_minimum)
    rests, ends = said(lambda one: one.is_at_rest), said(lambda one: one.has_ended)
    assert claims == {"converged"} and least == claims | {"settled", "unobservable"}
    assert rests == least | {"no-progress"} and ends == rests | {"too-few-points", "max-motions"}
