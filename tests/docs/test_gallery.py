"""The gallery: eight runs that end as their captions say, each with its picture."""

import numpy as np
import pytest

pytest.importorskip("sphinx")
from directives import gallery  # noqa: E402


def test_the_runs_end_as_they_are_said_to():
    ends = {entry.name: entry.run().snapshot for entry in gallery.entries()}
    off = {name: np.degrees(np.abs(end.theta - end.theta_demo).max()) for name, end in ends.items()}
    arrived = {"no-bias", "toed-in", "seven-joints", "foreign-arm", "noise"}
    assert {name for name, end in ends.items() if end.status == "converged"} == arrived
    assert max(off[name] for name in arrived) < 0.5 < off["conflict"] < 3  # the transfer's own error
    assert off["as-printed"] > 5 and ends["as-printed"].status == "moving"
    assert off["cannot-tell"] > 5 and ends["cannot-tell"].status == "unobservable"
    assert {path.stem for path in (gallery.DOCS / gallery.FOLDER).glob("*.webp")} == ends.keys()
