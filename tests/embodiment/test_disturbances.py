"""Disturbances against their settings; and each is one entry, which page, commands and captions have from its field."""

import numpy as np
import pytest

from viewimit.drawing.plots import describe_settings
from viewimit.loop.session import Session
from viewimit.loop.settings import DISTURBANCES, Settings
from viewimit.simulation.disturbances import OUTLIER_PX, ArmDisturbance, ImageDisturbance, disturb, drive

POINTS, SEEN = np.zeros((5000, 4)), np.ones((5000, 2), bool)


def spoilt(seed=(1,), **amounts):
    return disturb(Settings.paper(**amounts).amounts(ImageDisturbance), POINTS, SEEN, seed)


def driven(theta, sent, **amounts):
    return np.degrees(drive(Settings.paper(**amounts).amounts(ArmDisturbance), np.radians(theta), np.radians(sent)))


def test_noise_has_its_standard_deviation_and_grows_in_place():
    def noise(sigma):
        return spoilt(noise_px=sigma)[0]

    # the standard deviation of 20000 draws is known to 1/√40000, five times that is allowed
    assert noise(0.5).std() == pytest.approx(0.5, rel=0.025)
    np.testing.assert_allclose(noise(1.0), 2 * noise(0.5), atol=1e-14)


def test_a_larger_share_of_missing_points_loses_the_same_ones_first():
    def seen(share):
        return spoilt(missing=share)[1]

    assert seen(0.0).all() and not seen(1.0).any()
    assert np.mean(~seen(0.1)) == pytest.approx(0.1, abs=0.015)  # five standard deviations
    assert not (seen(0.3) & ~seen(0.1)).any()


def test_a_share_of_points_is_found_anywhere_within_gross_px():
    found, seen = spoilt(outliers=0.1)
    wrong = found.reshape(5000, 2, 2).any(-1)
    assert seen.all() and wrong.mean() == pytest.approx(0.1, abs=0.015)
    assert 0.9 * OUTLIER_PX < np.abs(found).max() <= OUTLIER_PX


def test_one_disturbance_of_an_image_does_not_change_what_another_does():
    noisy, all_at_once = spoilt(noise_px=0.5)[0], spoilt(noise_px=0.5, missing=0.2, outliers=0.1)
    missing, outliers = spoilt(missing=0.2)[1], spoilt(outliers=0.1)[0]
    np.testing.assert_array_equal(all_at_once[1], missing)
    np.testing.assert_allclose(all_at_once[0], noisy + outliers, atol=1e-12)


def test_an_arm_obeys_by_its_gain_and_in_its_steps():
    theta, sent = (10.0, -20.0), (20.0, -24.0)
    np.testing.assert_array_equal(driven(theta, sent), np.degrees(np.radians(sent)))
    np.testing.assert_allclose(driven(theta, sent, gain_error=0.05), [20.5, -24.2])
    stepped = driven(theta, sent, gain_error=0.05, encoder_step_deg=0.4)
    np.testing.assert_allclose(stepped, [20.5, -24.2], atol=0.2 + 1e-9)
    np.testing.assert_allclose(stepped / 0.4, np.round(stepped / 0.4), atol=1e-9)
    np.testing.assert_allclose(driven(theta, (20.3, -24.3), encoder_step_deg=0.4), [20.4, -24.4])


@pytest.mark.parametrize("name, entry", DISTURBANCES.items())
class TestEach:
    def test_it_changes_a_run_and_is_in_the_caption(self, name, entry):
        low, high = entry.bounds
        amount = low + 0.3 * (high - low)
        runs = [Session(Settings.paper(start_deg=(25, -45), **{name: value})) for value in (0.0, amount)]
        for run in runs:
            run.run(4)
        plain, disturbed = ([moment.E for moment in run.history] for run in runs)
        assert plain != disturbed
        assert (
            describe_settings(runs[1].settings)
            == f"{describe_settings(runs[0].settings)} · {entry.caption.format(amount)}"
        )

    def test_it_is_an_option(self, name, entry, ask, ask_json):
        option = "--" + name.replace("_", "-")
        assert entry.description in " ".join(ask("imitate", "--help")[1].split())
        told = ask_json("imitate", option, entry.bounds[1] / 100, "--max-motions", 1)[1]
        assert told["settings"][name] == entry.bounds[1] / 100
        status, _, err = ask("imitate", option, entry.bounds[1] + 1)
        assert status == 2 and f"{option}: {name} must be between" in err
