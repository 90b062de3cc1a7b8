"""Landscapes: the figures known for the Panda, agreement with plain loops everywhere, minima and basins."""

from functools import partial

import baselines
import msgspec
import numpy as np
import pytest

from viewimit.analysis.landscape import Landscape, grid_axes, landscape, landscape_over
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.transfers.transfer import conflict
from viewimit.estimation.views import FourViews
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

replace = msgspec.structs.replace


def panda(points=10, verged=False, yaw_deg=0.0, scene="panda"):
    scene = load_scene(scene)
    head = replace(scene.head, verged=verged)
    return World(replace(scene, head=head, demonstrator=replace(scene.demonstrator, yaw_deg=yaw_deg)), points)


def over_grid(world, transfer="epipolar", demo_deg=(45, -90), **options):
    """The landscape, all points taken as seen, and the demonstrator's images."""
    demo, _ = world.demo_images(np.radians(demo_deg))
    seen = np.ones((len(demo), 2), bool)
    return landscape_over(world, TRANSFERS[transfer], demo, seen, grid_axes(world), **options), demo


def flat(axes):
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 2)


@pytest.mark.parametrize(
    "transfer, at_minimum, at_truth, largest", [("epipolar", 1.585, 1.587, 803), ("linear", 1.58, 1.58, 456)]
)
def test_known_figures_of_the_panda(transfer, at_minimum, at_truth, largest):
    found, _ = over_grid(panda(), transfer)
    assert found.E.shape == (91, 181)
    np.testing.assert_allclose(np.degrees(found.minimum), [46, -90], atol=1e-9)
    digits = 0.5e-3 if transfer == "epipolar" else 0.5e-2  # half of the last digit known
    assert found.E.min() == pytest.approx(at_minimum, abs=digits)
    assert found.E[45, 90] == pytest.approx(at_truth, abs=digits)
    assert found.E.max() == pytest.approx(largest, abs=0.5)
    assert len(found.local_minima()) == 1
    assert found.basin_fraction() == 1.0


def test_known_conditions_of_the_panda():
    found, _ = over_grid(panda(), with_condition=True)
    assert np.median(found.condition) == pytest.approx(9.5, abs=0.05)
    assert found.condition.max() == pytest.approx(36, abs=0.5)


CASES = {
    "panda": ({}, (45, -90)),
    "iiwa": ({"scene": "iiwa"}, (45, -90)),
    "folded": ({}, (10, -170)),
    "stretched": ({"points": 20}, (80, -5)),
    "verged": ({"verged": True}, (45, -90)),
    "beside": ({"yaw_deg": 90}, (10, -20)),
    "beside, iiwa": ({"yaw_deg": 90, "scene": "iiwa"}, (10, -20)),
    "oblique": ({"yaw_deg": 135}, (45, -90)),
    "facing": ({"yaw_deg": 180}, (10, -20)),
    "facing, verged": ({"yaw_deg": 180, "verged": True}, (45, -90)),
    "facing, iiwa": ({"yaw_deg": 180, "scene": "iiwa"}, (10, -20)),
}


@pytest.mark.parametrize("options, demo_deg", CASES.values(), ids=CASES)
def test_E_agrees_with_lapack_everywhere(options, demo_deg):
    """The batch over the whole grid; the loop where A is worst conditioned, where the batch is itself inexact."""
    world = panda(**options)
    found, demo = over_grid(world, demo_deg=demo_deg, with_condition=True)
    postures, E = flat(found.axes), found.E.ravel()
    expected, condition = baselines.batch(world, demo, postures, with_condition=True)
    np.testing.assert_allclose(E, expected, rtol=1e-8)
    worst = np.argsort(condition)[-40:]
    np.testing.assert_allclose(E[worst], baselines.loop(world, demo, postures[worst]), rtol=1e-8)
    np.testing.assert_allclose(found.condition.ravel(), condition, rtol=1e-6)


