"""A session rectifies where its cameras ask for it, and only there; it repeats itself, comes back and goes on."""

import msgspec
import numpy as np
import pytest

from viewimit.estimation.rectification import MAX_LOOKS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

TOED = Settings(scene="panda-toed", start_deg=(25, -45))


def error_deg(moment):
    return np.degrees(np.abs(moment.theta - moment.theta_demo).max())


def postures(session):
    return [(moment.theta.tolist(), moment.E, moment.e.tolist()) for moment in session.history]


def test_with_toed_in_unlike_cameras_the_learner_arrives_only_if_images_are_rectified():
    last = Session(TOED).run(40).last
    assert last.status == "converged" and error_deg(last) < 0.5 and last.rectification is not None
    assert error_deg(Session(msgspec.structs.replace(TOED, rectify="off")).run(40).last) > 3


@pytest.mark.parametrize("scene, noise_px", [("panda", 0.5), ("panda-facing", 0.0), ("iiwa", 0.5)])
def test_with_parallel_axes_a_run_equals_one_without_rectification_to_the_last_bit(scene, noise_px):
    asked = Settings.paper(scene=scene, noise_px=noise_px)
    auto, off = (Session(msgspec.structs.replace(asked, rectify=how)) for how in ("auto", "off"))
    auto.run(15)
    off.run(15)
    assert postures(auto) == postures(off) and all(moment.rectification is None for moment in auto.history)


def test_rectification_is_refined_at_each_posture_until_enough_are_known():
    session = Session(msgspec.structs.replace(TOED, servo="gradient-retuned", noise_px=0.1, frames=1))
    session.run(MAX_LOOKS + 4)
    left = [moment.rectification.left.tolist() for moment in session.history]
    assert len({str(H) for H in left[: MAX_LOOKS + 1]}) == MAX_LOOKS + 1
    assert left[MAX_LOOKS] == left[MAX_LOOKS + 1] == left[MAX_LOOKS + 4]
