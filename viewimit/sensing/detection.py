"""Detect markers in a picture: coloured balls by their hue, and square markers by their number.

The balls need numpy alone. OpenCV, an extra, reads files and finds square markers.

The chroma of a pixel is the coloured part of it, a vector in a plane. Its angle, the hue, belongs to the paint. White
light of any strength does not change it, and neither does mixing with grey at an edge. There its length says how much
of the pixel the paint covers. Coloured light shifts the hue.

Pixel (i, j) covers j … j + 1 and i … i + 1, so its centre is at (j + 0.5, i + 0.5).
"""

import struct
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from ..geometry.arrays import Floats
from ..geometry.components import connected_components
from .files import MEGABYTE, require_file

SEVERAL = (".tif", ".tiff", ".webp")  # which may hold several pictures
PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp")
MAX_BYTES = 65_536 * MEGABYTE  # of a video
MAX_PIXELS = 25_000_000  # of a picture: a dozen floats each
MIN_CHROMA = 24.0  # of 255: paler pixels count as grey
MIN_AREA_PX = 6.0
MAX_HUE_FRACTION = 0.5  # of the way to the next marker's hue
MIN_ROUNDNESS = 0.87  # shorter axis over longer: below, something hides a part of the ball
MIN_MEDIAN_FRACTION = 0.45  # of the median blob's area: below, a blob is the round rest of a hidden ball
AREA_TOL, AREA_SIGMA = 0.15, 3.0  # accepted difference of areas in two pictures: relative, in standard deviations
NOT_ROUND, TOO_SMALL = "it is not round: something may hide a part", "it is far smaller than the others"
TWO_BALLS = "two balls have its hue: the larger one is taken"
MAD_TO_STD = 1.4826  # from the median of |x| to the standard deviation
HUES_PER_DEGREE = 4
PIXEL_VARIANCE = 1 / 12  # of a uniform distribution over one pixel [px²]
FIRST_OF_DEMONSTRATOR = 25  # number of its marker where the learner wears number 0, if both arms are in one picture
OPENCV_OFFSET_PX = 0.5  # OpenCV has (0, 0) at the centre of the first pixel

Picture = NDArray[np.uint8]


@dataclass(frozen=True)
class Detections:
    """Markers found in one picture."""

    points: Floats  # (N, 2) centres [px], NaN if not found
    confidence: Floats  # (N,) roundness in 0 … 1, 0 if not found
    area: Floats  # (N,) visible area [px²], NaN if not found
    left_out: Mapping[int, str] = field(default_factory=dict)  # why, by marker: blobs that are not taken

    @property
    def found(self) -> NDArray[np.bool_]:
        """(N,) whether a marker was found."""
        return self.confidence > 0

    def without(self, rejected: NDArray[np.bool_]) -> "Detections":
        """Return the detections without the rejected ones, (N,)."""
        return Detections(
            np.where(rejected[:, None], np.nan, self.points),
            np.where(rejected, 0.0, self.confidence),
            np.where(rejected, np.nan, self.area),
            self.left_out,
        )


