"""Rotations against scipy's, and what makes a view upright."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewimit.geometry.rigid import look_rotation, rigid_transform, rotation_about_axis, rotation_from_rpy

scipy_rotation = pytest.importorskip("scipy.spatial.transform").Rotation
component = st.floats(-10, 10).filter(lambda x: x == 0 or abs(x) > 1e-3)
vector = st.tuples(component, component, component)
angle = st.floats(-7, 7)


@given(vector.filter(any), angle)
def test_rotation_about_axis_is_scipys_rotation_vector(axis, angle):
    expected = scipy_rotation.from_rotvec(angle * np.array(axis) / np.linalg.norm(axis)).as_matrix()
    np.testing.assert_allclose(rotation_about_axis(axis, angle), expected, atol=1e-14)


@given(st.tuples(angle, angle, angle))
def test_rpy_is_about_fixed_axes(rpy):
    np.testing.assert_allclose(rotation_from_rpy(rpy), scipy_rotation.from_euler("xyz", rpy).as_matrix(), atol=1e-14)


def test_rigid_transform_places_rotation_and_translation():
    R = rotation_from_rpy([0.1, 0.2, 0.3])
    point = np.array([1.0, -2.0, 0.5])
    np.testing.assert_allclose((rigid_transform(R, [4, 5, 6]) @ [*point, 1])[:3], R @ point + [4, 5, 6], atol=1e-15)


def upright_enough(direction):
    x, y, _ = direction
    return np.hypot(x, y) > 1e-3 * np.linalg.norm(direction)


@given(vector.filter(any).filter(upright_enough))
def test_look_rotation_looks_along_the_direction_with_the_horizon_level(direction):
    R = look_rotation(direction)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1)
    np.testing.assert_allclose(R[:, 2], np.array(direction) / np.linalg.norm(direction), atol=1e-12)
    assert R[2, 0] == pytest.approx(0, abs=1e-12)  # image x is horizontal
    assert R[2, 1] < 0  # image y points down


@pytest.mark.parametrize("direction", [(0, 0, 0), (0, 0, 1), (0, 0, -3)])
def test_look_rotation_refuses_a_direction_without_an_upright_image(direction):
    with pytest.raises(ValueError, match="zero or parallel"):
        look_rotation(direction)
