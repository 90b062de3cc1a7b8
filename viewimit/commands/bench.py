"""viewimit bench: how fast E is, and how often and how soon each servo arrives."""

import argparse
import math
import sys
from collections.abc import Callable
from dataclasses import asdict

from tqdm import tqdm

from ..experiments import benchmark, robustness, success
from ..eyes import require_eyes
from ..geometry.affine import require_points
from ..landscape import grid_axes
from ..scene import Scene, load_scene
from ..servo import SERVOS
from ..session import MAX_HISTORY
from ..snapshot import BEST, CAMERAS, Settings
from ..transfer import TRANSFERS
from ..world import World
from .options import DONE, add_json_option, between, naming, print_json

INTERRUPTED = 130  # what shells report of a program that Ctrl-C ended
RUNS, MAX_MOTIONS = 200, 500
PAPER_TRANSFER = "epipolar"
PICTURE_SERVOS = ("broyden", "trust-region")  # the others need thousands of motions


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "what",
        nargs="?",
        choices=("speed", "success", "robustness", "pictures", "all"),
        default="all",
        help="all: speed and success",
    )
    parser.add_argument("--scene", default="panda", help="by name or path (%(default)s)")
    parser.add_argument("--points", type=int, default=10, metavar="N", help="layout of the scene (%(default)s)")
    seed = between(int, 0, 2**32)
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="of postures timed, of runs (%(default)s)")
    speed = parser.add_argument_group("speed, of E over the range, at one posture, and of one motion")
    speed.add_argument("--full-loop", action="store_true", help="time plain loops on every posture, not a tenth")
    runs = parser.add_argument_group("success, of every transfer and servo")
    number, motions = between(int, 1, 100_000), between(int, 0, MAX_HISTORY)
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
    add_json_option(parser)


def grid(text: str) -> tuple[int, int]:
    """A type for argparse: starts of both joints."""
    counts = [between(int, 1, 1000)(word) for word in text.split(",")]
    if len(counts) != 2:
        raise argparse.ArgumentTypeError(f"needs two numbers such as 10,13, got {text!r}")
    return counts[0], counts[1]


def run(args: argparse.Namespace) -> int:
    with naming("--scene, --points"):
        world = World(load_scene(args.scene), args.points)
        require_points(len(world.body))
        grid_axes(world)
    told: dict = {}
    try:
        if args.what in ("speed", "all"):
            speed = _with_bar(
                "speed", lambda tell: benchmark.run(args.scene, args.points, args.full_loop, args.seed, tell)
            )
            told["speed"] = asdict(speed)
            if not args.json:
                print(speed_table(speed), flush=True)  # success takes minutes
        if args.what == "robustness":
            outcomes = _robustness(args)
            told["robustness"] = [asdict(outcome) for outcome in outcomes]
            if not args.json:
                print(f"{args.runs} random runs a case, seed {args.seed}, largest joint error to the demonstrator")
                print(robustness_table(outcomes))
        if args.what == "pictures":
            with naming("--scene"):
                require_eyes("rendered", world.scene)
            detected, servos = _pictures(args)
            told["pictures"] = {"detection": asdict(detected), "servos": {k: asdict(v) for k, v in servos.items()}}
            if not args.json:
                print(detection_table(detected))
                print(f"{args.runs} random runs, seed {args.seed}, largest joint error to the demonstrator")
                print(robustness_table(list(servos.values())))
        if args.what in ("success", "all"):
            results, pairs = _success(args, world.scene)
            told["success"] = [{"pairs": pairs, **asdict(result)} for result in results]
            if not args.json:
                print(success_table(results, pairs))
    except KeyboardInterrupt:
        print("viewimit bench: interrupted", file=sys.stderr)
        return INTERRUPTED
    if args.json:
        print_json(told)
    return DONE


def speed_table(found: benchmark.Benchmark) -> str:
    """The figures for people, each block against its first row, and with cond(A) against ours with it."""
    timed = "all postures" if found.loop_postures == found.postures else f"{found.loop_postures} postures, scaled"
    return "\n".join(
        [
            f"E over {found.postures} postures of {found.scene}, {found.points} points",
            "with kinematics and projection (CPU time on one thread, medians)",
            *_landscape_rows(found, timed),
            "one posture: fit, recovery, residual and E of given images, without kinematics and projection",
            *_posture_rows(found),
            f"one motion: a whole step with kinematics and projection, median of {benchmark.MOTIONS} from the start",
            *(
                f"  {f'{name}, {servo}':<60} {seconds * 1e6:9.0f} µs"
                for name, times in found.motion_s.items()
                for servo, seconds in times.items()
            ),
            "largest relative difference",
            f"  {'E to the batch, all postures':<60} {found.batch_agreement:9.1e}",
            f"  {f'E to the loop, {found.loop_postures} postures':<60} {found.loop_agreement:9.1e}",
            f"  {'cond(A) to the batch, all postures':<60} {found.condition_agreement:9.1e}",
        ]
    )


