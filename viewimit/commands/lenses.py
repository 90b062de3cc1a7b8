"""Options for the lenses of a person's own cameras, and their distortion removed from tracked points."""

import argparse
import sys
from dataclasses import replace

import numpy as np

from ..estimation.views import FourViews
from ..geometry.distortion import LensDistortion
from ..options import BadInput, naming
from ..sensing.lens_files import COUNTS, NUMBERS, CalibratedLens, lenses_of, numbers_in

CAMERAS = "left", "right"


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
        doubts |= dict.fromkeys(f"{option}: {doubt}" for doubt in lens.doubts(points))
        with naming(option):
            demo.append(lens.straightened(views.demo[..., of], camera))
            own.append(lens.straightened(views.own[..., of], camera))
    for doubt in doubts:
        print(f"viewimit evaluate: {doubt}", file=sys.stderr)
    return FourViews(np.concatenate(demo, -1), np.concatenate(own, -1), views.visible)


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
    found = numbers_in(args.undistort)
    if found is None or len(found) not in COUNTS:
        raise BadInput(
            f"--undistort: needs K1,K2 or K1,K2,P1,P2 or K1,K2,P1,P2,K3, such as -0.05,0.01, got {args.undistort!r}"
        )
    return found


def _pair(text: str) -> list[CalibratedLens]:
    """One lens for both cameras, or the two of a file, the first of which is the left one's. Raises ValueError."""
    found = lenses_of(text)
    if len(found) > len(CAMERAS):
        raise ValueError(
            f"{text} has {len(found)} cameras: name those of the pair by --lens-left {text}#{next(iter(found))} …"
        )
    if len(found) < len(CAMERAS):
        return 2 * list(found.values())
    left, right = found if not _is_of("right", next(iter(found))) else reversed(found)
    print(f"viewimit evaluate: --lens: {left} is the left camera, {right} the right one", file=sys.stderr)
    return [found[left], found[right]]


def _one(text: str, camera: str) -> CalibratedLens:
    """The lens of a camera. Raises ValueError."""
    found = lenses_of(text)
    named = [name for name in found if _is_of(camera, name)]
    if len(found) > 1 and len(named) != 1:
        raise ValueError(f"{text} has several cameras, {', '.join(found)}: name one, {text}#{next(iter(found))}")
    name = named[0] if len(found) > 1 else next(iter(found))
    other = CAMERAS[1 - CAMERAS.index(camera)]
    if _is_of(other, name) and not _is_of(camera, name):
        print(f"viewimit evaluate: --lens-{camera}: the camera is named {name}: are they exchanged?", file=sys.stderr)
    return found[name]


def _is_of(camera: str, name: str) -> bool:
    return camera in name.lower() or name.lower() == camera[0]