def detect(picture: Picture, hue_deg: ArrayLike, middle: float = 1.0) -> Detections:
    """Find the centres of coloured balls, all about equally large: of several round blobs of one hue, the largest.

    picture: (height, width, 3) RGB; hue_deg: (N,), of the balls; middle: fraction of the width that is searched, around
    the centre. A head that has turned to a body has it there, and another body beside it.
    """
    hue_deg = np.asarray(hue_deg, float)
    points, confidence = np.full((len(hue_deg), 2), np.nan), np.zeros(len(hue_deg))
    count_px, covered = np.zeros(len(hue_deg)), np.full(len(hue_deg), np.nan)
    (left, top), (a, b) = _coloured_part(picture, middle)
    chroma, left_out = np.hypot(a, b), dict[int, str]()
    which = _marker_by_hue(hue_deg)[np.round(np.degrees(np.arctan2(b, a)) * HUES_PER_DEGREE).astype(int)]
    which[chroma < MIN_CHROMA] = -1
    for marker, part, inside in _blobs(which):
        pixels = int(inside.sum())
        if pixels < max(MIN_AREA_PX, MIN_MEDIAN_FRACTION * count_px[marker]):
            continue
        centre, roundness, area = _disc(np.where(inside, chroma[part], 0.0))
        if roundness < MIN_ROUNDNESS:
            left_out.setdefault(marker, NOT_ROUND)
            continue
        if min(pixels, count_px[marker]) > MIN_MEDIAN_FRACTION * max(pixels, count_px[marker]):
            left_out[marker] = TWO_BALLS
        if pixels >= count_px[marker]:
            count_px[marker], covered[marker] = pixels, area
            points[marker] = centre + (left + part[1].start, top + part[0].start)
            confidence[marker] = roundness
    small = count_px < MIN_MEDIAN_FRACTION * np.median(count_px[count_px > 0]) if count_px.any() else count_px > 0
    left_out |= {marker: TOO_SMALL for marker in np.flatnonzero(small & (count_px > 0)).tolist()}
    reasons = {marker: why for marker, why in left_out.items() if why != NOT_ROUND or not count_px[marker]}
    return Detections(points, confidence, covered, reasons).without(small)


def reject_partly_hidden(left: Detections, right: Detections) -> tuple[Detections, Detections]:
    """Remove each ball that is too small in one of two pictures, relative to the other balls, from that picture.

    An object may hide parts of a ball on several sides, so that the rest looks round.
    """
    ratio = np.log(right.area / left.area)
    both = np.isfinite(ratio)
    if not both.any():
        return left, right
    difference = np.nan_to_num(ratio - np.median(ratio[both]))
    limit = max(AREA_TOL, AREA_SIGMA * MAD_TO_STD * float(np.median(np.abs(difference[both]))))
    return left.without(difference > limit), right.without(difference < -limit)


def read_pictures(path: Path) -> Iterator[Picture]:
    """Read a picture, or the frames of a video, each (height, width, 3) in RGB. Raises ValueError, OSError."""
    import cv2

    require_file(path, MAX_BYTES)
    if path.suffix.lower() in PICTURES:
        _require_pixels(path, *_picture_size(path))
        pages = max(cv2.imcount(str(path), cv2.IMREAD_COLOR), 1) if path.suffix.lower() in SEVERAL else 1
        for page in range(pages):
            read_all, found = cv2.imreadmulti(str(path), page, 1, flags=cv2.IMREAD_COLOR) if pages > 1 else (True, ())
            picture = found[0] if pages > 1 and read_all and len(found) else cv2.imread(str(path), cv2.IMREAD_COLOR)
            if picture is None:
                raise ValueError(f"{path}: not a picture that OpenCV reads")
            yield np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), np.uint8)
        return
    video, count = cv2.VideoCapture(str(path)), 0
    _require_pixels(path, int(video.get(cv2.CAP_PROP_FRAME_WIDTH)), int(video.get(cv2.CAP_PROP_FRAME_HEIGHT)))
    while (read := video.read())[0]:
        count += 1
        yield np.asarray(cv2.cvtColor(read[1], cv2.COLOR_BGR2RGB), np.uint8)
    video.release()
    if count == 0:
        raise ValueError(f"{path}: not a picture or video that OpenCV reads")


def frame_rate(path: Path) -> float | None:
    """Return how many frames a video shows in a second; None for a picture, and for a video that does not say."""
    import cv2

    rate = 0.0 if path.suffix.lower() in PICTURES else float(cv2.VideoCapture(str(path)).get(cv2.CAP_PROP_FPS))
    return rate if 0 < rate < np.inf else None


