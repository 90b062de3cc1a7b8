"""The gallery's table: eight runs that end as their captions say, and what is written of one."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def gallery():
    spec = importlib.util.spec_from_file_location("gallery", DOCS / "gallery.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_runs_end_as_they_are_said_to(gallery):
    ends = {entry.name: entry.run().snapshot for entry in gallery.entries()}
    off = {name: np.degrees(np.abs(end.theta - end.theta_demo).max()) for name, end in ends.items()}
    assert len(ends) == 8
    arrived = {"no-bias", "toed-in", "seven-joints", "foreign-arm", "noise"}
    assert {name for name, end in ends.items() if end.status == "converged"} == arrived
    assert max(off[name] for name in arrived) < 0.5 < off["conflict"] < 3  # the transfer's own error
    assert off["as-printed"] > 5 and ends["as-printed"].status == "moving"
    assert off["cannot-tell"] > 5 and ends["cannot-tell"].E < 0.01 and ends["cannot-tell"].status == "unobservable"


def test_one_is_written_with_what_lists_it(gallery, tmp_path, monkeypatch):
    shortest = gallery.entries()[1]
    monkeypatch.setattr(gallery, "entries", lambda: (shortest,))
    page, index = gallery.build_gallery(tmp_path / "made")
    assert page.stat().st_size < 1e6 and shortest.title in page.read_text("utf-8")
    assert f'href="{page.name}"' in index.read_text("utf-8") and shortest.title in index.read_text("utf-8")
