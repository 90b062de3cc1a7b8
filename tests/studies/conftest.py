"""The comparison of all laws, whose names are forgotten after each test."""

import importlib
import sys

import pytest

from viewimit import Settings
from viewimit.experiments.bench import GROUPS
from viewimit.servo import SERVOS


@pytest.fixture
def compared():
    """Its cases."""
    known = {id(one): dict(one) for one in (SERVOS, GROUPS)}
    importlib.import_module("compare")
    yield GROUPS["compare"].cases
    del sys.modules["compare"]
    for one in (SERVOS, GROUPS):
        for name in set(one) - set(known[id(one)]):
            del one[name]


@pytest.fixture
def exact():
    """Settings of the comparison."""
    return Settings.paper(transfer="projective")
