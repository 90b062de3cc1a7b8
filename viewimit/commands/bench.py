"""viewimit bench: how fast E is, and how often and how soon each servo arrives."""

import argparse
import hashlib
import sys
from pathlib import Path

from ..analysis.landscape import grid_axes
from ..estimation.transfers import TRANSFERS
from ..experiments.executors import fingerprint
from ..experiments.executors.cluster import Cluster
from ..experiments.executors.executor import StudyError
from ..experiments.executors.folder import StudyFolder
from ..experiments.executors.local import LocalPool
from ..experiments.executors.study import Study
from ..geometry.affine import require_points
from ..loop.history import MAX_HISTORY
from ..loop.self_calibration import MIN_POSTURES
from ..sensing.files import escape
from ..servo import SERVOS
from ..simulation.scene import load_scene, scene_names
from ..simulation.world import World
from . import BadInput
from . import bench_tables as tables
from .bench_parts import CASES, PARTS
from .json_output import print_json
from .options import DONE, USUAL_LAYOUT, add_json_option, between, layout, naming
from .rehearse import MOST_POSTURES

INTERRUPTED = 130  # what shells report of a program that Ctrl-C ended
RUNS, MOST_RUNS, MAX_MOTIONS = 200, 10_000_000, 500
STUDIES = [name for name in PARTS if name not in ("speed", "robots")]
NOT_OF_STUDY = {"run", "json", "out", "cluster", "csv", "path", "full_loop"}  # change no result of one


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "what",
        nargs="?",
        choices=(*PARTS, "all"),
        default="all",
        help="success: of every transfer and servo; robustness: with noise, missing and wrong points, seven joints; "
        "following: a demonstrator that moves; scenes: drawn at random, also with any head; claims: how often they are "
        "made, and true, also of points with a mirror image; compare: all servos beside each other, in five cases; "
        "pictures: rendered ones, and how well markers are detected in them; robots: every URDF of a folder, in the "
        "scene made for it, --runs each; tracks: of stereo rigs, whether `evaluate` rectifies them, and how far "
        "transfers are off at points held out; all: "
        "speed and success (%(default)s)",
    )
    parser.add_argument(
        "path",
        nargs="?",
        type=Path,
        metavar="PATH",
        help="robots: the folder of URDF files; compare: a table of runs that --csv has written, to be judged anew",
    )
    parser.add_argument("--scene", default="panda", help="by name or path (%(default)s)")
    parser.add_argument(
        "--n-points", dest="points", type=int, metavar="N", help=f"layout of the scene ({USUAL_LAYOUT})"
    )
    seed = between(int, 0, 2**32)
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="of postures timed, of runs (%(default)s)")
    timed = parser.add_argument_group("speed, of E over the range, at one posture, and of one motion")
    timed.add_argument("--full-loop", action="store_true", help="time plain loops on every posture, not a tenth")
    runs = parser.add_argument_group("success, of every transfer and servo")
    number, motions = between(int, 1, MOST_RUNS), between(int, 0, MAX_HISTORY)
    pairs = runs.add_mutually_exclusive_group()
    pairs.add_argument(
        "--runs", type=number, default=RUNS, metavar="N", help="random starts and demonstrators (%(default)s)"
    )
    pairs.add_argument(
        "--grid", type=grid, metavar="N,N", help="instead: starts a joint, for the scene's own demonstrator"
    )
    runs.add_argument("--transfer", choices=TRANSFERS, help="this one only")
    runs.add_argument("--servo", choices=SERVOS, help="this one only")
    runs.add_argument("--max-motions", type=motions, default=MAX_MOTIONS, metavar="N", help="of a run (%(default)s)")
    runs.add_argument(
        "--rehearsed",
        type=between(int, MIN_POSTURES, MOST_POSTURES),
        default=0,
        metavar="K",
        help="of servos that use it, after watching themselves in so many postures, whose motions do not count (none)",
    )
    runs.add_argument(
        "--case",
        metavar="TEXT",
        help=f"of {', '.join(CASES)}: the one of this name, or those whose names hold this, as 'hidden' (all)",
    )
    runs.add_argument("--csv", type=Path, metavar="FILE", help="of compare: keep every run, a row each")
    studies = parser.add_argument_group(
        "large studies",
        f"of {', '.join(STUDIES)}: the same digits as without; what they cost is said on standard error",
    )
    studies.add_argument(
        "--cluster", metavar="ADDRESS", help="make the runs on the Dask cluster of this scheduler (the processors here)"
    )
    studies.add_argument(
        "--out", type=Path, metavar="DIR", help="keep what is done, and go on with what is kept there (nothing)"
    )
    add_json_option(parser)


def grid(text: str) -> tuple[int, int]:
    """A type for argparse: starts of both joints."""
    counts = [between(int, 1, 1000)(word) for word in text.split(",")]
    if len(counts) != 2:
        raise argparse.ArgumentTypeError(f"needs two numbers such as 10,13, got {text!r}")
    return counts[0], counts[1]


def run(args: argparse.Namespace) -> int:
    with naming("--scene, --n-points"):
        scene = load_scene(args.scene)
        args.points = layout(args, scene)
        world = World(scene, args.points)
        require_points(len(world.body))
        grid_axes(world)
    _require_fitting(args)
    told: dict = {}
    try:
        study = _study(args)
        for part in ("speed", "success") if args.what == "all" else (args.what,):
            told[part], table = PARTS[part](args, world.scene, study)
            if not args.json:
                print(escape(table, len(table), keep="\n"), flush=True)  # the next part takes minutes
    except StudyError as error:
        raise BadInput(str(error)) from None
    except KeyboardInterrupt:
        kept = f": {args.out} keeps what is done, and the same command goes on from there" if args.out else ""
        print(f"viewimit bench: interrupted{kept}", file=sys.stderr)
        return INTERRUPTED
    if study.runs:
        print(tables.cost_line(study), file=sys.stderr)
    if args.json:
        print_json(args, told)
    return DONE


def _require_fitting(args: argparse.Namespace) -> None:
    """Raises BadInput for options that a part does not have."""
    if args.what == "robots" and args.path is None:
        raise BadInput("robots: needs the folder of URDF files: viewimit bench robots FOLDER")
    if args.what not in ("robots", "compare") and args.path is not None:
        raise BadInput(f"{args.path}: only `viewimit bench robots` and `compare` take a path")
    if args.case and args.what not in CASES:
        raise BadInput(f"--case: is of {', '.join(CASES)}")
    if args.csv and args.what != "compare":
        raise BadInput("--csv: is of `viewimit bench compare`")
    if (args.cluster or args.out) and (args.what not in STUDIES or (args.what == "compare" and args.path)):
        raise BadInput(f"--cluster, --out: are of {', '.join(STUDIES)}")


def _study(args: argparse.Namespace) -> Study:
    """Raises StudyError."""
    folder = None
    if args.out:
        what = {name: value for name, value in vars(args).items() if name not in NOT_OF_STUDY}
        if args.scene not in scene_names():  # a file: what it says, whatever its name
            content = Path(args.scene).read_bytes()
            what["scene"] = f"{Path(args.scene).name} ({hashlib.sha256(content).hexdigest()[:12]})"
        folder = StudyFolder(args.out, {**what, "code": fingerprint.code()})
    return Study(Cluster(args.cluster) if args.cluster else LocalPool(), folder)
