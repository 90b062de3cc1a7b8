"""A body image comes back from its file to the last bit, refuses what it is not, and is of postures far apart."""

from dataclasses import replace

import numpy as np
import pytest
from sameness import assert_same

from viewimit.loop.self_calibration import MIN_POSTURES, Body, SelfCalibration, spread_postures
from viewimit.servo.observation import Visit

PANDA = Body("panda", (2, 4), (90.0, 180.0), 10, "projected", (0.0, 0.0))
LOW, HIGH = np.radians((0.0, -180.0)), np.radians((90.0, 0.0))


def rehearsed(count=4, seed=0):
    rng = np.random.default_rng(seed)
    seen = rng.random((count, 10, 2)) < 0.9
    visits = zip(rng.uniform(0, 1.5, (count, 2)), rng.uniform(0, 240, (count, 10, 4)), seen)
    return SelfCalibration(PANDA, "panda", 0.25, tuple(Visit.of(*visit) for visit in visits))


def test_what_is_saved_comes_back(tmp_path):
    body = rehearsed()
    body.save(tmp_path / "body.npz")
    back = SelfCalibration.load(tmp_path / "body.npz")
    assert (back.body, back.scene, back.noise_px, len(back)) == (PANDA, "panda", 0.25, 4)
    for one, other in zip(back.visits, body.visits):
        np.testing.assert_allclose(one.displacement, other.displacement, rtol=1e-15)  # degrees in the file
        assert_same((one.own, one.seen), (other.own, other.seen))


def spoilt(tmp_path, **changes):
    path = tmp_path / "body.npz"
    rehearsed().save(path)
    with np.load(path) as file:
        table = {name: file[name] for name in file.files}
    table |= changes
    np.savez(path, **{name: value for name, value in table.items() if value is not None})
    return path


@pytest.mark.parametrize(
    "changes, what",
    [
        ({"own_px": None}, "'own_px' is missing"),
        ({"own_px": np.zeros((4, 10, 3))}, r"own_px has shape \(4, 10, 3\), not \(4, 10, 4\)"),
        ({"own_px": np.full((4, 10, 4), np.nan)}, "a number in it is not finite"),
        ({"displacement_deg": np.zeros((4, 3))}, r"displacement_deg has shape \(4, 3\), not \(4, 2\)"),
        ({"displacement_deg": np.full((4, 2), np.inf)}, "a number in it is not finite"),
        ({"seen": np.ones((4, 10, 2))}, "which of them were seen"),
        ({"noise_px": -1.0}, "a number in it is not finite"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_a_file_that_is_none_says_what_is_wrong(tmp_path, changes, what):
    path = spoilt(tmp_path, **changes)
    with pytest.raises(ValueError, match=f"{path}: no calibration.*{what}.*viewimit rehearse"):
        SelfCalibration.load(path)


@pytest.mark.parametrize("content", [b"", b"theta,E\n1,2\n", b"PK\x03\x04 broken"])
def test_other_files_are_refused(tmp_path, content):
    path = tmp_path / "body.npz"
    path.write_bytes(content)
    with pytest.raises(ValueError, match="not an .npz file"):
        SelfCalibration.load(path)


def test_another_body_is_refused_with_what_differs():
    PANDA.require(PANDA)
    for name, other in {"robot": "iiwa", "points": 16, "sensor": "rendered"}.items():
        with pytest.raises(ValueError, match=f"rehearsed with {name} {getattr(PANDA, name)}, here it is {other}"):
            replace(PANDA, **{name: other}).require(PANDA)


def test_displacements_are_told_from_wherever_an_imitation_begins():
    """A start so far above its lower limits: what was rehearsed there is where it is."""
    body, start = rehearsed(), np.radians((25.0, 100.0))  # above the lower limits
    for visit, told in zip(body.visits, body.seen_from(-start)):
        np.testing.assert_allclose(told.displacement + start, visit.displacement)
        assert told.own is visit.own


@pytest.mark.parametrize("count", [MIN_POSTURES, 12, 40])
def test_postures_are_within_limits_and_apart_and_repeat_themselves(count):
    postures = spread_postures(LOW, HIGH, count, np.random.default_rng(1))
    assert postures.shape == (count, 2) and (postures >= LOW).all() and (postures <= HIGH).all()
    np.testing.assert_array_equal(postures, spread_postures(LOW, HIGH, count, np.random.default_rng(1)))
    assert not np.array_equal(postures, spread_postures(LOW, HIGH, count, np.random.default_rng(2)))
    scaled = (postures - LOW) / (HIGH - LOW)
    drawn = np.random.default_rng(0).uniform(size=(2000, 2))
    far = lambda among: np.linalg.norm(drawn[:, None] - among, axis=-1).min(1).mean()
    chance = [far(np.random.default_rng(k).uniform(size=(count, 2))) for k in range(20)]
    assert far(scaled) < min(chance), "nearer to every posture of the range than any random ones"
