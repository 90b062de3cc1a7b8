"""viewimit rehearse: the learner records images of its own body in a calibration file."""

import argparse
import sys
from pathlib import Path

import msgspec
import numpy as np

from .. import options
from ..geometry.affine import MIN_POINTS
from ..loop.codegen import as_imitation
from ..loop.self_calibration import DEFAULT_POSTURES, MIN_POSTURES
from ..loop.session import Session
from ..loop.settings import SAFETY, Settings, disturbances
from ..sensing.files import escape
from ..simulation.disturbances import ImageDisturbance
from .json_output import print_json

MAX_POSTURES = 200
EXTRA_POSTURES = 3  # beside one for each joint, which turns it alone


def add_options(parser: argparse.ArgumentParser) -> None:
    sight = (*disturbances(ImageDisturbance), "frames", "seed", "undistort", "sensor", "dynamics")
    options.add_settings(parser, *options.SCENE, *sight, *options.ARM, *SAFETY, defaults=Settings())
    number, reach = options.between(int, MIN_POSTURES, MAX_POSTURES), options.between(float, 1.0, 360.0)
    parser.add_argument(
        "--postures",
        type=number,
        default=DEFAULT_POSTURES,
        metavar="K",
        help="number of postures, drawn with --seed (%(default)s)",
    )
    parser.add_argument(
        "--within", type=reach, metavar="DEG", help="largest distance of a joint from its start (the whole workspace)"
    )
    parser.add_argument(
        "--out", type=Path, required=True, metavar="FILE", help="write the calibration to this .npz file"
    )
    options.add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    if args.out.suffix.lower() != ".npz":
        raise options.BadInput(f"--out: {args.out}: unknown extension {args.out.suffix!r}; there is .npz")
    settings = options.settings_from(args, Settings())
    session = Session(settings)
    joints = len(session.scene.moving_joints)
    if args.postures < joints + EXTRA_POSTURES:
        raise options.BadInput(
            f"--postures: {joints} joints need {joints + EXTRA_POSTURES} or more, got {args.postures}"
        )
    body = session.calibrate(args.postures, settings.seed, args.within)
    with options.naming("--out"):
        body.save(args.out)
    print(f"written to {args.out}", file=sys.stderr)
    usable = [int(visit.seen.all(-1).sum()) for visit in body.visits]
    if args.json:
        postures_deg = [np.degrees(moment.commanded) for moment in session.history[1:]]
        found = {"rehearsed": len(body), "postures_deg": postures_deg, "points_seen": usable}
        print_json(args, found | {"noise_px": body.noise_px, "body": msgspec.to_builtins(body.body)}, settings)
    else:
        of = escape(body.body.robot)
        print(f"rehearsed     {len(body)} postures of {of}, {min(usable)} points or more seen in each")
        if max(usable) >= MIN_POINTS:
            print(f"imitate with  {as_imitation(settings, str(args.out))}")
    if max(usable) < MIN_POINTS:
        print(f"viewimit rehearse: no posture shows {MIN_POINTS} points, which is what it takes", file=sys.stderr)
        return options.MISSED
    return options.DONE
