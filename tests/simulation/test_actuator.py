"""What an arm makes of a command."""

import numpy as np

from viewimit.simulation.actuator import Actuator


def test_an_arm_obeys_by_its_gain_and_in_its_steps():
    theta, command = np.radians([10.0, -20.0]), np.radians([10.0, -4.0])
    np.testing.assert_allclose(Actuator().move(theta, command), theta + command)
    np.testing.assert_allclose(np.degrees(Actuator(0.05).move(theta, command)), [20.5, -24.2])
    np.testing.assert_allclose(np.degrees(Actuator(0.05, 0.4).move(theta, command)), [20.5, -24.2], atol=0.2 + 1e-9)
    steps = np.degrees(Actuator(0.05, 0.4).move(theta, command)) / 0.4
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
