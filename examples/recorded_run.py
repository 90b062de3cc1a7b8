"""A run is recorded with its robot, and repeated without: the same looks, the same motions, to the last bit.

    python examples/recorded_run.py run.npz

What a learner saw can so be looked into at home, step by step, and a fault on the robot be repeated in a test.
"""

import sys

import numpy as np
from fake_robot import FakeRobot

from viewimit import FourViews, Session


class Recorder:
    """Arm and eyes, with all that passes through them kept."""

    def __init__(self, arm, eyes):
        self.arm, self.eyes = arm, eyes
        self.lower, self.upper, self.start, self.noise_px = arm.lower, arm.upper, arm.start, eyes.noise_px
        self.sent, self.stood, self.looks = [], [], []

    def move(self, theta):
        self.sent.append(theta)
        self.stood.append(self.arm.move(theta))
        return self.stood[-1]

    def look(self):
        self.looks.append(self.eyes.look())
        return self.looks[-1]

    def save(self, path):
        demo, own, visible = zip(*((look.demo, look.own, look.visible) for look in self.looks))
        np.savez_compressed(
            path,
            demo=demo,
            own=own,
            visible=visible,
            lower=self.lower,
            upper=self.upper,
            start=self.start,
            noise_px=self.noise_px,
            sent=self.sent,
            stood=self.stood,
        )


class Replay:
    """Arm and eyes of a file that `Recorder` has saved."""

    def __init__(self, path):
        with np.load(path) as kept:
            kept = dict(kept)
        self.lower, self.upper, self.start = kept["lower"], kept["upper"], kept["start"]
        self.noise_px = float(kept["noise_px"])
        self.motions = iter(list(zip(kept["sent"], kept["stood"])))
        self.looks = iter(map(FourViews, kept["demo"], kept["own"], kept["visible"]))

    def move(self, theta):
        sent, stood = next(self.motions, (None, None))
        if sent is None or not np.array_equal(sent, theta):
            raise ValueError(
                f"the recorded arm went elsewhere than to {np.degrees(theta).round(3)} degrees: "
                "repeat the run with the settings that it had"
            )
        return stood

    def look(self):
        return next(self.looks)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    path, robot = sys.argv[1], FakeRobot(demonstrator_deg=(30, -45, 80))
    recorder = Recorder(robot, robot)
    Session.of(recorder, recorder).run()
    recorder.save(path)
    replay = Replay(path)
    ended = Session.of(replay, replay).run()
    print(f"{ended.status} at {np.degrees(ended.theta).round(1)} after {ended.motions} motions, without the robot")
