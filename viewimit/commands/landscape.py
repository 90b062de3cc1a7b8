"""viewimit landscape: E over the range of the two moving joints."""

import argparse
import sys
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from .. import options
from ..analysis.landscape import Landscape, conflict_at, landscape, seen_from
from ..analysis.results import figure, posture
from ..drawing.export import figures
from ..drawing.landscape import LandscapePicture
from ..drawing.plots import describe_settings
from ..estimation.transfers import TRANSFERS, default_transfer
from ..loop.session import Session
from ..loop.snapshot import Snapshot
from ..simulation.scene import Scene
from .json_output import print_json

TABLES = (".npz", ".csv")
TITLE = "E over the postures of the learner"


def add_options(parser: argparse.ArgumentParser) -> None:
    names = (*options.SCENE, "demonstrator_deg", "transfer", "rectify", *options.SIGHT, "sensor")
    options.add_settings(parser, *names, transfer=f"{', '.join(TRANSFERS)} ({options.DEFAULT_TRANSFER})")
    parser.add_argument("--step-deg", type=options.between(float, 0.1, 45), help="of the grid (1, camera images 10)")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write it as .npz, .csv, .svg, .png or .pdf")
    options.add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    if args.out:
        with options.naming("--out"):
            if args.out.suffix.lower() not in TABLES + figures.PICTURES:
                known = ", ".join(TABLES + figures.PICTURES)
                raise ValueError(f"{args.out}: unknown extension {args.out.suffix.lower()!r}; there are {known}")
            figures.require_renderer(args.out, ".svg")
    settings = options.settings_from(args)
    session = Session(settings)
    if args.transfer is None:
        settings = msgspec.structs.replace(settings, transfer=default_transfer(len(session.snapshot.usable)))
        session.change(transfer=settings.transfer)
    with options.naming("--scene, --joints"):
        found = landscape(session, args.step_deg)
    now = session.snapshot
    (there,) = conflict_at(*seen_from(session.eyes, now), now.theta_demo[:, None])
    if args.out:
        with options.naming("--out"):
            _write(args.out, found, session.scene, now)
        print(f"written to {args.out}", file=sys.stderr)
    nowhere = bool(np.isnan(found.E).all())
    result = {
        "demonstrator_deg": np.degrees(now.theta_demo),
        "transfer": session.settings.transfer,
        "grid": found.E.shape,
        "minimum_deg": np.degrees(found.minimum),
        "E_min": np.nan if nowhere else np.nanmin(found.E),
        "E_at_demonstrator": there[0],
        "E_max": np.nan if nowhere else np.nanmax(found.E),
        "local_minima": np.degrees(found.local_minima()),
        "basin_fraction": found.basin_fraction(),
    }
    if args.json:
        print_json(args, result, settings)
    else:
        _report(result)
    if nowhere:
        print("viewimit landscape: too few points are seen in all four images, at every posture", file=sys.stderr)
    return options.MISSED if nowhere else options.DONE


def _report(result: dict) -> None:
    rows, columns = result["grid"]
    minima, basin = len(result["local_minima"]), result["basin_fraction"]
    print(f"E of {result['transfer']} over {rows} x {columns} postures")
    least, there, most = (figure(result[name], ".4g", " px²") for name in ("E_min", "E_at_demonstrator", "E_max"))
    print(f"minimum       {least} at {posture(result['minimum_deg'])}")
    print(f"demonstrator  {there} at {posture(result['demonstrator_deg'])}")
    print(f"largest       {most}")
    print(f"local minima  {minima}; steepest descent ends at the lowest from {basin:.1%} of the postures")


def _write(path: Path, landscape: Landscape, scene: Scene, snapshot: Snapshot) -> None:
    """Write by extension. snapshot: the moment whose demonstrator and settings it is of. Raises OSError."""
    first, second = (np.degrees(axis) for axis in landscape.axes)
    names = [f"theta{joint}_deg" for joint in scene.moving_joints]
    if path.suffix.lower() == ".npz":
        columns: dict[str, Any] = dict(zip(names, (first, second)))
        with path.open("wb") as file:  # numpy would add the extension to a name that ends in .NPZ
            np.savez(file, E=landscape.E, demonstrator_deg=np.degrees(snapshot.theta_demo), **columns)
    elif path.suffix.lower() == ".csv":
        rows = np.stack([*np.meshgrid(first, second, indexing="ij"), landscape.E], -1).reshape(-1, 3)
        np.savetxt(path, rows, "%.10g", ",", header=",".join([*names, "E_px2"]), comments="")
    else:
        picture = LandscapePicture(landscape, scene, snapshot, contours="E in px²")
        drawing = picture.draw_alone(snapshot.settings)
        figures.write(path, figures.standalone(drawing, TITLE, describe_settings(snapshot.settings)))
