"""A demonstrator that is a video: its points were tracked in the left and the right picture, and the arm follows them.

    python examples/video_demonstrator.py left.h5 right.h5

The files are those of any tracker that `viewimit.sensing.tracks` reads. Point 0 of the video is point 0 of the
learner, and so on. Put your own arm and eyes in place of the fake robot; the cameras are those that took the video.
"""

import sys
from pathlib import Path

import numpy as np
from fake_robot import FakeRobot

from viewimit import FourViews, Session
from viewimit.sensing.tracks import read_view


class VideoDemonstrator:
    """Eyes: the learner as `eyes` see it now, beside the demonstrator as it is in one frame of the video."""

    def __init__(self, eyes, left, right):
        self.eyes, self.noise_px, self.frame = eyes, eyes.noise_px, 0
        self.videos = one, other = read_view(Path(left)), read_view(Path(right))
        self.frames = np.intersect1d(one.frames, other.frames)

    def look(self):
        now, wanted = self.eyes.look(), self.frames[self.frame]
        own = [
            np.where(seen[:, None], view, np.nan)
            for view, seen in ((now.own_left, now.visible[:, 2]), (now.own_right, now.visible[:, 3]))
        ]
        demo = np.full((2, len(now.own), 2), np.nan)
        for image, video in zip(demo, self.videos):
            image[[int(name) for name in video.points]] = video.above_confidence(0.6)[
                np.searchsorted(video.frames, wanted)
            ]
        return FourViews.from_images(*demo, *own)


def main(arm, eyes, left, right):
    video = VideoDemonstrator(eyes, left, right)
    session = Session.of(arm, video, frames=1)
    ended = session.run(100)
    print(f"first frame: {ended.status} at {np.degrees(ended.theta).round(1)} after {ended.motions} motions")
    followed = [ended.theta]
    for frame in range(1, len(video.frames)):
        video.frame = frame
        session.look()
        session.step()
        followed.append(session.snapshot.theta)
    print(f"last frame: at {np.degrees(followed[-1]).round(1)}, where it expects the next one")
    return np.array(followed)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    robot = FakeRobot(demonstrator_deg=(0, 0, 60))
    main(robot, robot, *sys.argv[1:3])
