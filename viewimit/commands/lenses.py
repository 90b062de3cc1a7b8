"""Options for the lenses of a person's own cameras, and their distortion removed from tracked points."""

import argparse
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..estimation.views import FourViews
from ..geometry.distortion import LensDistortion
from ..options import BadInput, naming
from ..sensing.lens_files import CalibratedLens, read_lenses

CAMERAS = "left", "right"
COUNTS = 2, 4, 5  # of coefficients
NUMBERS = "FX,FY,CX,CY,K1,K2,P1,P2,K3"
BEYOND = 0.1  # of the points' extent, by which a lens's centre lies outside before it is mentioned

Floats = NDArray[np.float64]


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--undistort",
        metavar="K1,K2,P1,P2,K3",
        help="distortion of all cameras to remove from the points first, in OpenCV's order; P1,P2 and K3 may be left "
        "out (none)",
    )
    what = f"focal lengths and centre, px, perhaps with the distortion: {NUMBERS}; or a calibration file, FILE or "
    what += "FILE#CAMERA, of ROS, OpenCV, Kalibr or Anipose"
    parser.add_argument("--lens", metavar="LENS", help=f"of both cameras: {what}")
    for camera in CAMERAS:
        parser.add_argument(f"--lens-{camera}", metavar="LENS", help=f"of the {camera} camera, as --lens")


def without_distortion(args: argparse.Namespace, views: FourViews) -> FourViews:
    """The views without the distortion of the lenses, if the user knows that. Raises BadInput."""
    found = _lenses(args)
    if found is None:
        return views
    doubts: dict[str, None] = {}
    demo, own = [], []
    for k, (camera, (lens, option)) in enumerate(zip(CAMERAS, found)):
        of = slice(2 * k, 2 * k + 2)
        points = np.concatenate([bodies[..., of].reshape(-1, 2) for bodies in (views.demo, views.own)])
        doubts |= dict.fromkeys(f"{option}: {doubt}" for doubt in _doubts(lens, points))
        with naming(option):
            demo.append(_straightened(lens, views.demo[..., of], camera))
            own.append(_straightened(lens, views.own[..., of], camera))
    for doubt in doubts:
        print(f"viewimit evaluate: {doubt}", file=sys.stderr)
    return FourViews(np.concatenate(demo, -1), np.concatenate(own, -1), views.visible)


def _straightened(lens: CalibratedLens, image: Floats, camera: str) -> Floats:
    """(..., 2) px of a lens without distortion. Raises ValueError."""
    by = LensDistortion.of(*(lens.coefficients or (0.0, 0.0)))
    on_plane = (image - lens.centre) / lens.focal
    found = by.undistorted(on_plane)
    folded = np.isnan(found).any(-1) & np.isfinite(on_plane).all(-1)
    if folded.any():
        farthest = np.linalg.norm(on_plane[folded], axis=-1).max()
        raise ValueError(
            f"the lens shows nothing from {by.radial.max_distorted_radius:.3g} focal lengths on, where it folds its "
            f"image; a point of the {camera} camera is {farthest:.3g} from the centre"
        )
    return found * lens.focal + lens.centre


def _doubts(lens: CalibratedLens, points: Floats) -> Iterator[str]:
    """What speaks against a lens, (N, 2) px of its points given."""
    points = points[np.isfinite(points).all(-1)]
    if not len(points):
        return
    low, high, centre = points.min(0), points.max(0), np.array(lens.centre)
    size = 2 * centre if lens.size is None else np.array(lens.size)
    if (high > size * (1.0 if lens.size else 1 + BEYOND)).any():
        made = "of" if lens.size else "of about"
        yield (
            f"points lie as far as {high[0]:.0f},{high[1]:.0f}, and the lens is {made} pictures of "
            f"{size[0]:.0f} x {size[1]:.0f} px: calibrate it at the size of the tracked pictures"
        )
        return
    margin = BEYOND * (high - low)
    before, after = centre < low - margin, centre > high + margin
    sides = [word for word, is_so in zip(("right of", "below", "left of", "above"), (*before, *after)) if is_so]
    if sides:
        yield (
            f"all points lie {' and '.join(sides)} the lens's centre, {centre[0]:g},{centre[1]:g}: is it calibrated at "
            "another picture size?"
        )


