"""viewimit lab: the method in the browser, written as one file that needs no server."""

import argparse
import sys
from pathlib import Path

from . import BadInput
from .options import DONE, naming

MB = 1_000_000


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scene", metavar="NAME", help="a name, or the path of a .toml or .urdf file (panda)")
    parser.add_argument("--robot", metavar="NAME", help="replaces the scene's: a name, or the path of a .urdf file")
    parser.add_argument("--out", type=Path, metavar="FILE", default=Path("lab.html"), help="write it there (lab.html)")


def run(args: argparse.Namespace) -> int:
    from ..app.lab.page import SHIPPED, lab_page
    from ..simulation.scene import load_scene

    if args.out.suffix.lower() not in (".html", ".htm"):
        raise BadInput(f"--out: {args.out} must end in .html")
    with naming("--scene"):
        own = args.scene is not None or args.robot is not None
        scene = load_scene(args.scene or SHIPPED, args.robot) if own else None
        page = lab_page(scene, args.scene or SHIPPED).encode()
    with naming("--out"):
        args.out.write_bytes(page)
    print(f"written to {args.out}, {len(page) / MB:.2f} MB: open it in a browser", file=sys.stderr)
    return DONE
