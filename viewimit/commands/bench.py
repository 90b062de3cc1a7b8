"""viewimit bench: how fast E is, and how often and how soon each servo arrives."""

import argparse
import hashlib
import math
import sys
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path

import msgspec
from tqdm import tqdm

from ..analysis.landscape import grid_axes
from ..body_image import FEWEST
from ..experiments.bench import claims, compare, following, robots, robustness, scenes, speed, success
from ..experiments.executors import fingerprint
from ..experiments.executors.cluster import Cluster
from ..experiments.executors.executor import StudyError
from ..experiments.executors.folder import StudyFolder
from ..experiments.executors.local import LocalPool
from ..experiments.executors.study import Study
from ..geometry.affine import require_points
from ..history import MAX_HISTORY
from ..servo import SERVOS
from ..settings import BEST, CAMERAS, Settings
from ..simulation.eyes import require_eyes
from ..simulation.scene import Scene, load_scene, scene_names
from ..simulation.world import World
from ..transfer import TRANSFERS
from . import BadInput
from . import bench_tables as tables
from .json_output import print_json
from .options import DONE, USUAL_LAYOUT, add_json_option, between, layout, naming
from .rehearse import MOST_POSTURES

INTERRUPTED = 130  # what shells report of a program that Ctrl-C ended
RUNS, MOST_RUNS, MAX_MOTIONS = 200, 10_000_000, 500
PAPER_TRANSFER = "epipolar"
PAIRS_A_SCENE = 5


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "what",
        nargs="?",
        choices=(*PARTS, "all"),
        default="all",
        help="success: of every transfer and servo; robustness: with noise, missing and wrong points, seven joints; "
        "following: a demonstrator that moves; scenes: drawn at random, also with any head; claims: how often they are "
        "made, and true; compare: all servos beside each other, in five cases; pictures: rendered ones, and how well "
        "markers are detected in them; robots: every URDF of a folder, in the scene made for it, --runs each; all: "
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
    parser.add_argument("--points", type=int, metavar="N", help=f"layout of the scene ({USUAL_LAYOUT})")
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
        type=between(int, FEWEST, MOST_POSTURES),
        default=0,
        metavar="K",
        help="of servos that use it, after watching themselves in so many postures, whose motions do not count (none)",
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
    with naming("--scene, --points"):
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
                print(table, flush=True)  # the next part takes minutes
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


def _speed(args: argparse.Namespace, _: Scene, study: Study) -> tuple[dict, str]:
    found = _with_bar("speed", lambda tell: speed.run(args.scene, args.points, args.full_loop, args.seed, tell))
    return asdict(found), tables.speed_table(found)


def _success(args: argparse.Namespace, scene: Scene, study: Study) -> tuple[list[dict], str]:
    if args.grid:
        pairs = success.grid_pairs(scene, args.grid)
        what = f"{len(pairs)} starts on a grid over the whole range, the scene's demonstrator"
    else:
        pairs = success.random_pairs(scene, args.runs, args.seed)
        what = f"{len(pairs)} random starts and demonstrators over the whole range, seed {args.seed}"
    if args.rehearsed:
        what += f", {args.rehearsed} postures rehearsed"
    settings = Settings(scene=args.scene, points=args.points)
    results = []
    for transfers, servos in _asked(args):
        name = f"success, {', '.join(transfers)}"
        made = partial(success.run, settings, pairs, transfers, servos, args.max_motions, study)
        results += _with_bar(name, lambda tell: made(tell=tell, rehearsed=args.rehearsed))  # noqa: B023
    heading = f"{what}, {args.points} points of {args.scene}"
    return [{"pairs": heading, **asdict(result)} for result in results], tables.success_table(results, heading)


def _asked(args: argparse.Namespace) -> list[tuple[list[str], list[str]]]:
    """Transfers with the servos that run on them. Slow ones, as the paper's law, take minutes, and are the paper's
    transfer's alone unless one of the two is asked for by name."""
    servos = [args.servo] if args.servo else list(SERVOS)
    if args.rehearsed:
        servos = [name for name in servos if SERVOS[name].predicts]
        if not servos:
            raise BadInput(f"--rehearsed: {args.servo} learns from its own motions alone")
        return [([args.transfer] if args.transfer else list(TRANSFERS), servos)]
    if args.transfer or args.servo:
        return [([args.transfer] if args.transfer else list(TRANSFERS), servos)]
    others = [name for name in TRANSFERS if name != PAPER_TRANSFER]
    return [([PAPER_TRANSFER], servos), (others, _quick())]


def _quick() -> list[str]:
    return [name for name, servo in SERVOS.items() if not servo.slow]


def _robustness(args: argparse.Namespace, _: Scene, study: Study) -> tuple[list[dict], str]:
    settings = msgspec.structs.replace(_best(args), scene=args.scene, points=args.points)
    found = _with_bar(
        "robustness", lambda tell: robustness.run(settings, runs=args.runs, seed=args.seed, workers=study, tell=tell)
    )
    heading = f"{args.runs} random runs a case, seed {args.seed}, largest joint error to the demonstrator"
    return [asdict(outcome) for outcome in found], f"{heading}\n{tables.robustness_table(found)}"


def _following(args: argparse.Namespace, _: Scene, study: Study) -> tuple[list[dict], str]:
    found = _with_bar(
        "following", lambda tell: following.run(args.scene, args.points, seed=args.seed, workers=study, tell=tell)
    )
    heading = f"{found[0].runs} paths, seed {args.seed}, {args.points} points of {args.scene}: largest joint error"
    return [asdict(outcome) for outcome in found], f"{heading}\n{tables.following_table(found)}"


