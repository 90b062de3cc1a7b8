"""Quaternions pushed past viser's setters, against viser's own rotations; and the private message still exists."""

import dataclasses
from typing import get_type_hints

import numpy as np
import pytest
import viser.transforms as vtf
from hypothesis import given
from hypothesis import strategies as st
from viewimit.app.scene.rotations import joint_quaternion, quaternion
from viewimit.app.viser_private import serving_with
from viser import GuiHtmlHandle
from viser._messages import GuiHtmlProps, SceneNodeUpdateMessage, SetOrientationMessage

from viewimit.geometry.rigid import rotation_about_axis, rotation_from_rpy

angles = st.floats(-np.pi, np.pi)


@given(angles, angles, angles)
def test_quaternion_is_the_rotation(roll, pitch, yaw):
    R = rotation_from_rpy([roll, pitch, yaw])
    assert np.allclose(vtf.SO3(np.array(quaternion(R))).as_matrix(), R, atol=1e-12)


@pytest.mark.parametrize("axis", np.eye(3))
def test_half_turns_have_no_preferred_component(axis):
    R = rotation_about_axis(axis, np.pi)
    assert np.allclose(np.abs(quaternion(R)), [0, *axis], atol=1e-12)


@given(angles, angles, angles)
def test_joint_quaternion_turns_after_the_rest_pose(roll, yaw, angle):
    rest, axis = rotation_from_rpy([roll, 0.3, yaw]), np.array([0.6, 0.0, 0.8])
    pushed = vtf.SO3(np.array(joint_quaternion(quaternion(rest), axis, angle))).as_matrix()
    assert np.allclose(pushed, rest @ rotation_about_axis(axis, angle), atol=1e-12)


def test_the_private_messages_are_as_relied_upon():
    names = lambda message: [field.name for field in dataclasses.fields(message)]
    assert names(SetOrientationMessage) == ["name", "wxyz", "owner"]
    assert names(SceneNodeUpdateMessage) == ["name", "updates", "owner"]
    assert callable(GuiHtmlHandle._queue_update) and "content" in get_type_hints(GuiHtmlProps)


def test_a_viser_that_opens_its_port_otherwise_is_not_left_unguarded():
    with pytest.raises(RuntimeError, match="opens its port in a way"), serving_with(lambda plain, *_, **__: None):
        pass