def _lenses(args: argparse.Namespace) -> list[tuple[CalibratedLens, str]] | None:
    """The lenses of the left and the right camera with the options that name them, or None. Raises BadInput."""
    given = {camera: vars(args)[f"lens_{camera}"] for camera in CAMERAS}
    if args.lens is not None and any(given.values()):
        raise BadInput("--lens is of both cameras: leave it out, or --lens-left and --lens-right")
    if any(given.values()) and not all(given.values()):
        one = next(camera for camera in CAMERAS if given[camera])
        other = next(camera for camera in CAMERAS if not given[camera])
        raise BadInput(f"--lens-{one}: give --lens-{other} too, or --lens for both cameras")
    shared = _coefficients(args)
    if args.lens is None and not any(given.values()):
        if shared is not None:
            raise BadInput("--undistort and --lens go together: a distortion is about a centre, in focal lengths")
        return None
    if args.lens is not None:
        with naming("--lens"):
            found = [(lens, "--lens") for lens in _pair(args.lens)]
    else:
        found = []
        for camera in CAMERAS:
            with naming(f"--lens-{camera}"):
                found.append((_one(given[camera], camera), f"--lens-{camera}"))
    return [(_with_distortion(lens, shared, option), option) for lens, option in found]


def _with_distortion(lens: CalibratedLens, shared: tuple[float, ...] | None, option: str) -> CalibratedLens:
    if shared is not None and lens.coefficients is not None:
        raise BadInput(f"--undistort, {option}: both give a distortion: leave one out")
    if shared is None and lens.coefficients is None:
        raise BadInput(f"--undistort and {option} go together: the lens has no distortion; append it, {NUMBERS}")
    lens = lens if shared is None else replace(lens, coefficients=shared)
    with naming(option if shared is None else "--undistort"):
        LensDistortion.of(*(lens.coefficients or ()))
    return lens


def _coefficients(args: argparse.Namespace) -> tuple[float, ...] | None:
    """Those of --undistort. Raises BadInput."""
    if args.undistort is None:
        return None
    found = _numbers(args.undistort)
    if found is None or len(found) not in COUNTS:
        raise BadInput(
            f"--undistort: needs K1,K2 or K1,K2,P1,P2 or K1,K2,P1,P2,K3, such as -0.05,0.01, got {args.undistort!r}"
        )
    return found


def _numbers(text: str) -> tuple[float, ...] | None:
    """Finite ones, separated by commas; None for other text."""
    try:
        found = tuple(float(word) for word in text.split(","))
    except ValueError:
        return None
    return found if np.isfinite(found).all() else None


def _pair(text: str) -> list[CalibratedLens]:
    """One lens for both cameras, or the two of a file, the first of which is the left one's. Raises ValueError."""
    found = _read(text)
    if len(found) > len(CAMERAS):
        raise ValueError(
            f"{text} has {len(found)} cameras: name those of the pair by --lens-left {text}#{next(iter(found))} …"
        )
    if len(found) < len(CAMERAS):
        return 2 * list(found.values())
    left, right = found if not _is_of("right", next(iter(found))) else reversed(found)
    print(f"viewimit evaluate: --lens: {left} is the left camera, {right} the right one", file=sys.stderr)
    return [found[left], found[right]]


def _is_of(camera: str, name: str) -> bool:
    return camera in name.lower() or name.lower() == camera[0]


def _one(text: str, camera: str) -> CalibratedLens:
    """The lens of a camera. Raises ValueError."""
    found = _read(text)
    named = [name for name in found if _is_of(camera, name)]
    if len(found) > 1 and len(named) != 1:
        raise ValueError(f"{text} has several cameras, {', '.join(found)}: name one, {text}#{next(iter(found))}")
    return found[named[0]] if len(found) > 1 else next(iter(found.values()))


def _read(text: str) -> dict[str, CalibratedLens]:
    """The lenses of an option by the cameras' names: numbers, a file, or a camera of it. Raises OSError, ValueError."""
    numbers = _numbers(text)
    if numbers is not None:
        if len(numbers) - 4 not in (0, *COUNTS):
            raise ValueError(f"needs {NUMBERS}, of which K1 … may be left out, such as 600,600,320,240, got {text!r}")
        if min(numbers[:2]) <= 0:
            raise ValueError(f"focal lengths must be more than 0, got {text!r}")
        return {"": CalibratedLens((numbers[0], numbers[1]), (numbers[2], numbers[3]), numbers[4:] or None)}
    path, _, camera = text.partition("#") if not Path(text).exists() else (text, "", "")
    if not Path(path).exists() and "," in path:
        raise ValueError(f"needs {NUMBERS}, such as 600,600,320,240, or a file, got {text!r}")
    found = read_lenses(Path(path))
    if camera and camera not in found:
        raise ValueError(f"{path} has no camera {camera!r}; there are {', '.join(found)}")
    return {camera: found[camera]} if camera else found
