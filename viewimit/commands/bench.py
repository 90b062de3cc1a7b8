"""viewimit bench: how fast E is, and studies of how often and how soon each servo converges."""

import argparse
import contextlib
import dataclasses
import hashlib
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec
from tqdm import tqdm

from ..analysis.landscape import grid_axes
from ..estimation.transfers import TRANSFERS
from ..experiments.bench import engine, report, speed
from ..experiments.bench.cases import GROUPS
from ..experiments.executors import Study, StudyError, StudyFile, code_version
from ..geometry.affine import require_points
from ..loop.history import MAX_HISTORY
from ..loop.self_calibration import MIN_POSTURES
from ..loop.settings import FIELDS, MAX_SEED, Settings, UnknownMethod
from ..options import DONE, BadInput, add_json_option, between, layout, naming
from ..sensing.files import escape
from ..servo import SERVOS
from ..simulation.scene import load_scene, scene_names
from ..simulation.world import World
from .json_output import print_json

INTERRUPTED = 130  # what shells report of a program that Ctrl-C ended
ALL, FEW_RUNS = "all", 10
MAX_RUNS, MAX_REHEARSED, MAX_JOBS = 10_000_000, 200, 1000
MILLION, CORES = 1_000_000, 64


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add a subcommand for each group of cases, one for all of them, and one for the speed of E."""
    benchmarks = parser.add_subparsers(dest="benchmark", metavar="benchmark", required=True)
    alone = {"speed": "Speed of E over the range, at one pose, and of one step.", ALL: "Every case of all groups."}
    for name, title in {**alone, **{name: group.title for name, group in GROUPS.items()}}.items():
        one, group = benchmarks.add_parser(name, help=title, description=title, allow_abbrev=False), GROUPS.get(name)
        one.add_argument("--seed", type=between(int, 0, MAX_SEED), default=0, metavar="N", help="seed of the draws (0)")
        if name == "speed" or (group and group.in_scene):
            one.add_argument("--scene", default=Settings().scene, metavar="NAME", help=FIELDS["scene"].description)
            one.add_argument(
                "--n-points", dest="points", type=int, metavar="N", help="layout of the scene's body points"
            )
        if group and group.of_folder:
            one.add_argument("path", type=Path, metavar="FOLDER", help="folder of URDF files")
        elif group:
            path = "table of runs that --csv has written, to be judged again"
            one.add_argument("path", type=Path, nargs="?", metavar="PATH", help=path)
        if name != "speed":
            _add_study_options(one, group.runs if group else FEW_RUNS)
        add_json_option(one)


def _add_study_options(one: argparse.ArgumentParser, runs: int) -> None:
    """Add what every study takes."""
    number = lambda low, high: between(int, low, high)
    one.add_argument("--runs", type=number(1, MAX_RUNS), default=runs, metavar="N", help=f"runs of a case ({runs})")
    one.add_argument("--case", metavar="TEXT", help="case of this name, or those whose names contain it (all)")
    one.add_argument("--jobs", type=number(1, MAX_JOBS), metavar="N", help="processes here (one a processor)")
    one.add_argument("--dask", metavar="ADDRESS", help="run on the Dask cluster of this scheduler (the processes here)")
    one.add_argument("--out", type=Path, metavar="FILE", help="keep finished runs, and go on with those kept (nothing)")
    one.add_argument(
        "--transfer", choices=TRANSFERS, help="estimator of the demonstrator's points in the learner's images"
    )
    one.add_argument(
        "--servo", metavar="NAME,…",
        help="servos, by their names or as MODULE:OBJECT; each is compared with the first one",
    )  # fmt: skip
    one.add_argument(
        "--max-motions", type=number(0, MAX_HISTORY), metavar="N", help="motions of a run, at most (the case's)"
    )
    one.add_argument(
        "--rehearsed", type=number(MIN_POSTURES, MAX_REHEARSED), default=0, metavar="N",
        help="postures in which a servo that can use it calibrates itself first; their motions do not count (0)",
    )  # fmt: skip
    one.add_argument("--csv", type=Path, metavar="FILE", help="write every run, a row each (nothing)")


def run(args: argparse.Namespace) -> int:
    """Run the benchmarks, and print each result as soon as it is known."""
    show = (lambda text: None) if args.json else (lambda text: print(escape(text, len(text), keep="\n"), flush=True))
    parts = [args.benchmark]
    if args.benchmark == ALL:
        has = lambda group: any((args.case or "") in case.name for case in group.cases)
        parts = [name for name, group in GROUPS.items() if not group.of_folder and has(group)]
        if not parts:
            raise BadInput(f"--case: no case contains {args.case!r}")
    results: dict[str, Any] = {}
    with naming("--scene, --n-points"):
        in_scene = _in_scene(args)
    try:
        for part in parts:
            results[part], table = _study(part, args, in_scene) if part in GROUPS else _speed(args)
            show(table if args.benchmark != ALL else f"\n{part}: {GROUPS[part].title}\n{table}")
    except (StudyError, UnknownMethod) as error:
        raise BadInput(str(error)) from None
    except KeyboardInterrupt:
        out = vars(args).get("out")
        kept = f": {out} keeps finished runs, and the same command goes on" if out else ""
        print(f"viewimit bench: interrupted{kept}", file=sys.stderr)
        return INTERRUPTED
    if args.json:
        print_json(args, results)
    return DONE


def _in_scene(args: argparse.Namespace) -> dict[str, Any]:
    """Scene and layout, if the benchmark takes them; the layout is written into the options. Raises ValueError."""
    if not hasattr(args, "scene"):
        return {}
    scene = load_scene(args.scene)
    args.points = layout(args, scene)
    world = World(scene, args.points)
    require_points(len(world.body))
    grid_axes(world)
    return {"scene": args.scene, "points": args.points}


def _speed(args: argparse.Namespace) -> tuple[Any, str]:
    with _progress("speed") as progress:
        found = speed.run(args.scene, args.points, args.seed, progress)
    return dataclasses.asdict(found), speed.speed_table(found)


def _study(part: str, args: argparse.Namespace, in_scene: dict[str, Any]) -> tuple[Any, str]:
    """Make or read the runs of a group of cases, and judge them: as JSON has it, and as a text for people."""
    group, refused = GROUPS[part], list[str]()
    with naming("FOLDER" if group.of_folder else "--case"):
        cases = group.of_folder(args.path) if group.of_folder else engine.chosen(group.cases, args.case)
    if group.of_folder:
        cases, refused = _usable(cases)
    path = None if group.of_folder else vars(args).get("path")
    if path:
        with naming("PATH"):
            runs = report.read_runs(path)
    else:
        methods = _methods(group, args)
        refused += dict.fromkeys(f"refused  {why}" for case in cases for _, servo in methods
                                 if (why := engine.cannot_run(case, servo)))  # fmt: skip
        runs = _runs(part, cases, methods, args, in_scene)
    with naming("PATH"):
        try:
            found = engine.summarise(runs, group.measures)
        except KeyError as missing:
            if not path:
                raise
            raise ValueError(f"{path}: without {missing.args[0]} these are runs of another group than {part}") from None
    if args.csv:
        with naming("--csv"):
            report.write_runs(runs, _path(args.csv, part, args))
    table = report.lay_out(found) if found else ""
    heading = str(path) if path else f"{args.runs} random runs a case, seed {args.seed}"
    measured = {f"{row.transfer}, {row.servo}" for row in found}
    if len(measured) == 1 and not path:
        heading += f", {measured.pop()}"
    rows = [dataclasses.asdict(row) for row in found]
    if args.json:
        print(*refused, sep="\n", end="\n" * bool(refused), file=sys.stderr)
    told = {"rows": rows, "refused": refused} if group.of_folder else rows
    return told, "\n".join(filter(None, [heading, table, *refused]))


def _usable(cases: Sequence[engine.Case]) -> tuple[list[engine.Case], list[str]]:
    """Divide the robots of a folder into those for which a scene can be made, and why not the others."""
    usable, refused = [], []
    for case in cases:
        try:
            load_scene(case.name)
            usable.append(case)
        except ValueError as error:
            refused.append(f"refused  {error}")
    return usable, refused


def _path(path: Path, part: str, args: argparse.Namespace) -> Path:
    """A file of this group: the given one, or one for each group."""
    return path if args.benchmark == part else path.with_stem(f"{path.stem}-{part}")


def _methods(group: engine.Group, args: argparse.Namespace) -> list[tuple[str, str]]:
    """Transfers and servos that have runs of this group. Raises BadInput."""
    methods = group.methods(args.transfer, args.servo.split(",") if args.servo else ())
    learners = [pair for pair in methods if (engine.own_servo(pair[1]) or SERVOS[pair[1]]).predicts]
    if args.rehearsed and args.servo and len(learners) < len(methods):
        raise BadInput(f"--rehearsed: {args.servo} learns from its own motions alone")
    return learners if args.rehearsed else methods


def _runs(
    part: str,
    cases: Sequence[engine.Case],
    methods: Sequence[tuple[str, str]],
    args: argparse.Namespace,
    in_scene: dict[str, Any],
) -> list[engine.Run]:
    """Make the runs of a group, and say what they cost."""
    group = GROUPS[part]
    study = Study(args.jobs, args.dask, _file(part, args, cases))
    with _progress(part) as progress:
        runs = engine.run_cases(
            group,
            cases,
            study,
            methods=methods,
            settings=msgspec.structs.replace(group.settings, **in_scene),
            runs=args.runs,
            seed=args.seed,
            max_motions=args.max_motions,
            rehearsed=args.rehearsed,
            progress=progress,
        )
    if study.runs:
        print(cost_line(study), file=sys.stderr)
    return runs


def _file(part: str, args: argparse.Namespace, cases: Sequence[engine.Case]) -> StudyFile | None:
    """The file of the study, which names all that its results depend on. Raises StudyError."""
    if not args.out:
        return None
    ignored = {"command", "run", "json", "jobs", "dask", "out", "csv"}
    study = {name: str(value) if isinstance(value, Path) else value for name, value in vars(args).items()
             if name not in ignored}  # fmt: skip
    if "scene" in study and args.scene not in scene_names():  # a file: its content counts, not its path
        content = Path(args.scene).read_bytes()
        study["scene"] = f"{Path(args.scene).name} ({hashlib.sha256(content).hexdigest()[:12]})"
    own = engine.own_files(args.servo.split(",") if args.servo else (), cases)
    return StudyFile(_path(args.out, part, args), {**study, "code": code_version(), "own": own})


@contextlib.contextmanager
def _progress(name: str) -> Iterator[Any]:
    """A bar on standard error if that is a terminal."""
    style = "{desc} {percentage:3.0f}% {bar} {elapsed}<{remaining}"
    with tqdm(total=1.0, desc=name, disable=None, leave=False, bar_format=style) as bar:
        yield lambda share: bar.update(share - bar.n)


def cost_line(study: Study) -> str:
    """Say what the runs of a study cost, and what a million of them would."""
    each = study.cpu_s / study.runs
    kept = f", {study.kept} of them kept before" if study.kept else ""
    hours = each * MILLION / 3600
    return (
        f"{study.runs} runs{kept}: {study.cpu_s:.1f} s of CPU on one core, {each * 1e3:.1f} ms a run; "
        f"{MILLION:,} such runs need {hours:.1f} h on one core, {hours / CORES:.2f} h on {CORES}"
    )
