"""Where points are symmetric about the arm's plane, the mirrored posture fits as well: nobody claims to stand there."""

import numpy as np
import pytest
from axle_markers import axle_markers, in_plane, one_pair
from sameness import error_deg

from viewimit.estimation.residuals import PredictedResiduals
from viewimit.experiments.bench.draws import SurfaceEyes
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo.estimator.swaps import find_swaps, with_swaps

PARALLEL = 'extends = "iiwa"\nrange_deg = [[-50, 50], [-100, 100]]\n'
HEADS = {"parallel": PARALLEL, "toed in": PARALLEL + "[head]\ntoe_in_deg = 12\n"}
RUNS = [  # demonstrator, start, seed
    ((45.0, -53.9), (-8.7, 78.1), 6),
    ((-29.8, 96.9), (6.6, -1.9), 9),
]
OUT_OF_THE_PLANE = (  # in which all points lie where both joints are at 0
    'extends = "panda"\nmoving_joints = [3, 5]\nrange_deg = [[-60, 60], [-80, 80]]\nstart_deg = [10, 10]\n'
    "posture_deg = [0, 45, 0, -90, 0, 90, 0]\n"
)
RUNS_OUT_OF_THE_PLANE = [((-49.7, -42.1), (36.2, 13.1), 0), ((-47.7, -28.8), (59.9, -49.1), 3)]
heads = pytest.mark.parametrize("scene", HEADS.values(), ids=HEADS)


def session_of(scene, body, **settings):
    return Session(
        Settings(scene=scene, **settings), open_eyes=lambda camera, scene, points: SurfaceEyes(scene, body(scene), None)
    )


def without_handedness(monkeypatch):
    monkeypatch.setattr(PredictedResiduals, "mirror_residual", lambda self, own, points: None)


@pytest.mark.parametrize(
    "scene, body, run",
    [
        (HEADS["toed in"], axle_markers, RUNS[0]),
        (OUT_OF_THE_PLANE, in_plane, RUNS_OUT_OF_THE_PLANE[0]),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (
                *((HEADS["parallel"], axle_markers, run) for run in RUNS),
                (HEADS["toed in"], axle_markers, RUNS[1]),
                (OUT_OF_THE_PLANE, in_plane, RUNS_OUT_OF_THE_PLANE[1]),
            )
        ),
    ],
)
def test_a_claim_is_of_the_demonstrators_posture_and_not_of_its_mirror_image(monkeypatch, scene, body, run):
    demonstrator, start, seed = run

    def end():
        settings = {"demonstrator_deg": demonstrator, "start_deg": start, "seed": seed}
        return session_of(scene, body, noise_px=0.25, frames=25, **settings).run(300, 5).last

    last = end()
    assert last.status in ("converged", "settled") and error_deg(last) < 2 * np.degrees(last.expected_error) < 4
    # The final adjustment alone prevents such a claim as well: a similarity of one head's images does not reflect.
    without_handedness(monkeypatch)
    last = end()
    assert not last.status.is_claim or error_deg(last) < 2 * np.degrees(last.expected_error)


@heads
def test_at_the_mirrored_posture_the_predicted_conflict_is_no_longer_small(monkeypatch, scene):
    session = session_of(scene, axle_markers, demonstrator_deg=(40, -60))
    ask = session.predicted_residuals(session.snapshot)
    E = lambda theta_deg: np.square(ask(session.world.own_images(np.radians(theta_deg))[0])).sum() / 28
    assert E((40, -60)) < 1e-6 and E((-40, 60)) > 10
    without_handedness(monkeypatch)
    assert E((40, -60)) < 1e-6 and E((-40, 60)) < 3


@heads
def test_a_swapped_pair_is_named_although_the_mirror_image_fits_without_an_exchange(monkeypatch, scene):
    """All other points lie in one plane, about which that pair is symmetric."""
    session = session_of(scene, one_pair, demonstrator_deg=(40, -60))
    pair = (16, 17)

    def asked(pairs):
        seen = session.observation(session.snapshot)
        start = session.settings.start_rad
        predict = lambda displacement: session.world.own_images(np.moveaxis(displacement + start, -1, 0))[0]
        residuals = with_swaps(session.predicted_residuals(session.snapshot), pairs)
        return find_swaps(predict, residuals, seen.lower, seen.upper, 1.0)

    assert asked(()) == () and asked((pair,)) == (pair,)
    without_handedness(monkeypatch)
    assert asked((pair,)) == ()