def _picture_size(path: Path) -> tuple[int, int]:
    """Width and height of a picture, before it is decompressed. Raises ValueError."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow has a bound of its own
            with Image.open(path) as picture:
                return picture.size
    except Image.DecompressionBombError:
        raise ValueError(f"{path}: a picture of more than {MAX_PIXELS / 1e6:g} megapixels: make it smaller") from None
    except (OSError, ValueError, SyntaxError, TypeError, struct.error):
        raise ValueError(f"{path}: not a picture that OpenCV reads") from None


def _require_pixels(path: Path, width: int, height: int) -> None:
    if width * height > MAX_PIXELS:
        size = f"{width * height / 1e6:.0f} megapixels, more than {MAX_PIXELS / 1e6:g}"
        raise ValueError(f"{path}: a picture of {size}: make it smaller")


def _coloured_part(picture: Picture, middle: float) -> tuple[tuple[int, int], tuple[Floats, Floats]]:
    """Upper left corner of the bounding box of the coloured pixels, and their chroma: towards red, towards green."""
    width = picture.shape[1]
    first = round((1 - middle) / 2 * width)
    searched = picture[:, first : width - first]
    red, green, blue = np.moveaxis(searched, -1, 0)
    spread = np.maximum(np.maximum(red, green), blue) - np.minimum(np.minimum(red, green), blue)
    coloured = spread >= MIN_CHROMA / 2
    rows, columns = (hit_range(coloured.any(axis)) for axis in (1, 0))
    red, green, blue = np.moveaxis(searched[rows, columns].astype(np.float32), -1, 0)
    return (first + columns.start, rows.start), (red - (green + blue) / 2, np.sqrt(0.75) * (green - blue))


def hit_range(hit: NDArray[np.bool_]) -> slice:
    """Return the slice from the first to the last True; an empty slice if there is none."""
    where = np.flatnonzero(hit)
    return slice(int(where[0]), int(where[-1]) + 1) if len(where) else slice(0, 0)


def _blobs(which: NDArray[np.int_]) -> Iterator[tuple[int, tuple[slice, slice], NDArray[np.bool_]]]:
    """Find connected pixels of one number, neighbours at corners included; negative ones belong to no blob.

    Yields the number, the bounding box, and which of its pixels belong to the blob. Runs of pixels in a row are joined
    with the runs that they touch in the next row.
    """
    width = which.shape[1] + 2
    flat = np.pad(which, 1, constant_values=-1).ravel()  # no run goes on in the next row
    run = np.cumsum(np.diff(flat, prepend=-1) != 0)
    pixel = np.flatnonzero(flat >= 0)
    touching = []
    for below in (width - 1, width, width + 1):
        upper = pixel[flat[pixel] == flat[pixel + below]]
        touching.append(np.stack([run[upper], run[upper + below]]))
    owner = connected_components(run[-1] + 1, *np.concatenate(touching, 1))[run[pixel]]
    order = np.argsort(owner, kind="stable")
    owner, (row, column) = owner[order], np.divmod(pixel[order], width) - np.ones((2, 1), int)
    for begin, end in pairwise([*np.flatnonzero(np.diff(owner, prepend=-1)), len(owner)]):
        y, x = row[begin:end], column[begin:end]
        part = slice(int(y[0]), int(y[-1]) + 1), slice(int(x.min()), int(x.max()) + 1)
        inside = np.zeros((part[0].stop - part[0].start, part[1].stop - part[1].start), bool)
        inside[y - part[0].start, x - part[1].start] = True
        yield int(which[y[0], x[0]]), part, inside


def _marker_by_hue(hue_deg: Floats) -> NDArray[np.int_]:
    """Index of the marker of the nearest hue, or -1 without a near one, for the hues 0°, 1°/HUES_PER_DEGREE … 360°."""
    hue = np.arange(360 * HUES_PER_DEGREE) / HUES_PER_DEGREE
    difference = np.abs((hue[..., None] - hue_deg + 180) % 360 - 180)
    separation = np.abs((hue_deg[:, None] - hue_deg + 180) % 360 - 180)
    np.fill_diagonal(separation, 180.0)
    nearest = difference.argmin(-1)
    return np.where(difference.min(-1) <= MAX_HUE_FRACTION * separation.min(-1)[nearest], nearest, -1)


def _disc(chroma: Floats) -> tuple[Floats, float, float]:
    """Centre (x, y) [px], roundness (shorter axis over longer) and area [px²] of a blob, from its second moments.

    chroma: 0 outside the blob.
    """
    interior, brightest = _of_neighbourhood(chroma > 0, np.minimum), _of_neighbourhood(chroma, np.maximum)
    covered = np.where(interior, 1.0, chroma / np.maximum(brightest, 1.0))
    area = covered.sum()
    x, y = np.arange(chroma.shape[1]) + 0.5, np.arange(chroma.shape[0]) + 0.5
    weight_x, weight_y = covered.sum(0) / area, covered.sum(1) / area
    centre = np.array([weight_x @ x, weight_y @ y])
    x, y = x - centre[0], y - centre[1]
    xx, yy, xy = weight_x @ x**2 + PIXEL_VARIANCE, weight_y @ y**2 + PIXEL_VARIANCE, y @ covered @ x / area
    mean, half = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    return centre, float(np.sqrt((mean - half) / (mean + half))), float(area)


def _of_neighbourhood(values: NDArray[Any], pick: np.ufunc) -> NDArray[Any]:
    """Smallest or largest of each pixel and its eight neighbours, 0 beyond the border."""
    padded = np.pad(values, 1)
    rows = pick(pick(padded[:-2], padded[1:-1]), padded[2:])
    return pick(pick(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])


@cache
def _dictionaries() -> dict[str, str]:
    """Names in OpenCV of its dictionaries of square markers, by what users call them."""
    import cv2

    return {name.removeprefix("DICT_").upper(): name for name in dir(cv2.aruco) if name.startswith("DICT_")}


def dictionary_names() -> list[str]:
    """Return the names of OpenCV's dictionaries, such as 4X4_50 and APRILTAG_36H11."""
    return sorted(_dictionaries())


