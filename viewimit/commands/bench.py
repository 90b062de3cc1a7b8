"""viewimit bench: how fast E is, how often and how soon each servo converges, and studies of the method."""

import argparse
import contextlib
import dataclasses
import hashlib
import math
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints

from tqdm import tqdm

from ..analysis.landscape import grid_axes
from ..experiments.bench import BENCHMARKS, Benchmark
from ..experiments.bench.benchmark import Context, OptionError, Progress, SceneOptions
from ..experiments.executors import Cluster, LocalPool, Study, StudyError, StudyFile, code_version, own_methods
from ..geometry.affine import require_points
from ..sensing.files import escape
from ..simulation.scene import load_scene, scene_names
from ..simulation.world import World
from . import BadInput
from .json_output import print_json
from .options import DONE, add_json_option, between, layout, naming
from .options import option as option_name

INTERRUPTED = 130  # what shells report of a program that Ctrl-C ended
ALL = "all"
PARTS = {name: (name,) for name in BENCHMARKS} | {ALL: ("speed", "success")}
WITHOUT_EFFECT = {"path", "csv", "docs"}  # options that change no result of a study
EXCLUSIVE = {"runs", "grid"}  # options of which only one can be given
MILLION, CORES = 1_000_000, 64


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add a subcommand for each benchmark; its options are the benchmark's fields."""
    benchmarks = parser.add_subparsers(dest="benchmark", metavar="benchmark", required=True)
    for name, parts in PARTS.items():
        text = "Speed and success; what `viewimit bench` does alone." if name == ALL else BENCHMARKS[name].__doc__
        one = benchmarks.add_parser(name, help=text, description=text, allow_abbrev=False)
        fields = {field.name: (field, part) for part in parts for field in dataclasses.fields(BENCHMARKS[part])}
        groups: list[Any] = []
        for field, part in fields.values():
            hint = get_type_hints(BENCHMARKS[part], include_extras=True)[field.name]
            _add_option(one, groups, field, hint)
        if name != ALL and BENCHMARKS[name].distributed:
            studies = one.add_argument_group(
                "large studies", "The same digits as without; what they cost is said on standard error."
            )
            studies.add_argument(
                "--cluster", metavar="ADDRESS", help="run on the Dask cluster of this scheduler (the processors here)"
            )
            studies.add_argument(
                "--out", type=Path, metavar="FILE", help="keep finished runs, and go on with those kept there (nothing)"
            )
        add_json_option(one)


def _add_option(parser: argparse.ArgumentParser, groups: list[Any], field: dataclasses.Field, hint: Any) -> None:
    """Add the option of a field, made from its `Setting`."""
    kind, setting = hint.__origin__, hint.__metadata__[-1]
    if get_origin(kind) is not tuple and NoneType in get_args(kind):
        (kind,) = set(get_args(kind)) - {NoneType}
    default, metavar = field.default, setting.unit.upper() or "NAME"
    in_words = setting.default or ("" if kind is bool or default in (None, dataclasses.MISSING) else str(default))
    words = setting.description + (f" ({in_words})" if in_words else "")
    if field.name == "path":
        nargs = None if default is dataclasses.MISSING else "?"
        parser.add_argument("path", type=Path, nargs=nargs, metavar=metavar, help=words)
        return
    more: dict[str, Any] = {"dest": field.name, "default": default, "help": words}
    if kind is bool:
        more["action"] = "store_true"
    elif setting.choices:
        more["choices"] = setting.choices
    else:
        number = between(int, *(setting.bounds or (-math.inf, math.inf)))
        more |= {"type": {int: number, str: str, Path: Path}.get(kind, _pair_of(number)), "metavar": metavar}
    if field.name in EXCLUSIVE and not groups:
        groups.append(parser.add_mutually_exclusive_group())
    target = groups[0] if field.name in EXCLUSIVE else parser
    target.add_argument(option_name(field.name), **more)


