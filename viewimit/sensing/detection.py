"""Coloured balls found in a picture, with OpenCV: their middles to a fraction of a pixel, told apart by their hue.

A pixel's chroma is the part of its colour that is not grey, a vector in a plane: its angle, the hue, is the paint's
own, whatever falls on it of a white light, and stays where the paint is mixed with grey at an edge, where its length
tells how much of the pixel the paint covers. Light that has a colour itself shifts it.
"""

import struct
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from .files import MEGABYTE, require_file

PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp")
MOST_BYTES = 65_536 * MEGABYTE  # of a video
MOST_PIXELS = 25_000_000  # of a picture, a dozen floats each
LEAST_CHROMA = 24.0  # of 255: paler is grey
LEAST_AREA_PX = 6.0
HUE_SHARE = 0.5  # of the way to the next marker's hue, at most
ROUND = 0.87  # shorter axis over longer, at least: else something hides a part of it
SMALL = 0.45  # of the picture's median blob: a round remainder of a hidden one
ALIKE, UNLIKE = 0.15, 3.0  # share of the area; standard deviations of that share, by which one may differ
TO_NORMAL = 1.4826  # from the median of |x| to the standard deviation
HUES_A_DEGREE = 4
PIXEL_VARIANCE = 1 / 12  # px², of a pixel's own width
NEIGHBOURS = np.ones((3, 3), np.uint8)


@dataclass(frozen=True)
class Detections:
    """points: (N, 2) px, NaN where not found; confidence: (N,) in 0 … 1, how round it is, 0 where not found; area: (N,)
    px², of what is seen of it, NaN where not found."""

    points: NDArray
    confidence: NDArray
    area: NDArray

    @property
    def found(self) -> NDArray:
        """(N,) bool"""
        return self.confidence > 0

    def without(self, those: NDArray) -> "Detections":
        """those: (N,) bool."""
        return Detections(
            np.where(those[:, None], np.nan, self.points),
            np.where(those, 0.0, self.confidence),
            np.where(those, np.nan, self.area),
        )


def detect(picture: NDArray, hue_deg: ArrayLike, middle: float = 1.0) -> Detections:
    """picture: (height, width, 3) uint8 red, green, blue; hue_deg: (N,) of the markers → their middles.

    middle: share of the width that is searched, around the centre: a head that has turned to a body has it there, and
    another one beside it. Of several round blobs of one hue the largest counts. All markers are about equally large.
    Pixel (i, j) covers j … j + 1, i … i + 1, so that its middle is at (j + 0.5, i + 0.5).
    """
    hue_deg = np.asarray(hue_deg, float)
    points, confidence = np.full((len(hue_deg), 2), np.nan), np.zeros(len(hue_deg))
    count_px, covered = np.zeros(len(hue_deg)), np.full(len(hue_deg), np.nan)
    (left, top), (a, b) = _coloured_part(picture, middle)
    chroma = np.hypot(a, b)
    which = _marker_by_hue(hue_deg)[np.round(np.degrees(np.arctan2(b, a)) * HUES_A_DEGREE).astype(int)]
    which[chroma < LEAST_CHROMA] = -1
    for marker in np.unique(which[which >= 0]):
        count, labels, parts, _ = cv2.connectedComponentsWithStats((which == marker).astype(np.uint8), connectivity=8)
        for k in range(1, count):
            x, y, width, height, pixels = parts[k]
            if pixels < max(LEAST_AREA_PX, count_px[marker]):
                continue
            part = slice(y, y + height), slice(x, x + width)
            centre, roundness, area = _disc(np.where(labels[part] == k, chroma[part], 0.0))
            if roundness >= ROUND:
                count_px[marker], covered[marker] = pixels, area
                points[marker], confidence[marker] = centre + (left + x, top + y), roundness
    found = Detections(points, confidence, covered)
    if not count_px.any():
        return found
    return found.without(count_px < SMALL * np.median(count_px[count_px > 0]))


def as_large_in_both(left: Detections, right: Detections) -> tuple[Detections, Detections]:
    """Two pictures of the same balls without those that are smaller in one of them than the others tell: from several
    sides something may hide parts of a ball so that it stays round. It is taken out where it is smaller."""
    ratio = np.log(right.area / left.area)
    both = np.isfinite(ratio)
    if not both.any():
        return left, right
    away = np.nan_to_num(ratio - np.median(ratio[both]))
    most = max(ALIKE, UNLIKE * TO_NORMAL * float(np.median(np.abs(away[both]))))
    return left.without(away > most), right.without(away < -most)


