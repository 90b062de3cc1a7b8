"""viewimit serve: the page."""

import argparse
from pathlib import Path

from viewimit.options import ARM, DONE, SCENE, SIGHT, add_address, add_settings, between, naming, settings_from

from . import add_repeated


def add_options(parser: argparse.ArgumentParser) -> None:
    add_address(parser)
    parser.add_argument("--max-clients", type=between(int, 1, 10_000), default=40, help="tabs at a time (%(default)s)")
    parser.add_argument(
        "--max-per-address",
        type=between(int, 1, 10_000),
        metavar="N",
        help="tabs at a time from one address (all but a tenth of --max-clients, so that a class behind one router has "
        "room; less where every machine has an address of its own; behind a proxy elsewhere, as --max-clients)",
    )
    elsewhere = "a page elsewhere that may connect, such as https://class.example.org of a proxy"
    add_repeated(parser, "--origin", "URL", elsewhere)
    own = "a lesson of your own, offered instead of the tour (docs/teach/lesson-format.md)"
    add_repeated(parser, "--lesson", "FILE", own, type=Path)
    parser.add_argument("--open", action="store_true", help="open the page in the default browser")
    add_settings(parser, *SCENE, "demonstrator_deg", "transfer", "rectify", *SIGHT, *ARM, "servo")


def run(args: argparse.Namespace) -> int:
    settings = settings_from(args)
    # the one place below the page that knows it
    from ..lab.lessons.source import own
    from ..server.address import require_origin
    from ..server.limits import Limits, ServerOptions
    from ..server.serve import serve, usual_per_address

    with naming("--origin"):
        for origin in args.origin:
            require_origin(origin)
    with naming("--lesson"):
        lessons = own(args.lesson)
    of_one = args.max_per_address or usual_per_address(args.host, args.max_clients)
    limits = Limits(args.max_clients, of_one)
    with naming("--host, --port"):
        serve(ServerOptions(settings, limits, tuple(args.origin), lessons, args.host), args.port, args.open)
    return DONE
