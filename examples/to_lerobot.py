"""Runs as a LeRobot data set: an episode a run, a frame a motion, to train a policy on what the servo did.

    pip install lerobot
    python examples/to_lerobot.py FOLDER

A frame holds the image points of both arms in all four views, their residuals, and the angles that the learner was sent
to, and as its action the angles that it was sent to next. Points that were not seen are 0, with a mask beside them.
"""

import sys
from collections.abc import Iterable

import numpy as np

try:
    from lerobot.datasets import LeRobotDataset  # 0.5 and newer
except ImportError:
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

from viewimit import Session, Settings

MOTIONS_A_SECOND = 1


def features(joints: int, points: int) -> dict[str, dict]:
    """What each frame holds, as LeRobot describes it."""
    names = [f"joint_{k}" for k in range(joints)]
    return {
        "observation.state": {"dtype": "float32", "shape": (joints,), "names": names},  # rad
        "observation.points.demonstrator": {"dtype": "float32", "shape": (points, 4), "names": ["point", "view"]},  # px
        "observation.points.own": {"dtype": "float32", "shape": (points, 4), "names": ["point", "view"]},  # px
        "observation.visible": {"dtype": "float32", "shape": (points, 4), "names": ["point", "view"]},  # 0 or 1
        "observation.residual": {"dtype": "float32", "shape": (points, 4), "names": ["point", "view"]},  # px
        "action": {"dtype": "float32", "shape": (joints,), "names": names},  # rad
    }


def add_episode(dataset: LeRobotDataset, session: Session) -> None:
    """Add a run, whose task is to imitate."""
    moments = list(session.history)
    for now, after in zip(moments, moments[1:]):
        dataset.add_frame(
            {
                "observation.state": now.commanded.astype(np.float32),
                "observation.points.demonstrator": np.nan_to_num(now.views.demo).astype(np.float32),
                "observation.points.own": np.nan_to_num(now.views.own).astype(np.float32),
                "observation.visible": now.views.visible.astype(np.float32),
                "observation.residual": np.nan_to_num(now.e).astype(np.float32),
                "action": after.commanded.astype(np.float32),
                "task": "imitate the demonstrator's posture",
            }
        )
    dataset.save_episode()


def main(folder: str, sessions: Iterable[Session]) -> LeRobotDataset:
    """Write the sessions, which have as many joints and points, into a folder that does not exist yet."""
    dataset = None
    for session in sessions:
        if dataset is None:
            described = features(len(session.snapshot.theta), len(session.snapshot.usable))
            dataset = LeRobotDataset.create(
                "viewimit/runs",
                MOTIONS_A_SECOND,
                described,
                root=folder,
                robot_type=session.scene.robot,
                use_videos=False,
            )
        add_episode(dataset, session)
    if dataset is None:
        raise ValueError("there is no session to write")
    dataset.finalize()
    return dataset


def runs(count: int) -> Iterable[Session]:
    """Run from random starts to random demonstrators."""
    rng, (low, high) = np.random.default_rng(0), np.transpose(Session().scene.range_deg)
    for demonstrator, start in rng.uniform(low, high, (count, 2, 2)):
        session = Session(Settings(demonstrator_deg=tuple(demonstrator), start_deg=tuple(start)))
        session.run()
        yield session


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    dataset = main(sys.argv[1], runs(5))
    print(f"{dataset.num_episodes} episodes of {dataset.num_frames} frames in {sys.argv[1]}")
