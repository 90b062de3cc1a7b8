"""The parts of `viewimit bench`: each makes its runs, and tells them as data and as a table."""

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial

import msgspec
from tqdm import tqdm

from ..estimation.transfers import TRANSFERS
from ..experiments.bench import (
    claims,
    compare,
    compare_table,
    compared,
    following,
    robots,
    robustness,
    scenes,
    speed,
    success,
    tracks,
)
from ..experiments.executors.study import Study
from ..loop.settings import SENSORS, Settings
from ..sensing.files import escape
from ..servo import SERVOS
from ..simulation.eyes import require_eyes
from ..simulation.scene import Scene
from . import BadInput
from . import bench_tables as tables
from .options import naming

PAPER_TRANSFER = "epipolar"
CASES: dict[str, Sequence] = {
    "robustness": robustness.CASES,
    "claims": claims.CASES,
    "compare": compare.CASES,
    "scenes": scenes.ROWS,
    "tracks": tracks.CASES,
}
PAIRS_A_SCENE = 5


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
    settings = Settings.paper(scene=args.scene, points=args.points)
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
    cases = _cases(args)
    found = _with_bar(
        "robustness", lambda tell: robustness.run(settings, cases, args.runs, args.seed, workers=study, tell=tell)
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
    count, settings, rows = math.ceil(args.runs / PAIRS_A_SCENE), _best(args), _cases(args)
    made = partial(scenes.run, settings, count, PAIRS_A_SCENE, args.seed, args.max_motions, rows, study)
    found = _with_bar("scenes", lambda tell: made(tell=tell))
    heading = f"{count} random scenes, {PAIRS_A_SCENE} random starts and demonstrators in each, seed {args.seed}"
    return {"pairs": heading, "rows": [asdict(outcome) for outcome in found]}, tables.scenes_table(found, heading)


def _claims(args: argparse.Namespace, _: Scene, study: Study) -> tuple[list[dict], str]:
    best, cases = Settings(), _cases(args)
    found = _with_bar("claims", lambda tell: claims.run(cases, args.runs, args.seed, study, tell, args.rehearsed))
    heading = f"{args.runs} random runs a case of {best.transfer} and {best.servo} in {best.scene}, seed {args.seed}"
    if args.rehearsed:
        heading += f", {args.rehearsed} postures rehearsed"
    return [asdict(outcome) for outcome in found], f"{heading}\n{tables.claims_table(found)}"


def _compare(args: argparse.Namespace, _: Scene, study: Study) -> tuple[list[dict], str]:
    if args.path:
        with naming("PATH"):
            rows = compare_table.read(args.path)
            compared.compared(rows)  # a table cut short lacks runs
        heading = f"{args.path}"
    else:
        servos = [name for name in SERVOS if args.servo in (None, name) or name == compared.PAPER_LAW]
        transfer, cases = _best(args).transfer, _cases(args)
        settings = Settings.paper(scene=args.scene, points=args.points, transfer=transfer)
        rows = _with_bar(
            "compare",
            lambda tell: compare.run(settings, servos, args.runs, args.seed, args.max_motions, cases, study, tell),
        )
        heading = (
            f"{args.runs} random runs a case of every law, {settings.transfer}, at most {args.max_motions} motions, "
            f"seed {args.seed}"
        )
    if args.csv:
        with naming("--csv"):
            compare_table.write(rows, args.csv)
    found = compared.compared(rows)
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
            settings = Settings.paper(scene=args.scene, points=args.points, transfer=transfer, servo=servo)
            cases = [robustness.Case(f"{transfer}, {servo}, {sensor}", {"sensor": sensor}) for sensor in SENSORS]
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
    settings = msgspec.structs.replace(_best(args), frames=Settings().frames)
    found = []
    for one in robots.run(settings, paths, args.runs, args.seed, args.max_motions):
        found.append(one)
        if not args.json:
            print(escape(tables.robot_line(one)), flush=True)
    usable = [one for one in found if one.refused is None]
    arrived = sum(one.all_arrived for one in usable)
    summary = (
        f"{arrived} of {len(usable)} robots within {robots.ARRIVED_DEG:g}° in all of {args.runs} runs each, seed "
        f"{args.seed}; {len(found) - len(usable)} refused"
    )
    return {"arrived": arrived, "usable": len(usable), "robots": [asdict(one) for one in found]}, summary


def _tracks(args: argparse.Namespace, _: Scene, study: Study) -> tuple[list[dict], str]:
    cases = _cases(args)
    found = _with_bar("tracks", lambda tell: tracks.run(args.runs, args.seed, cases, study, tell))
    heading = f"{args.runs} random tracks of a stereo rig a case, seed {args.seed}"
    return [asdict(outcome) for outcome in found], f"{heading}\n{tables.tracks_table(found)}"


def _cases(args: argparse.Namespace) -> list:
    """Those of this part that are asked for: the one of this name, or those whose names hold it."""
    cases = CASES[args.what]
    named = [case for case in cases if case.name == args.case]
    chosen = named or [case for case in cases if (args.case or "") in case.name]
    if not chosen:
        raise BadInput(f"--case: of {args.what} none holds {args.case!r}: {'; '.join(case.name for case in cases)}")
    return chosen


def _best(args: argparse.Namespace) -> Settings:
    """A frame at each posture, as the cases of a table set their own."""
    asked = {"transfer": args.transfer, "servo": args.servo}
    return Settings(frames=1, **{name: value for name, value in asked.items() if value})


def _with_bar(name: str, work: Callable):
    """A bar on standard error if that is a terminal."""
    style = "{desc} {percentage:3.0f}% {bar} {elapsed}<{remaining}"
    with tqdm(total=1.0, desc=name, disable=None, leave=False, bar_format=style) as bar:
        return work(lambda share: bar.update(share - bar.n))


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
    "tracks": _tracks,
}
