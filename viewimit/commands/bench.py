"""viewimit bench: how fast E is, how often and how soon each servo converges, and studies of the method."""

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
from ..experiments.bench import detection, engine, report, speed, tracks
from ..experiments.bench.cases import GROUPS, PAPER_LAW
from ..experiments.executors import Study, StudyError, StudyFile, code_version
from ..geometry.affine import require_points
from ..loop.history import MAX_HISTORY
from ..loop.self_calibration import MIN_POSTURES
from ..loop.settings import FIELDS, MAX_SEED, Settings, UnknownMethod
from ..options import DONE, BadInput, add_json_option, between, layout, naming
from ..sensing.files import escape
from ..simulation.scene import load_scene, scene_names
from ..simulation.world import World
from .json_output import print_json

INTERRUPTED = 130  # what shells report of a program that Ctrl-C ended
ALL = "all"
COMPARISON, PAGE = "comparison.csv", "comparison.md"
MAX_RUNS, MAX_REHEARSED, MAX_JOBS = 10_000_000, 200, 1000
MILLION, CORES = 1_000_000, 64


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add a subcommand for each group of cases, one for the speed of E, and one for tracks."""
    benchmarks = parser.add_subparsers(dest="benchmark", metavar="benchmark", required=True)
    titles = {
        ALL: "Speed and success; what `viewimit bench` does alone.",
        "speed": "Speed of E over the range, at one pose, and of one step.",
        "detection": "How well markers are detected in rendered pictures.",
        "tracks": "Tracks of stereo rigs: whether `evaluate` rectifies them, and the errors of transfers.",
    }
    for name, title in {**titles, **{name: group.title for name, group in GROUPS.items()}}.items():
        one = benchmarks.add_parser(name, help=title, description=title, allow_abbrev=False)
        group = GROUPS["success"] if name == ALL else GROUPS.get(name)
        one.add_argument("--seed", type=between(int, 0, MAX_SEED), default=0, metavar="N", help="seed of the draws (0)")
        if name in (ALL, "speed", "detection") or (group and group.in_scene):
            one.add_argument("--scene", default=Settings().scene, metavar="NAME", help=FIELDS["scene"].description)
            one.add_argument(
                "--n-points", dest="points", type=int, metavar="N", help="layout of the scene's body points"
            )
        if name in (ALL, "speed"):
            one.add_argument("--full-loop", action="store_true", help="time plain loops on every posture, not a tenth")
        if name == "detection":
            one.add_argument(
                "--runs", type=between(int, 1, MAX_RUNS), default=200, metavar="N", help="pairs of poses (200)"
            )
        elif name != "speed":
            _add_study_options(one, name, group)
        add_json_option(one)


def _add_study_options(one: argparse.ArgumentParser, name: str, group: engine.Group | None) -> None:
    """Add what every study takes, and what those of sessions take."""
    number = lambda low, high: between(int, low, high)
    runs = group.runs if group else 200
    one.add_argument("--runs", type=number(1, MAX_RUNS), default=runs, metavar="N", help=f"runs of a case ({runs})")
    one.add_argument("--case", metavar="TEXT", help="case of this name, or those whose names contain it (all)")
    one.add_argument("--jobs", type=number(1, MAX_JOBS), metavar="N", help="processes here (one a processor)")
    one.add_argument("--dask", metavar="ADDRESS", help="run on the Dask cluster of this scheduler (the processes here)")
    one.add_argument("--out", type=Path, metavar="FILE", help="keep finished runs, and go on with those kept (nothing)")
    if group is None:
        return
    if group.of_folder:
        one.add_argument("path", type=Path, metavar="FOLDER", help="folder of URDF files")
    elif name != ALL:
        path = "table of runs that --csv has written, to be judged again"
        one.add_argument("path", type=Path, nargs="?", metavar="PATH", help=path)
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
    if name == "compare":
        says = f"folder where {COMPARISON} is written, and the table between the marks of {PAGE} (nothing)"
        one.add_argument("--docs", type=Path, metavar="DIR", help=says)


def with_benchmark(words: list[str]) -> list[str]:
    """Return the words of the command with the benchmark first: `all` if none is named."""
    is_default = not words or (words[0].startswith("-") and words[0] not in ("-h", "--help"))
    return [ALL, *words] if is_default else words


def run(args: argparse.Namespace) -> int:
    """Run the benchmarks, and print each result as soon as it is known."""
    show = (lambda line: None) if args.json else (lambda text: print(escape(text, len(text), keep="\n"), flush=True))
    results: dict[str, Any] = {}
    with naming("--scene, --n-points"):
        settings = _in_scene(args)
    try:
        study = Study(vars(args).get("jobs"), vars(args).get("dask"))
        for part in ("speed", "success") if args.benchmark == ALL else (args.benchmark,):
            results[part], table = _run(part, args, settings, study)
            show(table)
    except (StudyError, UnknownMethod) as error:
        raise BadInput(str(error)) from None
    except KeyboardInterrupt:
        out = vars(args).get("out")
        kept = f": {out} keeps finished runs, and the same command goes on" if out else ""
        print(f"viewimit bench: interrupted{kept}", file=sys.stderr)
        return INTERRUPTED
    if study.runs:
        print(cost_line(study), file=sys.stderr)
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


def _run(part: str, args: argparse.Namespace, in_scene: dict[str, Any], study: Study) -> tuple[Any, str]:
    """Run a benchmark. Return its result as JSON has it, and as a text for people."""
    if part in GROUPS:
        return _study(part, args, in_scene, study)
    if part == "speed":
        with _progress(part) as progress:
            found = speed.run(**in_scene, full_loop=args.full_loop, seed=args.seed, progress=progress)
        return dataclasses.asdict(found), speed.speed_table(found)
    if part == "detection":
        with naming("--scene"), _progress(part) as progress:
            detected = detection.detect(args.scene, args.runs, args.seed, progress)
        return dataclasses.asdict(detected), detection.detection_table(detected)
    with naming("--case"):
        cases = engine.chosen(tracks.CASES, args.case)
    study.file = _file(args)
    with _progress(part) as progress:
        outcomes = tracks.run(args.runs, args.seed, cases, study, progress)
    heading = f"{args.runs} random tracks of a stereo rig a case, seed {args.seed}"
    return [dataclasses.asdict(one) for one in outcomes], f"{heading}\n{tracks.tracks_table(outcomes)}"


def _study(part: str, args: argparse.Namespace, in_scene: dict[str, Any], study: Study) -> tuple[Any, str]:
    """Make or read the runs of a group of cases, and judge them."""
    group, refused = GROUPS[part], list[str]()
    with naming("FOLDER" if group.of_folder else "--case"):
        cases = group.of_folder(args.path) if group.of_folder else engine.chosen(group.cases, args.case)
    if group.of_folder:
        cases, refused = _usable(cases)
    path = None if group.of_folder else vars(args).get("path")
    with naming("PATH"):
        runs = report.read_runs(path) if path else _runs(part, cases, args, in_scene, study)
        found = engine.summarise(runs, group.measures)
    if args.csv:
        with naming("--csv"):
            report.write_runs(runs, args.csv)
    table = report.lay_out(found) if found else ""
    if vars(args).get("docs"):
        with naming("--docs"):
            if path != args.docs / COMPARISON:
                report.write_runs(runs, args.docs / COMPARISON)
            report.write_between_marks(f"```text\n{table}\n```", args.docs / PAGE)
    heading = str(path) if path else f"{args.runs} random runs a case, seed {args.seed}"
    methods = {f"{row.transfer}, {row.servo}" for row in found}
    if len(methods) == 1 and not path:
        heading += f", {methods.pop()}"
    rows = [dataclasses.asdict(row) for row in found]
    told = {"rows": rows, "refused": refused} if group.of_folder else rows
    return told, "\n".join([heading, table, *refused])


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


def _runs(part: str, cases: Sequence[engine.Case], args: argparse.Namespace, in_scene: dict[str, Any], study: Study):
    """Make the runs of a group."""
    group = GROUPS[part]
    servos = args.servo.split(",") if args.servo else ()
    methods = group.methods(args.transfer, servos)
    learners = [pair for pair in methods if engine.law_of(pair[1], [0, 0], 1, False) is None
                and engine.servo_named(pair[1]).predicts]  # fmt: skip
    if args.rehearsed and args.servo and len(learners) < len(methods):
        raise BadInput(f"--rehearsed: {args.servo} learns from its own motions alone")
    study.file = _file(args, cases)
    with _progress(part) as progress:
        return engine.run_cases(
            group,
            cases,
            study,
            methods=learners if args.rehearsed else methods,
            settings=msgspec.structs.replace(group.settings, **in_scene),
            runs=args.runs,
            seed=args.seed,
            max_motions=args.max_motions,
            rehearsed=args.rehearsed,
            progress=progress,
        )


def _file(args: argparse.Namespace, cases: Sequence[engine.Case] = ()) -> StudyFile | None:
    """The file of the study, which names all that its results depend on. Raises StudyError."""
    if not args.out:
        return None
    ignored = {"command", "run", "json", "jobs", "dask", "out", "csv", "docs"}
    study = {name: str(value) if isinstance(value, Path) else value for name, value in vars(args).items()
             if name not in ignored}  # fmt: skip
    if "scene" in study and args.scene not in scene_names():  # a file: its content counts, not its path
        content = Path(args.scene).read_bytes()
        study["scene"] = f"{Path(args.scene).name} ({hashlib.sha256(content).hexdigest()[:12]})"
    own = engine.own_files((vars(args).get("servo") or PAPER_LAW).split(","), cases)
    return StudyFile(args.out, {**study, "code": code_version(), "own": own})


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