def _landscape_rows(found: benchmark.Benchmark, timed: str) -> list[str]:
    def row(what: str, seconds: float, against: float = found.landscape_s["epipolar"]) -> str:
        return f"  {what:<60} {seconds * 1e3:9.1f} ms  {seconds / against:8.1f} x"

    cv, with_condition = found.opencv, found.condition_s
    return [
        *(row(name, seconds) for name, seconds in found.landscape_s.items()),
        row("numpy batch: eigh and solve", found.batch_s),
        row(f"numpy loop: eigh and lstsq ({timed})", found.loop_s),
        row(f"OpenCV loop: perspective, another E ({timed})", cv.loop_s) if cv else f"  {found.opencv_why_not}",
        row("epipolar with cond(A)", with_condition, with_condition),
        row("numpy batch, without cond(A)", found.batch_s, with_condition),
        row("numpy batch with cond(A), eigvalsh of its AᵀA", found.batch_condition_s, with_condition),
    ]


def _posture_rows(found: benchmark.Benchmark) -> list[str]:
    def row(what: str, seconds: float, against: float = found.fit_s["epipolar"][1]) -> str:
        return f"  {what:<60} {seconds * 1e6:9.0f} µs  {seconds / against:8.1f} x"

    cv = found.opencv
    return [
        *(row(name, times[1]) for name, times in found.fit_s.items()),
        row("numpy batch of one: eigh and solve", found.batch_posture_s),
        row("numpy loop: eigh and lstsq", found.loop_posture_s),
        row("OpenCV: perspective, another E", cv.posture_s) if cv else f"  {found.opencv_why_not}",
        *(
            row(f"{name}, {count} postures together", seconds)
            for name, times in found.fit_s.items()
            for count, seconds in times.items()
            if count > 1
        ),
    ]


def success_table(results: list[success.Success], pairs: str) -> str:
    """For people: a block a target, then motions and claims."""
    named = {"own_minimum": "to the transfer's own minimum", "demonstrator": "to the demonstrator"}
    lines = [
        f"{pairs}, at most {results[0].max_motions} motions",
        "share of runs, largest joint error (in brackets the 95 % confidence interval)",
    ]
    for target in success.TARGETS:
        heads = [f"{what} ≤{near:g}°" for what in ("ended", "came") for near in success.WITHIN_DEG]
        lines.append(_line(named[target], "", *heads))
        for r in results:
            lines.append(
                _line(r.transfer, r.servo, *map(_share, (*r.ended[target].values(), *r.came[target].values())))
            )
    lines.append(_line("motions and claims", "", "median", "95 %", "claimed", "falsely, >3°"))
    for r in results:
        motions = f"{r.motions_median:.0f}", f"{r.motions_95:.0f}"
        lines.append(_line(r.transfer, r.servo, *motions, _share(r.claimed), _share(r.claimed_falsely)))
    lines.append("from the transfer's own minimum to the demonstrator")
    for r in {r.transfer: r for r in results}.values():
        lines.append(f"  {r.transfer:<12}median {r.bias_deg_median:.2f}°, 95 % within {r.bias_deg_95:.2f}°")
    return "\n".join(lines)


def _line(first: str, second: str, *cells: str) -> str:
    """A heading, which has no second word, or a row below it."""
    name = f"  {first:<12}{second:<18}" if second else f"{first:<32}"
    return name + "".join(f"{cell:>17}" for cell in cells)


def _share(share: success.Share) -> str:
    """97 % (93–99), the interval rounded outwards. All and none are said of all and none only."""
    text = f"{share.share:.0%}"
    if text == "100%" and share.count < share.runs:
        text = ">99%"
    elif text == "0%" and share.count > 0:
        text = "<1%"
    return f"{text[:-1]} % ({math.floor(100 * share.low)}–{math.ceil(100 * share.high)})"