def _scenes(args: argparse.Namespace, _: Scene, study: Study) -> tuple[dict, str]:
    count, settings = math.ceil(args.runs / PAIRS_A_SCENE), _best(args)
    found = _with_bar(
        "scenes",
        lambda tell: scenes.run(settings, count, PAIRS_A_SCENE, args.seed, args.max_motions, workers=study, tell=tell),
    )
    heading = f"{count} random scenes, {PAIRS_A_SCENE} random starts and demonstrators in each, seed {args.seed}"
    return {"pairs": heading, "rows": [asdict(outcome) for outcome in found]}, tables.scenes_table(found, heading)


def _claims(args: argparse.Namespace, _: Scene, study: Study) -> tuple[list[dict], str]:
    found = _with_bar(
        "claims",
        lambda tell: claims.run(runs=args.runs, seed=args.seed, workers=study, rehearsed=args.rehearsed, tell=tell),
    )
    heading = f"{args.runs} random runs a case of {BEST.transfer} and {BEST.servo} in {BEST.scene}, seed {args.seed}"
    if args.rehearsed:
        heading += f", {args.rehearsed} postures rehearsed"
    return [asdict(outcome) for outcome in found], f"{heading}\n{tables.claims_table(found)}"


def _compare(args: argparse.Namespace, _: Scene, study: Study) -> tuple[list[dict], str]:
    if args.path:
        with naming("PATH"):
            rows = compare.read(args.path)
        heading = f"{args.path}"
    else:
        servos = [name for name in SERVOS if args.servo in (None, name) or name == compare.PAPER_LAW]
        settings = Settings(scene=args.scene, points=args.points, transfer=_best(args).transfer)
        rows = _with_bar(
            "compare",
            lambda tell: compare.run(
                settings, servos, args.runs, args.seed, args.max_motions, workers=study, tell=tell
            ),
        )
        heading = (
            f"{args.runs} random runs a case of every law, {settings.transfer}, at most {args.max_motions} motions, "
            f"seed {args.seed}"
        )
    if args.csv:
        with naming("--csv"):
            compare.write(rows, args.csv)
    found = compare.compared(rows)
    return [asdict(cell) for cell in found], f"{heading}\n{tables.compared_table(found)}"


def _pictures(args: argparse.Namespace, scene: Scene, study: Study) -> tuple[dict, str]:
    """Detection, and the servos on points and on pictures, by transfer, servo and camera."""
    with naming("--scene"):
        require_eyes("rendered", scene)
    from ..experiments.bench import pictures  # loads pybullet and OpenCV

    detected = _with_bar("detection", lambda tell: pictures.run(args.scene, args.runs, args.seed, tell))
    outcomes = []
    for transfer in [args.transfer] if args.transfer else TRANSFERS:
        for servo in [args.servo] if args.servo else _quick():
            settings = Settings(scene=args.scene, points=args.points, transfer=transfer, servo=servo)
            cases = [robustness.Case(f"{transfer}, {servo}, {camera}", {"camera": camera}) for camera in CAMERAS]
            outcomes += _with_bar(
                f"{transfer}, {servo}",
                lambda tell: robustness.run(settings, cases, args.runs, args.seed, workers=study, tell=tell),  # noqa: B023
            )
    heading = f"{args.runs} random runs, seed {args.seed}, largest joint error to the demonstrator"
    told = {"detection": asdict(detected), "servos": [asdict(outcome) for outcome in outcomes]}
    return told, f"{tables.detection_table(detected)}\n{heading}\n{tables.robustness_table(outcomes)}"


def _robots(args: argparse.Namespace, _: Scene, study: Study) -> tuple[dict, str]:
    """A line each, as soon as it is known."""
    with naming("FOLDER"):
        paths = robots.urdfs(args.path)
    settings = msgspec.structs.replace(BEST, transfer=_best(args).transfer, servo=_best(args).servo)
    found = []
    for one in robots.run(settings, paths, args.runs, args.seed, args.max_motions):
        found.append(one)
        if not args.json:
            print(tables.robot_line(one), flush=True)
    usable = [one for one in found if one.refused is None]
    arrived = sum(one.all_arrived for one in usable)
    summary = (
        f"{arrived} of {len(usable)} robots within {robots.ARRIVED_DEG:g}° in all of {args.runs} runs each, seed "
        f"{args.seed}; {len(found) - len(usable)} refused"
    )
    return {"arrived": arrived, "usable": len(usable), "robots": [asdict(one) for one in found]}, summary


def _best(args: argparse.Namespace) -> Settings:
    """A frame at each posture, as the cases of a table set their own."""
    return Settings(transfer=args.transfer or BEST.transfer, servo=args.servo or BEST.servo)


PARTS = {
    "speed": _speed,
    "success": _success,
    "robustness": _robustness,
    "following": _following,
    "scenes": _scenes,
    "claims": _claims,
    "compare": _compare,
    "pictures": _pictures,
    "robots": _robots,
}
STUDIES = [name for name in PARTS if name not in ("speed", "robots")]
NOT_OF_STUDY = {"run", "json", "out", "cluster", "csv", "path", "full_loop"}  # change no result of one


def _with_bar(name: str, work: Callable):
    """A bar on standard error if that is a terminal."""
    style = "{desc} {percentage:3.0f}% {bar} {elapsed}<{remaining}"
    with tqdm(total=1.0, desc=name, disable=None, leave=False, bar_format=style) as bar:
        return work(lambda share: bar.update(share - bar.n))
