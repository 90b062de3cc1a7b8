"""Minima between the grid's points: found where they are, told from artefacts of the grid; and Eq. (11) around them."""

import numpy as np
import pytest
from scipy.optimize import minimize

from viewimit.analysis.landscape import Landscape, conflict_at, landscape_over, seen_from
from viewimit.analysis.minima import MAX_RELATIVE_ERROR, RADII_DEG, convexity, hessian, local_minima
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

AXES = tuple(np.radians(np.linspace(low, high, n)) for low, high, n in ((0, 90, 46), (-180, 0, 91)))
BOUNDS = np.radians([[0.0, 90.0], [-180.0, 0.0]])


def over(function):
    """A landscape of function(degrees a, b) on a 2° grid, and its E at any posture."""
    E_at = lambda theta: function(*np.degrees(np.broadcast_arrays(*theta)))
    return Landscape(AXES, E_at((AXES[0][:, None], AXES[1][None]))), E_at


def test_a_bowl_between_grid_points_is_found_to_a_thousandth_of_a_degree():
    minima = local_minima(*over(lambda a, b: 1 + (a - 45.37) ** 2 + 0.3 * (b + 90.81) ** 2))
    np.testing.assert_allclose(np.degrees(minima.theta), [[45.37, -90.81]], atol=1e-3)
    assert minima.E == pytest.approx([1.0]) and not minima.on_limit.any()


@pytest.mark.parametrize("tilt", [0.31, -0.77, 1.9])
def test_a_narrow_valley_between_the_grids_lines_is_one_minimum(tilt):
    """A valley 0.2° wide whose floor falls slowly: its grid has many minima, itself one."""
    valley = lambda a, b: 400 * (a - 45 - tilt * (b + 90)) ** 2 + 0.01 * (b + 83.3) ** 2
    landscape, E_at = over(valley)
    assert len(landscape.local_minima()) > 5
    minima = local_minima(landscape, E_at)
    assert len(minima) == 1
    np.testing.assert_allclose(np.degrees(minima.theta[0]), [45 + tilt * 6.7, -83.3], atol=0.01)


def test_two_basins_are_two_minima_lowest_first_and_the_edge_is_told():
    two = lambda a, b: np.minimum((a - 20.5) ** 2 + (b + 40.5) ** 2 + 3, (a - 95) ** 2 + (b + 150.5) ** 2)
    minima = local_minima(*over(two))
    np.testing.assert_allclose(np.degrees(minima.theta), [[20.5, -40.5], [90, -150.5]], atol=1e-3)
    assert minima.E == pytest.approx([3, 25]) and minima.on_limit.tolist() == [False, True]


def test_the_real_minimum_is_where_another_method_finds_it():
    session = Session(Settings.paper())
    seen = seen_from(session.world, session.snapshot)
    E_at = lambda theta: conflict_at(*seen, theta)[0]
    minima = local_minima(landscape_over(*seen, tuple(axis[::2] for axis in AXES)), E_at)
    at = lambda degrees: float(E_at(np.radians(degrees)[:, None])[0])
    other = minimize(at, [46, -90], method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-10})
    np.testing.assert_allclose(np.degrees(minima.theta), [other.x], atol=0.01)
    assert minima.E == pytest.approx([other.fun], rel=1e-6)


def quadratic(Q, constant=2.0, place=(45.0, -90.0)):
    def E_at(theta):
        away = np.degrees(np.stack(np.broadcast_arrays(*theta))) - np.reshape(place, (2,) + (1,) * np.ndim(theta[0]))
        return constant + np.einsum("i...,ij,j...->...", away, np.array(Q), away)

    return E_at


def test_a_quartic_leaves_its_parabola_where_it_must():
    """E = r² + c r⁴ errs by c r²: within MAX_RELATIVE_ERROR up to r = √(MAX_RELATIVE_ERROR / c). Convex throughout."""
    c = MAX_RELATIVE_ERROR / 12.0**2
    square = quadratic(np.eye(2), 0.0)
    found = convexity(lambda theta: square(theta) + c * square(theta) ** 2, np.radians([45.0, -90.0]), BOUNDS)
    assert found.holds_to_deg == RADII_DEG[RADII_DEG < 12][-1] and found.convex_radius_deg == RADII_DEG[-1]
    dented = convexity(lambda theta: square(theta) - square(theta) ** 2 / 1200, np.radians([45.0, -90.0]), BOUNDS)
    assert dented.convex_radius_deg == RADII_DEG[RADII_DEG < np.sqrt(1200 / 6)][-1]  # E'' = 2 - 12 r²/1200


def test_the_hessian_of_the_real_E_does_not_depend_on_its_step():
    session = Session(Settings.paper())
    E_at = lambda theta: conflict_at(*seen_from(session.world, session.snapshot), theta)[0]
    theta = np.radians([[45.8, 60.0], [-89.7, -40.0]])
    h = np.radians(0.1)
    for k, found in enumerate(hessian(E_at, theta)):
        at = lambda da, db, k=k: float(E_at(theta[:, k : k + 1] + h * np.array([[da], [db]]))[0])
        second = at(1, 0) - 2 * at(0, 0) + at(-1, 0), at(0, 1) - 2 * at(0, 0) + at(0, -1)
        mixed = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / 4
        np.testing.assert_allclose(found * 0.01, [[second[0], mixed], [mixed, second[1]]], rtol=0.01, atol=1e-7)
