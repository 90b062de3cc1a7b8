"""viewimit reproduce: the paper's experiments, as figures, data, and a table beside what the paper says."""

import argparse
import sys
from pathlib import Path

from tqdm import tqdm

from ..analysis.trajectory import MOTIONS, load_motion
from ..drawing.export import figures
from ..experiments import EXPERIMENTS, ON_PICTURES, Experiment
from ..experiments.experiment import claims_json, write
from ..experiments.paper import common
from ..options import ARM, DONE, MISSED, SCENE, SIGHT, add_json_option, add_settings, naming, settings_from
from ..simulation.scene import load_scene
from .json_output import print_json

BAR = "{desc} {percentage:3.0f}% {bar} {elapsed}"  # on standard error, if that is a terminal


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "figures",
        nargs="*",
        metavar="FIGURE",
        help=f"{', '.join(EXPERIMENTS)}, or all (all); with --sensor rendered {', '.join(ON_PICTURES)}",
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="write figures (SVG, PNG, PDF), data (CSV, NPZ) and manifests"
    )
    parser.add_argument(
        "--motion",
        default="sinusoid",
        metavar="NAME",
        help=f"Fig. 10: {', '.join(MOTIONS)}, or a recorded .json (sinusoid)",
    )
    add_settings(parser, *SCENE, "demonstrator_deg", "transfer", "rectify", *SIGHT, "sensor", "dynamics", *ARM, "servo")
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    settings = settings_from(args)
    experiments = ON_PICTURES if settings.sensor == "rendered" else EXPERIMENTS
    names = _asked(args.figures, experiments)
    with naming("--motion"):
        offered = {"motion": _motion(args.motion, settings)}
    if args.out:
        with naming("--out"):
            args.out.mkdir(parents=True, exist_ok=True)
        for suffix, (package, install) in figures.WRITERS.items():
            if not figures.can_render(suffix):
                print(f"viewimit reproduce: no {suffix}; that needs {package}: {install}", file=sys.stderr)
    figures_json, judged = {}, []
    for name in names:
        experiment = experiments[name]
        options = {option: offered[option] for option in experiment.options}
        with naming("--scene, --joints, --n-points, --missing"):
            with tqdm(total=1.0, desc=name, disable=None, bar_format=BAR) as bar:
                result = experiment.run(settings, lambda share, _, bar=bar: bar.update(share - bar.n), **options)
        judged += result.claims
        written = []
        if args.out:
            with naming("--out"):
                written = write(name, experiment, result, args.out)
        figures_json[name] = {**claims_json(result.claims), "files": [str(path) for path in written]}
    if args.json:
        print_json(
            args,
            {"figures": figures_json, "missed": [claim.name for claim in judged if claim.holds is False]},
            settings,
        )
    else:
        print(common.table(judged))
        print(f"\n{common.verdict(judged) or 'nothing is judged'}")
    return MISSED if any(claim.holds is False for claim in judged) else DONE


def _asked(words: list[str], experiments: dict[str, Experiment]) -> list[str]:
    """Figures in the order of the paper, each once. Raises BadInput."""
    with naming("figures"):
        for word in words:
            if word in {*EXPERIMENTS, *ON_PICTURES} - {*experiments}:
                sensor = "rendered" if word in ON_PICTURES else "projected"
                raise ValueError(f"{word} needs --sensor {sensor}")
            if word not in experiments and word != "all":
                raise ValueError(f"no figure {word!r}; there are {', '.join(experiments)} and all")
    return [name for name in experiments if not words or name in words or "all" in words]


def _motion(name: str, settings):
    if name in MOTIONS:
        return name
    if not name.endswith(".json"):
        raise ValueError(f"no motion {name!r}; there are {', '.join(MOTIONS)}, or the path of a .json file")
    return load_motion(name, load_scene(settings.scene, settings.robot, settings.joints))
