"""Two webcams side by side that see both arms, which wear printed square markers.

    python examples/webcams.py 0 1        the numbers of the left and of the right camera

Print the markers: viewimit markers. Stick number k on your arm and number 25 + k at the same place of the demonstrator,
k = 0 … 24: eight or more, on the base and on every link. Nothing is measured and nothing calibrated.
Needs OpenCV with cameras: pip install opencv-python, in place of opencv-python-headless.
"""

import sys

import cv2
import numpy as np

from viewimit import FourViews, Session
from viewimit.sensing.detection import FIRST_OF_DEMONSTRATOR, Fiducials

MARKERS, DEMONSTRATOR = 25, FIRST_OF_DEMONSTRATOR  # on each arm; what is added to the numbers on the demonstrator


class Webcams:
    """Eyes. left, right: as `cv2.VideoCapture`."""

    noise_px = 0.05  # what is left where pictures do not flicker: steps of a pixel's brightness

    def __init__(self, left, right):
        self.cameras, self.markers = (left, right), Fiducials("4x4_50")

    def look(self):
        l, r = (self.markers.detect(self.picture(camera)) for camera in self.cameras)
        own, demo = range(MARKERS), range(DEMONSTRATOR, DEMONSTRATOR + MARKERS)
        unseen = np.full(2, np.nan)
        return FourViews.from_images(*([seen.get(k, unseen) for k in ks] for ks in (demo, own) for seen in (l, r)))

    def picture(self, camera):
        taken, picture = camera.read()
        if not taken:
            raise SystemExit("a camera gives no picture")
        return picture


class ArmByHand:
    """Says where the joints should go, and waits until they are there. Put your robot's own interface here."""

    lower, upper = np.radians([-60, -70, 10]), np.radians([60, 20, 110])
    start = np.radians([-20, -20, 40])

    def move(self, theta):
        input(f"joints to {np.degrees(theta).round(1)} degrees, then Enter ")
        return theta


def main(arm, left, right):
    session = Session.of(arm, Webcams(left, right), frames=5)
    ended = session.run(each=lambda now: print(f"motion {now.motion}: E = {now.E:.3f} px², {now.usable.sum()} points"))
    print(f"{ended.status} at {np.degrees(ended.theta).round(1)} after {ended.motions} motions")
    return session


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(ArmByHand(), *(cv2.VideoCapture(int(number)) for number in sys.argv[1:3]))
