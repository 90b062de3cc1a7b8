"""What a step changes of its scene, and how a fault in that is told."""

import numpy as np
import pytest
from viewimit.app.lessons.source import load

from viewimit.simulation.scene import extended, load_scene

LESSON = """title = "A"
short = "A"
about = "A"
minutes = 1

[[step]]
id = "a"
title = "A"
text = "A"
say = "A"
[step.scene{}]
"""


def lesson(tmp_path, *scene):
    path = tmp_path / "mine.toml"
    path.write_text(LESSON.format(scene[0]) + "\n".join(scene[1:]) + "\n")
    return path


def test_only_what_is_named_differs():
    scene = load_scene()
    other = extended(scene, {"head": {"baseline": 0.2}, "learner": {"yaw_deg": 30}})
    assert other.head.baseline == 0.2 and other.learner.yaw_deg == 30
    assert other.head.focal == scene.head.focal and other.learner.position == scene.learner.position
    assert other.demonstrator == scene.demonstrator and other.points == scene.points
    assert extended(scene, {}) == scene


def test_a_step_s_scene_is_loaded(tmp_path):
    step = load(lesson(tmp_path, ".head", "baseline = 0.2")).step[0]
    assert step.scene == {"head": {"baseline": 0.2}}


def test_joints_are_not_changed_and_faults_name_line_and_field(tmp_path):
    with pytest.raises(ValueError, match=r"mine.toml, line 12: step\[0\].scene.robot: no field that a step can change"):
        load(lesson(tmp_path, "", 'robot = "iiwa"'))
    with pytest.raises(ValueError, match=r"mine.toml, line 11: step\[0\].scene: .*focal"):
        load(lesson(tmp_path, "", 'head = {focal = "far"}'), tried=True)


def test_lessons_without_changes_keep_their_world():
    from walking import course_at

    course = course_at("eyes")
    world = course.session.world
    course.go(1)
    assert course.session.world is world
    np.testing.assert_allclose(world.scene.head.position, load_scene().head.position)
