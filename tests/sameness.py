"""Equality to the last bit, and how far off a learner is."""

import dataclasses

import numpy as np


def assert_same(one, other):
    """To the last bit, whatever it is made of, and with it what a transfer measures only when asked."""
    assert type(one) is type(other)
    if isinstance(one, np.ndarray):
        assert one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    elif isinstance(one, (float, np.floating)):
        assert np.array(one).tobytes() == np.array(other).tobytes()
    elif isinstance(one, tuple):
        assert len(one) == len(other)
        for a, b in zip(one, other):
            assert_same(a, b)
    elif isinstance(one, dict):
        assert one.keys() == other.keys()
        for key in one:
            assert_same(one[key], other[key])
    elif dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            assert_same(getattr(one, field.name), getattr(other, field.name))
        if hasattr(one, "condition"):
            assert_same(one.condition, other.condition)
    else:
        assert one == other


def error_deg(moment):
    """How far the learner's worst joint is off."""
    return float(np.degrees(np.abs(moment.theta - moment.theta_demo).max()))
