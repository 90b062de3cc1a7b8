"""An arm with weight: motors of limited torque and speed drive it, and hold it against gravity, a little below."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .client import connect, quiet

STEP_S = 1 / 240  # PyBullet's own, for which its motors are made
GRAVITY = 9.81
STIFFNESS, DAMPING = 0.1, 0.5  # of PyBullet's motors; they let a Panda sag by 0.1° to 0.3°
STILL, LONGEST_S = 1e-4, 20.0  # rad/s; of simulated time
LOOK_EVERY = 10  # steps


class Arm:
    """One arm of a URDF on a fixed base, standing somewhere at rest. Joints are its revolute ones, base to tip."""

    def __init__(self, urdf: Path):
        self._client = connect()
        with quiet():
            self._body = self._client.loadURDF(str(urdf), useFixedBase=True)
        self._client.setGravity(0, 0, -GRAVITY)
        self._client.setTimeStep(STEP_S)
        infos = [self._client.getJointInfo(self._body, k) for k in range(self._client.getNumJoints(self._body))]
        infos = [info for info in infos if info[2] == self._client.JOINT_REVOLUTE]
        self._joints = [info[0] for info in infos]
        self._effort, self._speed = [info[10] for info in infos], [info[11] for info in infos]

    def drive(self, theta: NDArray, command: NDArray) -> NDArray:
        """From rest at theta to where it comes to rest once told to go to `command`; (m,) rad each."""
        for joint, angle in zip(self._joints, theta, strict=True):
            self._client.resetJointState(self._body, joint, float(angle))
        for joint, angle, effort, speed in zip(self._joints, command, self._effort, self._speed, strict=True):
            self._client.setJointMotorControl2(
                self._body,
                joint,
                self._client.POSITION_CONTROL,
                targetPosition=float(angle),
                force=effort,
                maxVelocity=speed,
                positionGain=STIFFNESS,
                velocityGain=DAMPING,
            )
        for _ in range(round(LONGEST_S / STEP_S / LOOK_EVERY)):
            for _ in range(LOOK_EVERY):
                self._client.stepSimulation()
            states = self._client.getJointStates(self._body, self._joints)
            if all(abs(state[1]) < STILL for state in states):
                break
        return np.array([state[0] for state in states])
