"""The gallery's table: eight runs that end as their captions say, and what is written of one."""

import numpy as np
import pytest

pytest.importorskip("sphinx")
from directives import gallery  # noqa: E402


def test_the_runs_end_as_they_are_said_to():
    ends = {entry.name: entry.run().snapshot for entry in gallery.entries()}
    off = {name: np.degrees(np.abs(end.theta - end.theta_demo).max()) for name, end in ends.items()}
    assert len(ends) == 8
    arrived = {"no-bias", "toed-in", "seven-joints", "foreign-arm", "noise"}
    assert {name for name, end in ends.items() if end.status == "converged"} == arrived
    assert max(off[name] for name in arrived) < 0.5 < off["conflict"] < 3  # the transfer's own error
    assert off["as-printed"] > 5 and ends["as-printed"].status == "moving"
    assert off["cannot-tell"] > 5 and ends["cannot-tell"].E < 0.01 and ends["cannot-tell"].status == "unobservable"


def test_one_is_written_with_what_lists_it(tmp_path, monkeypatch):
    shortest = gallery.entries()[1]
    monkeypatch.setattr(gallery, "entries", lambda: (shortest,))
    listed, made = gallery.build_gallery(tmp_path / "made"), tmp_path / "made" / f"{shortest.name}.html"
    assert made.stat().st_size < 1e6 and shortest.title in made.read_text("utf-8")
    for address in (f'href="gallery/{made.name}"', f'src="gallery/{shortest.name}.webp"', shortest.title):
        assert address in listed
    assert (tmp_path / "made" / f"{shortest.name}.webp").is_file()


def test_each_has_a_picture_and_no_picture_is_of_another():
    pictures = {path.stem for path in (gallery.DOCS / gallery.FOLDER).glob("*.webp")}
    assert pictures == {entry.name for entry in gallery.entries()}