class Fiducials:
    """Detector of printed square markers, ArUco or AprilTag.

    dictionary: of `dictionary_names`, in any case, with or without DICT_. Raises ValueError that lists them.
    """

    def __init__(self, dictionary: str):
        import cv2

        name = _dictionaries().get(dictionary.upper().removeprefix("DICT_"))
        if name is None:
            raise ValueError(f"no dictionary {dictionary!r}; there are {', '.join(dictionary_names())}")
        self.name = name.removeprefix("DICT_")
        self.dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_CONTOUR  # six times as exact as SUBPIX
        self._detector = cv2.aruco.ArucoDetector(self.dictionary, parameters)

    def cells(self, number: int, side: int) -> NDArray[np.bool_]:
        """Return which cells of a printed marker are white, (side, side), with one white cell around it, as the
        detector needs. side: cells of the paper. Raises ValueError for a number that the dictionary does not have."""
        import cv2

        count = len(self.dictionary.bytesList)
        if not 0 <= number < count:
            raise ValueError(f"no marker {number}: {self.name} has 0 … {count - 1}")
        marker = self.dictionary.markerSize + 2  # with its black rim
        rim = max(side - marker, 0) // 2
        return np.pad(cv2.aruco.generateImageMarker(self.dictionary, number, marker) > 0, rim, constant_values=True)

    def detect(self, picture: Picture) -> dict[int, Floats]:
        """Return the centre of each marker, (2,) px, by its number. A number that appears twice is left out."""
        return {number: places[0] for number, places in self.detect_all(picture).items() if len(places) == 1}

    def detect_all(self, picture: Picture) -> dict[int, list[Floats]]:
        """Return the centres of all markers, (2,) px each, by their number."""
        corners, numbers, _ = self._detector.detectMarkers(picture)
        found: dict[int, list[Floats]] = {}
        for number, four in zip([] if numbers is None else [int(number) for number in np.ravel(numbers)], corners):
            place = _diagonal_crossing(np.reshape(four, (4, 2))) + OPENCV_OFFSET_PX
            found.setdefault(number, []).append(place)
        return found


def _diagonal_crossing(corners: NDArray[np.float32]) -> Floats:
    """Crossing of the diagonals, which is the square's centre in any perspective: (4, 2) in order -> (2,) px."""
    a, b, c, d = corners.astype(float)
    along = np.linalg.solve(np.stack([c - a, b - d], -1), b - a)
    return a + along[0] * (c - a)