def _pair_of(number: Callable[[str], int]) -> Callable[[str], tuple[int, int]]:
    """A type for argparse: two numbers."""

    def pair(text: str) -> tuple[int, int]:
        words = text.split(",")
        if len(words) != 2:
            raise argparse.ArgumentTypeError(f"needs two numbers such as 10,13, got {text!r}")
        return number(words[0]), number(words[1])

    return pair


def with_benchmark(words: list[str]) -> list[str]:
    """Return the words of the command with the benchmark first: `all` if none is named."""
    is_default = not words or (words[0].startswith("-") and words[0] not in ("-h", "--help"))
    return [ALL, *words] if is_default else words


def run(args: argparse.Namespace) -> int:
    """Run the benchmarks, and print each result as soon as it is known."""
    kinds = {part: BENCHMARKS[part] for part in PARTS[args.benchmark]}
    if any(issubclass(kind, SceneOptions) for kind in kinds.values()):
        with naming("--scene, --n-points"):
            scene = load_scene(args.scene)
            args.points = layout(args, scene)
            world = World(scene, args.points)
            require_points(len(world.body))
            grid_axes(world)
    show = (lambda line: None) if args.json else (lambda text: print(escape(text, len(text), keep="\n"), flush=True))
    results: dict[str, Any] = {}
    try:
        study = _study(args)
        for part, kind in kinds.items():
            benchmark = kind(**{field.name: vars(args)[field.name] for field in dataclasses.fields(kind)})
            results[part], table = benchmark.run(Context(study, _progress, show))
            show(table)
    except (StudyError, OptionError) as error:
        raise BadInput(str(error)) from None
    except KeyboardInterrupt:
        out = vars(args).get("out")
        _warn(f"interrupted{f': {out} keeps finished runs, and the same command goes on' if out else ''}")
        return INTERRUPTED
    if study.runs:
        print(cost_line(study), file=sys.stderr)
    if args.json:
        print_json(args, results)
    return DONE


def _warn(text: str) -> None:
    print(f"viewimit bench: {text}", file=sys.stderr)


@contextlib.contextmanager
def _progress(name: str) -> Iterator[Progress]:
    """A bar on standard error if that is a terminal."""
    style = "{desc} {percentage:3.0f}% {bar} {elapsed}<{remaining}"
    with tqdm(total=1.0, desc=name, disable=None, leave=False, bar_format=style) as bar:
        yield lambda share: bar.update(share - bar.n)


def _study(args: argparse.Namespace) -> Study:
    """Make the study of these options. Raises StudyError."""
    given = vars(args)
    cluster, out = given.get("cluster"), given.get("out")
    if (cluster or out) and given.get("path"):
        raise BadInput("--cluster, --out: the runs of PATH are made already")
    file = None
    if out:
        kind: type[Benchmark] = BENCHMARKS[args.benchmark]
        fields = [field.name for field in dataclasses.fields(kind) if field.name not in WITHOUT_EFFECT]
        study = {"benchmark": args.benchmark, **{name: given[name] for name in fields}}
        if "scene" in study and args.scene not in scene_names():  # a file: its content counts, not its path
            content = Path(args.scene).read_bytes()
            study["scene"] = f"{Path(args.scene).name} ({hashlib.sha256(content).hexdigest()[:12]})"
        file = StudyFile(out, {**study, "code": code_version(), "methods": own_methods()})
    return Study(Cluster(cluster) if cluster else LocalPool(), file)


def cost_line(study: Study) -> str:
    """Say what the runs of a study cost, and what a million of them would."""
    each = study.cpu_s / study.runs
    kept = f", {study.kept} of them kept before" if study.kept else ""
    hours = each * MILLION / 3600
    return (
        f"{study.runs} runs{kept}: {study.cpu_s:.1f} s of CPU on one core, {each * 1e3:.1f} ms a run; "
        f"{MILLION:,} such runs need {hours:.1f} h on one core, {hours / CORES:.2f} h on {CORES}"
    )