@pytest.mark.parametrize("transfer", TRANSFERS)
def test_points_that_are_missing_somewhere_are_left_out_there(transfer):
    """A narrow image loses points at the ends of the range: each posture uses those that it has."""
    scene = load_scene("panda")
    world = World(replace(scene, head=replace(scene.head, focal=700.0)))
    axes = grid_axes(world, 15)
    demo, demo_visible = world.demo_images(np.radians([45, -90]))
    demo_visible = np.ones_like(demo_visible)
    demo_visible[3, 1] = False
    found = landscape_over(world, TRANSFERS[transfer], demo, demo_visible, axes, with_condition=True)
    counts = set()
    for (i, j), E in np.ndenumerate(found.E):
        own, own_visible = world.own_images((axes[0][i], axes[1][j]))
        views = FourViews(demo, own, np.concatenate([demo_visible, own_visible], -1))
        views = views.select(views.usable)
        counts.add(len(views.own))
        if len(views.own) < 5:
            assert np.isnan(E) and np.isnan(found.condition[i, j])
            continue
        fitted = TRANSFERS[transfer](views)
        assert E == pytest.approx(conflict(fitted.residual(views)), rel=1e-6, abs=1e-9)
        assert found.condition[i, j] == pytest.approx(float(fitted.condition), rel=1e-6)
    assert min(counts) < 5 and len(counts) > 3


def test_the_landscape_of_a_session_is_that_of_what_it_sees_and_of_its_transfer():
    session = Session(Settings(scene="panda-toed", noise_px=0.3, demonstrator_deg=(40, -80)))
    now = session.snapshot
    assert now.rectification is not None
    axes = grid_axes(session.world, 9.0)
    for by in (None, "linear"):
        found = landscape(session, 9.0, by, with_condition=True)
        expected = landscape_over(
            session.world, partial(now.fit, by=by), now.views.demo, now.views.visible[:, :2], axes, with_condition=True
        )
        np.testing.assert_array_equal(found.E, expected.E)
        np.testing.assert_array_equal(found.condition, expected.condition)
        for axis, wanted in zip(found.axes, axes):
            np.testing.assert_array_equal(axis, wanted)
    assert landscape(Session(Settings.paper(demonstrator_deg=(45, -90)))).E.shape == (91, 181)


def test_grids_cover_the_range_of_two_joints():
    rows, columns = grid_axes(panda())
    np.testing.assert_allclose(np.degrees(rows), np.arange(91), atol=1e-12)
    np.testing.assert_allclose(np.degrees(columns), np.arange(-180, 1), atol=1e-12)
    with pytest.raises(ValueError, match="step must be between"):
        grid_axes(panda(), 0)
    scene = load_scene("panda")
    one = replace(scene, moving_joints=(2,), range_deg=((0, 90),), start_deg=(25,))
    with pytest.raises(ValueError, match="two moving joints, this scene has 1"):
        grid_axes(World(one))


def neighbours(E, i, j):
    """The lower bound, the eight neighbours and the value that are on the grid."""
    for a in range(max(i - 1, 0), min(i + 2, E.shape[0])):
        for b in range(max(j - 1, 0), min(j + 2, E.shape[1])):
            if (a, b) != (i, j) and np.isfinite(E[a, b]):
                yield E[a, b], (a, b)


@pytest.mark.parametrize("seed", range(6))
def test_minima_and_basins_agree_with_plain_loops(seed):
    rng = np.random.default_rng(seed)
    E = rng.random((9, 13))
    if seed % 2:
        E[rng.random(E.shape) < 0.2] = np.nan
    axes = np.linspace(0, 1, 9), np.linspace(-2, -1, 13)
    found = Landscape(axes, E)
    cells = [(i, j) for i, j in np.ndindex(E.shape) if np.isfinite(E[i, j])]
    lowest = min(cells, key=lambda cell: E[cell])
    minima = sorted(
        (cell for cell in cells if all(E[cell] < value for value, _ in neighbours(E, *cell))), key=lambda cell: E[cell]
    )
    expected = [(axes[0][i], axes[1][j]) for i, j in minima]
    np.testing.assert_allclose(found.local_minima(), expected)
    np.testing.assert_allclose(found.minimum, expected[0])

    def descend(cell):
        value, lower = min(neighbours(E, *cell), default=(np.inf, cell))
        return descend(lower) if value < E[cell] else cell

    assert found.basin_fraction() == pytest.approx(sum(descend(cell) == lowest for cell in cells) / len(cells))
