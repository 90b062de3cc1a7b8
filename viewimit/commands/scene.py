"""viewimit scene: a scene made for a robot of which only the URDF is known, as a file to be edited."""

import argparse
import dataclasses
import os
import sys
from pathlib import Path

import msgspec

from .. import options
from ..simulation.scene import MAX_CHOSEN_JOINTS, load_robot, load_scene, scene_for_urdf
from ..simulation.scene_writing import scene_file
from ..simulation.urdf.reference import is_reference, parse_reference
from .json_output import print_json


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="URDF", help="the path of a .urdf file, or a name of robot_descriptions")
    options.add_chain_options(parser)
    parser.add_argument(
        "--joints",
        type=options.joints,
        metavar="N,N",
        help="moving joints, from 1, or all (the two that move the image most)",
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="write it there, as .toml (to standard output)")
    options.add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    if args.out and args.out.suffix.lower() != ".toml":
        raise options.BadInput(f"--out: {args.out} must end in .toml")
    with options.naming("URDF"):
        name = options.robot_reference(args) or ""
        if not is_reference(name):
            raise ValueError(
                f"{name} is no .urdf file; the scenes of shipped robots are in the package's assets/scenes"
            )
        chosen = scene_for_urdf(name)
    with options.naming("--joints"):
        moving = options.all_joints(name) if args.joints == options.ALL else args.joints
        chosen = scene_for_urdf(name, moving) if moving and len(moving) <= MAX_CHOSEN_JOINTS else chosen
        scene = load_scene(name, joints=moving)
    options.tell_choices(chosen, scene)
    fields = msgspec.to_builtins(scene)
    for eye in ("left", "right"):
        del fields["head"][eye]
    fields["robot"] = _relative_robot(args.out, name)
    if args.json:
        print_json(args, {"scene": fields})
    text = scene_file(fields, load_robot(name), "Made from a URDF by `viewimit scene`: edit it, and use it by --scene")
    if args.out:
        with options.naming("--out"):
            args.out.write_text(text, encoding="utf-8")
        print(f"written to {args.out}", file=sys.stderr)
    elif not args.json:
        print(text, end="")
    return options.DONE


def _relative_robot(out: Path | None, name: str) -> str:
    """The robot with its paths from the folder of the scene file, or from the current folder."""
    found = parse_reference(name)
    if out is None:
        return name
    below = lambda path: Path(os.path.relpath(path, out.parent))
    meshes = None if found.meshes is None else below(found.meshes)
    return str(dataclasses.replace(found, path=below(found.path), meshes=meshes))
