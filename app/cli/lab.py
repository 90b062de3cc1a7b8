"""viewimit lab: the method in the browser, written as one file that needs no server."""

import argparse
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from viewimit.options import DONE, BadInput, add_chain_options, choose_bodies, naming

from . import add_repeated

if TYPE_CHECKING:
    from ..ways import Ways

MB = 1_000_000


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scene", metavar="NAME", help="a name, or the path of a .toml or .urdf file (panda)")
    parser.add_argument(
        "--robot", metavar="NAME", help="a name, a .urdf or a .toml file; replaces the robot of --scene"
    )
    add_chain_options(parser)
    which = "a page of lessons instead: a name (ray, tour, limits, jacobian, motion, sign) or the path of a .toml file"
    add_repeated(parser, "--lesson", "NAME", which)
    linked = "the address of a site that `viewimit site` has written, to which the page links"
    parser.add_argument("--site", metavar="URL", help=linked)
    parser.add_argument("--out", type=Path, metavar="FILE", default=Path("lab.html"), help="write it there (lab.html)")


def run(args: argparse.Namespace) -> int:
    if args.out.suffix.lower() not in (".html", ".htm"):
        raise BadInput(f"--out: {args.out} must end in .html")
    if args.site is not None and not re.match(r"https?://", args.site):
        raise BadInput(f"--site: {args.site} must begin with https:// or http://")
    page = (_lessons if args.lesson else _lab)(args).encode()
    with naming("--out"):
        args.out.write_bytes(page)
    print(f"written to {args.out}, {len(page) / MB:.2f} MB: open it in a browser", file=sys.stderr)
    return DONE


def _lessons(args: argparse.Namespace) -> str:
    from ..lab.lessons.page import lesson_page
    from ..lab.lessons.source import find

    if args.scene is not None or args.robot is not None:
        raise BadInput("--lesson: a lesson says itself which scene and robot it shows; leave --scene and --robot out")
    with naming("--lesson"):
        return lesson_page(dict(map(find, args.lesson)), ways=_ways(args))


def _lab(args: argparse.Namespace) -> str:
    from viewimit.simulation.scene import load_scene

    from ..lab.page import SHIPPED, lab_page

    with naming(choose_bodies(args)):
        own = args.scene is not None or args.robot is not None
        scene = load_scene(args.scene or SHIPPED, args.robot) if own else None
        return lab_page(scene, args.scene or SHIPPED, _ways(args))


def _ways(args: argparse.Namespace) -> "Ways":
    """Where the page's header leads: nowhere without a site."""
    from ..ways import Ways

    return Ways() if args.site is None else Ways.of_site(args.site.rstrip("/") + "/")
