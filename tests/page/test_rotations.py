"""A joint's quaternion against viser's own rotations."""

import numpy as np
import viser.transforms as vtf
from hypothesis import given
from hypothesis import strategies as st
from viewimit.app.scene.arms import joint_quaternion
from viewimit.app.scene.nodes import quaternion

from viewimit.geometry.rigid import rotation_about_axis, rotation_from_rpy

angles = st.floats(-np.pi, np.pi)


@given(angles, angles, angles)
def test_joint_quaternion_turns_after_the_rest_pose(roll, yaw, angle):
    rest, axis = rotation_from_rpy([roll, 0.3, yaw]), np.array([0.6, 0.0, 0.8])
    pushed = vtf.SO3(np.array(joint_quaternion(quaternion(rest), axis, angle))).as_matrix()
    assert np.allclose(pushed, rest @ rotation_about_axis(axis, angle), atol=1e-12)
