"""viewimit class: lessons for a class, which a lecturer leads."""

import argparse
import asyncio
import logging
import os
import secrets
import sys
import time
from pathlib import Path
from urllib.parse import urlsplit

import platformdirs

from viewimit.options import DONE, MISSED, BadInput, add_address, naming
from viewimit.sensing.files import escape

from . import add_repeated

CODE = "VIEWIMIT_LECTURER"  # environment variable: the lecturer's code, instead of a random one
LETTERS = "abcdefghjkmnpqrstuvwxyz23456789"  # without those that look alike
LETTERS_OF_A_CODE = 8
MIN_CODE = 8  # letters of a code of one's own
CONTINUED_S = 6 * 3600  # a file without a name of its own is continued if its class was so long ago at most


def add_options(parser: argparse.ArgumentParser) -> None:
    add_address(parser)
    which = "a lesson of the class: a shipped one by its name, or a .toml file of your own (all shipped ones)"
    add_repeated(parser, "--lesson", "NAME|FILE", which)
    kept = (
        "SQLite file that keeps the answers over a restart (one for each port, in the user's own data folder; a file of"
        " more than six hours ago is set aside)"
    )
    parser.add_argument("--data", type=Path, metavar="FILE", help=kept)
    parser.add_argument("--new-code", action="store_true", help="forget a lecturer's code that was chosen on the page")
    framing = "a site whose pages may show the class in a frame, such as https://moodle.example.org"
    add_repeated(parser, "--embed", "ORIGIN", framing)
    typed = "what students type, behind a proxy or under a name: printed, in the QR code, and accepted as an origin"
    parser.add_argument("--address", metavar="URL", help=typed)
    believed = "proxies, separated by commas, whose X-Forwarded-For is believed; * for any (none)"
    parser.add_argument("--trust-proxy", default="", metavar="ADDRESS", help=believed)


def run(args: argparse.Namespace) -> int:
    from ..classroom.room import Room
    from ..classroom.server import ClassServer, class_pages
    from ..classroom.store import Store
    from ..classroom.votes import asks_of
    from ..lab.lessons.source import find, shipped
    from ..server.address import listen, require_free, require_origin

    with naming("--address"):
        typed = urlsplit(args.address or "")
    origins = () if args.address is None else (f"{typed.scheme}://{typed.netloc}".lower(),)
    for option, given in (("--embed", args.embed), ("--address", origins)):
        with naming(option):
            for origin in given:
                require_origin(origin)
    with naming("--lesson"):
        lessons = dict(map(find, args.lesson)) if args.lesson else shipped()
        pages = class_pages(lessons, args.embed)
    with naming("--data"):
        path = args.data or _usual_file(args.port)
        store = Store(path)
    code = os.environ.get(CODE) or "".join(secrets.choice(LETTERS) for _ in range(LETTERS_OF_A_CODE))
    room = Room(store, code, asks_of(lessons), is_new_code=args.new_code)
    if CODE in os.environ:
        if len(code) < MIN_CODE:
            raise BadInput(f"{CODE}: a code has {MIN_CODE} letters or more")
    elif not (sys.stdout.isatty() or room.has_own_code):
        raise BadInput(f"no terminal to print the lecturer's code on: set it in the environment variable {CODE}")
    try:
        with naming("--host, --port"):
            require_free(args.host, args.port)
            listeners = listen(args.host, args.port)
    except RuntimeError as error:
        print(f"viewimit: {escape(str(error))}", file=sys.stderr)
        return MISSED
    logging.basicConfig(format="%(asctime)s %(message)s", datefmt="%H:%M:%S", stream=sys.stderr)
    room.address = _invite(args, listeners[0].getsockname()[1])
    _say_code(room.has_own_code, code)
    print(f"answers are kept in {path}" + (f"; it has {len(found)} already" if (found := store.answers()) else ""))
    sys.stdout.flush()
    asyncio.run(ClassServer(room, pages, origins, args.trust_proxy).run(listeners))
    return DONE


def _usual_file(port: int) -> Path:
    """The file of this port. One of a class of another day is set aside."""
    folder = platformdirs.user_data_path("viewimit", appauthor=False, ensure_exists=True)
    path = folder / f"class-{port}.sqlite"
    if path.exists() and time.time() - (last := path.stat().st_mtime) > CONTINUED_S:
        day = time.strftime("%Y-%m-%d-%H%M", time.localtime(last))
        for part in folder.glob(f"{path.name}*"):  # with what SQLite keeps beside it
            part.rename(folder / f"class-{port}-{day}{part.name.removeprefix(path.stem)}")
    return path


def _invite(args: argparse.Namespace, port: int) -> str:
    """Print and return what students open, with a QR code where others can reach it."""
    from ..server.address import address, address_for_others, print_qr

    others = args.address or address_for_others(args.host, port)
    print(f"the class is at {address(args.host, port)}/")
    if others is None:
        print("only this machine reaches it; --host 0.0.0.0 admits everybody on its network")
        return ""
    others = others if args.address else f"{others}/"
    print(f"students open {others}")
    print_qr(others)
    return others


def _say_code(has_own: bool, code: str) -> None:
    """Print the lecturer's code, on a terminal alone: what is written elsewhere, others may read."""
    if has_own:
        print("the lecturer's code is the one chosen on the page; --new-code forgets it")
    elif CODE in os.environ:
        print(f"the lecturer's code is what {CODE} holds")
    else:
        print(f'the lecturer\'s code is {code}: type it on the page, at "Lecturer"')