def _success(args: argparse.Namespace, scene: Scene) -> tuple[list[success.Success], str]:
    """What was found, and from which pairs."""
    if args.grid:
        pairs = success.grid_pairs(scene, args.grid)
        what = f"{len(pairs)} starts on a grid over the whole range, the scene's demonstrator"
    else:
        pairs = success.random_pairs(scene, args.runs, args.seed)
        what = f"{len(pairs)} random starts and demonstrators over the whole range, seed {args.seed}"
    settings = Settings(scene=args.scene, points=args.points)
    results = []
    for transfers, servos in _asked(args):
        name = f"success, {', '.join(transfers)}"
        results += _with_bar(
            name,
            lambda tell: success.run(settings, pairs, transfers, servos, args.max_motions, tell=tell),  # noqa: B023
        )
    return results, f"{what}, {args.points} points of {args.scene}"


def _asked(args: argparse.Namespace) -> list[tuple[list[str], list[str]]]:
    """Transfers with the servos that run on them. The paper's law takes minutes, and is the paper's transfer's alone
    unless one of the two is asked for by name."""
    servos = [args.servo] if args.servo else list(SERVOS)
    if args.transfer or args.servo:
        return [([args.transfer] if args.transfer else list(TRANSFERS), servos)]
    others = [name for name in TRANSFERS if name != PAPER_TRANSFER]
    return [([PAPER_TRANSFER], servos), (others, [name for name in servos if not name.startswith("gradient")])]


def _robustness(args: argparse.Namespace) -> list[robustness.Outcome]:
    settings = Settings(
        scene=args.scene,
        points=args.points,
        transfer=args.transfer or BEST.transfer,
        servo=args.servo or BEST.servo,
    )
    return _with_bar("robustness", lambda tell: robustness.run(settings, runs=args.runs, seed=args.seed, tell=tell))


def _pictures(args: argparse.Namespace):
    """Detection, and the servos on points and on pictures, by transfer, servo and camera."""
    from ..experiments import detection  # loads pybullet and OpenCV

    detected = _with_bar("detection", lambda tell: detection.run(args.scene, args.runs, args.seed, tell))
    servos = {}
    for transfer in [args.transfer] if args.transfer else TRANSFERS:
        for servo in [args.servo] if args.servo else PICTURE_SERVOS:
            settings = Settings(scene=args.scene, points=args.points, transfer=transfer, servo=servo)
            cases = [robustness.Case(f"{transfer}, {servo}, {camera}", {"camera": camera}) for camera in CAMERAS]
            found = _with_bar(
                f"{transfer}, {servo}",
                lambda tell: robustness.run(settings, cases, args.runs, args.seed, tell=tell),  # noqa: B023
            )
            servos |= {outcome.case: outcome for outcome in found}
    return detected, servos


def detection_table(found) -> str:
    """For people."""
    median, p95, p99, largest = found.error_px
    fewest, typical = found.usable
    return "\n".join(
        [
            f"{found.pictures} pictures of {found.scene}, {found.markers} markers an arm, random postures",
            f"  in sight                     {found.in_sight:8.1%}",
            f"  found, of all                {found.found:8.1%}",
            f"  found, of those in sight     {found.found_in_sight:8.1%}",
            f"  error of the middle          median {median:.3f} px, 95 % {p95:.3f}, 99 % {p99:.3f}, "
            f"most {largest:.2f}",
            f"  of a coordinate              rms {found.rms_px:.3f} px, mean {found.bias_px[0]:+.3f}, "
            f"{found.bias_px[1]:+.3f}",
            f"  false identities             {found.false} of {found.detections}",
            f"  in all four pictures         median {typical:.0f}, fewest {fewest}",
        ]
    )


def robustness_table(outcomes: list[robustness.Outcome]) -> str:
    """For people: a row a case."""
    heads = ("rms", "ended ≤0.5°", "ended ≤1°", "motions", "95 %", "claimed", "falsely, >0.5°")
    widths = (9, 18, 18, 9, 7, 18, 16)
    lines = [" " * 34 + "".join(f"{head:>{width}}" for head, width in zip(heads, widths))]
    for o in outcomes:
        near = [_share(o.ended[degrees]) for degrees in (0.5, 1.0)]
        cells = (f"{o.rms_deg:.2f}°", *near, f"{o.motions_median:.0f}", f"{o.motions_95:.0f}", _share(o.claimed))
        cells += (_share(o.claimed_falsely),)
        lines.append(f"  {o.case:<32}" + "".join(f"{cell:>{width}}" for cell, width in zip(cells, widths)))
    return "\n".join(lines)


def _with_bar(name: str, work: Callable):
    """A bar on standard error if that is a terminal."""
    style = "{desc} {percentage:3.0f}% {bar} {elapsed}<{remaining}"
    with tqdm(total=1.0, desc=name, disable=None, leave=False, bar_format=style) as bar:
        return work(lambda share: bar.update(share - bar.n))
