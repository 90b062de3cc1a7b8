"""viewimit serve: the page."""

import argparse
import sys
from pathlib import Path

from .options import DONE, MISSED, add_run_options, add_setting_options, between, naming, settings_from


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="address to listen on (%(default)s, this machine alone); 0.0.0.0 lets everybody in who is on its network",
    )
    parser.add_argument("--port", type=between(int, 0, 65535), default=8080, help="0 takes a free one (%(default)s)")
    parser.add_argument("--max-clients", type=between(int, 1, 10_000), default=40, help="tabs at a time (%(default)s)")
    parser.add_argument(
        "--origin",
        action="append",
        default=[],
        metavar="URL",
        help="a page elsewhere that may connect, such as https://class.example.org of a proxy; more than once for more",
    )
    parser.add_argument(
        "--store",
        metavar="DIR|URL",
        help="where sessions are kept for visitors who come back: a folder (the user's own), or redis://HOST:PORT",
    )
    parser.add_argument(
        "--workers",
        type=between(int, 1, 64),
        help="processes that share the visitors (1 on this machine alone, else one a core, 4 at most)",
    )
    parser.add_argument(
        "--lesson",
        action="append",
        default=[],
        type=Path,
        metavar="FILE",
        help="a lesson of your own, offered in place of the tour; more than once for more (docs/lessons.md)",
    )
    parser.add_argument("--open", action="store_true", help="open the page in the default browser")
    add_setting_options(parser)
    add_run_options(parser)


def run(args: argparse.Namespace) -> int:
    settings = settings_from(args)
    from ..app.lessons.source import own  # the one place below the page that knows it
    from ..app.serve import ServerOptions, serve, usual_workers
    from ..app.sessions.stores import open_store

    with naming("--store"):
        open_store(args.store).close()
    with naming("--lesson"):
        lessons = own(args.lesson)
    workers = args.workers or usual_workers(args.host)
    options = ServerOptions(settings, args.store, args.max_clients, tuple(args.origin), workers, lessons)
    try:
        with naming("--host, --port, --workers"):
            serve(args.host, args.port, options, open_browser=args.open)
    except RuntimeError as error:
        print(f"viewimit: {error}", file=sys.stderr)
        return MISSED
    return DONE
