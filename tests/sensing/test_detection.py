"""Balls are found where they are drawn, by their own hue, and not where they are hidden; pictures drawn here, not by
the renderer."""

import sys

import numpy as np
import pytest

from viewimit.geometry.components import connected_components
from viewimit.sensing.detection import detect, read_pictures
from viewimit.simulation.robot import colours, load_markers

HUES = np.array([0.0, 40.0, 80.0, 120.0, 200.0, 280.0])
FINE = 8  # samples a pixel and axis


def drawn(discs, size=(120, 160), grey=130, light=0.9):
    """Discs (x, y, radius, colour) over grey, later ones in front, each pixel the mean of FINE² samples."""
    height, width = size
    y, x = (np.mgrid[: FINE * height, : FINE * width] + 0.5) / FINE
    picture = np.full((*x.shape, 3), float(grey))
    for u, v, radius, colour in discs:
        picture[np.hypot(x - u, y - v) < radius] = 255 * light * np.asarray(colour)
    return picture.reshape(height, FINE, width, FINE, 3).mean((1, 3)).round().astype(np.uint8)


def test_middles_are_found_to_a_few_hundredths_of_a_pixel():
    rng = np.random.default_rng(0)
    for _ in range(5):
        middles = np.stack([15 + 25 * np.arange(6), rng.uniform(20, 100, 6)], -1) + rng.uniform(-4, 4, (6, 2))
        discs = [(*middle, rng.uniform(3, 4.5), colour) for middle, colour in zip(middles, colours(HUES))]
        found = detect(drawn(discs), HUES)
        assert found.found.all()
        assert np.abs(found.points - middles).max() < 0.06


@pytest.mark.parametrize("light", [0.5, 0.7, 1.0])
def test_markers_are_identified_by_hue_in_any_white_light(light):
    hues = load_markers("panda").hue_deg
    middles = np.stack([12 + 20.0 * (np.arange(len(hues)) % 7), 12 + 20.0 * (np.arange(len(hues)) // 7)], -1)
    discs = [(*middle, 3.5, colour) for middle, colour in zip(middles, colours(hues))]
    found = detect(drawn(discs, light=light), hues)
    assert found.found.all() and np.abs(found.points - middles).max() < 0.1


def test_a_ball_half_hidden_is_not_found():
    grey = [0.75] * 3
    ball, other = (60.0, 60.0, 4.0, colours(40.0)), (100.0, 60.0, 4.0, colours(200.0))
    for hidden in (0.4, 0.5, 0.6, 0.8):  # of the diameter
        cover = (60.0, 60.0 + 4 - 8 * hidden + 30, 30.0, grey)
        found = detect(drawn([ball, other, cover]), HUES)
        assert found.found.tolist() == [False, False, False, False, True, False]
        assert np.isnan(found.points[1]).all()


def test_grey_pictures_have_no_marker_and_the_larger_of_two_blobs_counts():
    assert not detect(np.full((48, 64, 3), 90, np.uint8), HUES).found.any()
    red = colours(0.0)
    found = detect(drawn([(30, 40, 3.5, red), (100, 40, 4.5, red)]), HUES)
    np.testing.assert_allclose(found.points[0], (100, 40), atol=0.06)


def test_whatever_is_connected_is_one_component_soon_however_long():
    """As a plain loop finds; a U of 1,500 rows, whose sides meet in the last row alone, in a few rounds."""
    rng, count, down = np.random.default_rng(0), 3000, np.arange(2999)
    rounds = []
    for one, other in (*rng.integers(0, count, (3, 2, 2000)), (down, np.minimum(down + 2, count - 1))):
        plain = np.arange(count)
        for a, b in zip(one, other):
            plain[plain == max(plain[a], plain[b])] = min(plain[a], plain[b])
        sys.setprofile(lambda _, event, called: rounds.append(called) if event == "c_call" else None)
        found = connected_components(count, one, other)
        sys.setprofile(None)
        assert found.tolist() == plain.tolist() and len(rounds) < 500


def test_files_that_are_no_pictures_are_named(tmp_path):
    pytest.importorskip("cv2")
    with pytest.raises(FileNotFoundError, match="No such file"):
        next(read_pictures(tmp_path / "l.png"))
    for name in ("l.png", "l.mp4"):
        (tmp_path / name).write_text("no picture")
        with pytest.raises(ValueError, match=name):
            next(read_pictures(tmp_path / name))