def pictures(path: Path) -> Iterator[NDArray]:
    """(height, width, 3) uint8 red, green, blue: a picture, or the frames of a video. Raises ValueError, OSError."""
    require_file(path, MOST_BYTES)
    if path.suffix.lower() in PICTURES:
        _require_size(path)
        picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
        if picture is None:
            raise ValueError(f"{path}: not a picture that OpenCV reads")
        yield cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
        return
    video, count = cv2.VideoCapture(str(path)), 0
    _require_pixels(path, int(video.get(cv2.CAP_PROP_FRAME_WIDTH)), int(video.get(cv2.CAP_PROP_FRAME_HEIGHT)))
    while (read := video.read())[0]:
        count += 1
        yield cv2.cvtColor(read[1], cv2.COLOR_BGR2RGB)
    video.release()
    if count == 0:
        raise ValueError(f"{path}: not a picture or video that OpenCV reads")


def _require_size(path: Path) -> None:
    """Before a picture is unpacked. Raises ValueError."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow's own bound is another
            with Image.open(path) as picture:
                size = picture.size
    except Image.DecompressionBombError:
        raise ValueError(f"{path}: a picture of more than {MOST_PIXELS / 1e6:g} megapixels: make it smaller") from None
    except (OSError, ValueError, SyntaxError, TypeError, struct.error):
        raise ValueError(f"{path}: not a picture that OpenCV reads") from None
    _require_pixels(path, *size)


def _require_pixels(path: Path, width: int, height: int) -> None:
    if width * height > MOST_PIXELS:
        size = f"{width * height / 1e6:.0f} megapixels, more than {MOST_PIXELS / 1e6:g}"
        raise ValueError(f"{path}: a picture of {size}: make it smaller")


def _coloured_part(picture: NDArray, middle: float) -> tuple[tuple[int, int], tuple[NDArray, NDArray]]:
    """Upper left corner of the part that is not grey, and the chroma of its pixels: towards red, towards green."""
    width = picture.shape[1]
    first = round((1 - middle) / 2 * width)
    searched = picture[:, first : width - first]
    red, green, blue = np.moveaxis(searched, -1, 0)
    spread = np.maximum(np.maximum(red, green), blue) - np.minimum(np.minimum(red, green), blue)
    x, y, w, h = cv2.boundingRect((spread >= LEAST_CHROMA / 2).astype(np.uint8))
    red, green, blue = np.moveaxis(searched[y : y + h, x : x + w].astype(np.float32), -1, 0)
    return (first + x, y), (red - (green + blue) / 2, np.sqrt(0.75) * (green - blue))


def _marker_by_hue(hue_deg: NDArray) -> NDArray:
    """Index of the marker with the nearest hue, -1 where none is near enough: of 0°, 1°/HUES_A_DEGREE … 360°."""
    hue = np.arange(360 * HUES_A_DEGREE) / HUES_A_DEGREE
    away = np.abs((hue[..., None] - hue_deg + 180) % 360 - 180)
    apart = np.abs((hue_deg[:, None] - hue_deg + 180) % 360 - 180)
    np.fill_diagonal(apart, 180.0)
    nearest = away.argmin(-1)
    close = np.take_along_axis(away, nearest[..., None], -1)[..., 0] <= HUE_SHARE * apart.min(-1)[nearest]
    return np.where(close, nearest, -1)


def _disc(chroma: NDArray) -> tuple[NDArray, float, float]:
    """Of a blob, chroma 0 outside: its middle (x, y) px, its shorter axis over its longer, by its moments, and its area
    px²."""
    inside = np.pad((chroma > 0).astype(np.uint8), 1)
    interior = cv2.erode(inside, NEIGHBOURS)[1:-1, 1:-1] > 0
    brightest = cv2.dilate(chroma, NEIGHBOURS)
    covered = np.where(interior, 1.0, chroma / np.maximum(brightest, 1.0))
    area = covered.sum()
    x, y = np.arange(chroma.shape[1]) + 0.5, np.arange(chroma.shape[0]) + 0.5
    weight_x, weight_y = covered.sum(0) / area, covered.sum(1) / area
    centre = np.array([weight_x @ x, weight_y @ y])
    x, y = x - centre[0], y - centre[1]
    xx, yy, xy = weight_x @ x**2 + PIXEL_VARIANCE, weight_y @ y**2 + PIXEL_VARIANCE, y @ covered @ x / area
    mean, half = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    return centre, float(np.sqrt((mean - half) / (mean + half))), float(area)


# Square markers of a printed dictionary, ArUco or AprilTag, told apart by their number in a picture, with OpenCV.

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
