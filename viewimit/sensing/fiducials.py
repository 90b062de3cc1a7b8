"""Square markers of a printed dictionary, ArUco or AprilTag, told apart by their number in a picture, with OpenCV."""

import cv2
import numpy as np
from numpy.typing import NDArray

PREFIX = "DICT_"
PIXEL_MIDDLE = 0.5  # OpenCV has (0, 0) in the middle of the first pixel


def dictionary_names() -> list[str]:
    """Of OpenCV's dictionaries, such as 4X4_50 and APRILTAG_36H11."""
    return sorted({name.removeprefix(PREFIX).upper() for name in dir(cv2.aruco) if name.startswith(PREFIX)})


class Fiducials:
    """dictionary: of `dictionary_names`, in any case, with or without DICT_. Raises ValueError that names them all."""

    def __init__(self, dictionary: str):
        wanted = dictionary.upper().removeprefix(PREFIX)
        numbers = {name.removeprefix(PREFIX).upper(): name for name in dir(cv2.aruco) if name.startswith(PREFIX)}
        if wanted not in numbers:
            raise ValueError(f"no dictionary {dictionary!r}; there are {', '.join(dictionary_names())}")
        self.dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, numbers[wanted]))
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_CONTOUR  # six times as exact as SUBPIX
        self._detector = cv2.aruco.ArucoDetector(self.dictionary, parameters)

    def detect(self, picture: NDArray) -> dict[int, NDArray]:
        """picture: (height, width, 3) uint8 → by number the middle (2,) px of each marker, where its diagonals cross.

        A number that is seen twice is of two bodies, nobody knows which: it is left out. Pixel (i, j) covers j … j + 1,
        i … i + 1.
        """
        corners, numbers, _ = self._detector.detectMarkers(picture)
        found = [] if numbers is None else [int(number) for number in np.ravel(numbers)]
        once = {number for number in found if found.count(number) == 1}
        return {k: _middle(np.reshape(four, (4, 2))) + PIXEL_MIDDLE for k, four in zip(found, corners) if k in once}


def _middle(corners: NDArray) -> NDArray:
    """Where the diagonals cross, which is the middle in any perspective. corners: (4, 2), around → (2,)."""
    a, b, c, d = corners.astype(float)
    along = np.linalg.solve(np.stack([c - a, b - d], -1), b - a)
    return a + along[0] * (c - a)
