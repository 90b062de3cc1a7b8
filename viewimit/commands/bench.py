"""viewimit bench: how fast E is, and how often and how soon each servo arrives."""

import argparse
from dataclasses import asdict

from ..experiments import benchmark, success
from ..servo import SERVOS
from ..session import MAX_HISTORY
from ..transfer import TRANSFERS
from .options import DONE, add_json_option, between, naming, print_json


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", nargs="?", choices=("speed", "success", "all"), default="all", help="%(default)s")
    speed = parser.add_argument_group("speed, of the landscape of E")
    speed.add_argument("--scene", default="panda", help="by name or path (%(default)s)")
    speed.add_argument("--points", type=int, default=10, metavar="N", help="layout of the scene (%(default)s)")
    seed = between(int, 0, 2**32)
    speed.add_argument("--seed", type=seed, default=0, metavar="N", help="of the postures timed (%(default)s)")
    speed.add_argument("--full-loop", action="store_true", help="time the plain loop on every posture, not a tenth")
    runs = parser.add_argument_group("success, of every transfer and servo from a grid of starts")
    number = between(int, 0, MAX_HISTORY)
    runs.add_argument("--servo", choices=SERVOS, help="this one only")
    runs.add_argument("--grid", type=grid, default=(10, 13), metavar="N,N", help="starts a joint (10,13)")
    runs.add_argument("--max-motions", type=number, default=100, metavar="N", help="%(default)s")
    add_json_option(parser)


def grid(text: str) -> tuple[int, int]:
    """A type for argparse: starts of both joints."""
    counts = [between(int, 1, 1000)(word) for word in text.split(",")]
    if len(counts) != 2:
        raise argparse.ArgumentTypeError(f"needs two numbers such as 10,13, got {text!r}")
    return counts[0], counts[1]


def run(args: argparse.Namespace) -> int:
    told: dict = {}
    if args.what in ("speed", "all"):
        with naming("--scene, --points"):
            speed = benchmark.run(args.scene, args.points, args.full_loop, args.seed)
        told["speed"] = asdict(speed)
        if not args.json:
            print(benchmark.table(speed))
    if args.what in ("success", "all"):
        servos = [args.servo] if args.servo else SERVOS
        pairs = [(transfer, servo) for transfer in TRANSFERS for servo in servos]
        results = [success.run(*pair, args.grid, args.max_motions) for pair in pairs]
        told["success"] = [asdict(result) for result in results]
        if not args.json:
            print(success.table(results))
    if args.json:
        print_json(told)
    return DONE
