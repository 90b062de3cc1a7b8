"""The command line: degrees at this surface, radians behind it.

Exit status 0: done; 1: ran, but did not reach its target; 2: bad input, or the output cannot be written; 130:
interrupted; 141: nobody reads the output. With --json exactly one JSON object goes to standard output, and all
messages to standard error.
"""

import argparse
import errno
import importlib
import io
import os
import re
import sys
import warnings
from collections.abc import Iterable
from typing import NoReturn

from .. import __version__
from ..geometry import limit_blas_threads

BAD_INPUT = 2
NEWLINE = "\n"
UNREAD = 141  # as of a program that ends by SIGPIPE
COMMANDS = {
    "serve": "Serve the page; the options set the defaults of a new tab.",
    "imitate": "Run the loop once, without a page.",
    "lab": "The method in the browser, or its lessons: one file that needs no server, to open, send or embed.",
    "exam": "The eight questions of the lessons as exam items, for Moodle and other learning platforms.",
    "class": "Lessons for a class: a lecturer asks and leads, students' own devices compute.",
    "rehearse": "Record the learner's own body in several postures, without a demonstrator, for imitate --calibration.",
    "scene": "Write a scene file for a URDF, to be edited.",
    "landscape": "E over the range of the two moving joints. Disturbances apply to the images of the demonstrator.",
    "reproduce": "Reproduce the paper's experiments: figures, data, and a comparison with the paper's numbers.",
    "markers": "A sheet of square markers to print, for both arms; detect finds them.",
    "detect": "Find markers in your own pictures or videos; write a table of points.",
    "evaluate": "Evaluate the method on your own tracked points: which transfer fits, residuals, E. "
    "Compare E only between images of like size.",
    "bench": "Measure speed, and how often and how soon each servo arrives.",
    "site": "Write lab, lessons and documentation as a folder that any web server can publish.",
    "docs": "Open the documentation in a browser.",
}

MODULES = {name: f"..app.cli.{name}" for name in ("serve", "lab", "exam", "site", "docs")} | {
    "class": "..app.cli.class_"
}  # of those that are not beside this file


def main(argv: list[str] | None = None) -> int:
    """Run one command and return its exit status. `viewimit` alone serves the page."""
    limit_blas_threads()
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed, as by daemons, or of a program without a console
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a console of another encoding, or a file, may lack ≤ and −
    argv = list(sys.argv[1:] if argv is None else argv)
    if not argv or (argv[0].startswith("-") and argv[0] not in ("-h", "--help", "--version")):
        argv.insert(0, "serve")
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *where: print(f"viewimit {argv[0]}: {message}", file=sys.stderr)
        return _run(argv)


def _run(argv: list[str]) -> int:
    args = parser_of(argv[0]).parse_args(attached(argv))
    from ..options import BadInput  # it loads numpy, which the number of threads has to precede
    from ..sensing.files import escape

    try:
        status = args.run(args)
        sys.stdout.flush()
        return status
    except BadInput as error:
        print(f"viewimit {args.command}: {escape(str(error), keep=NEWLINE)}", file=sys.stderr)
        return BAD_INPUT
    except BrokenPipeError:
        _print_no_more()
        return UNREAD
    except OSError as error:
        if error.errno == errno.EINVAL and sys.platform == "win32":  # what it says of a pipe that nobody reads
            _print_no_more()
            return UNREAD
        if error.errno != errno.ENOSPC:
            raise
        _print_no_more()
        print(f"viewimit {args.command}: cannot print: {error.strerror}", file=sys.stderr)
        return BAD_INPUT


def _print_no_more() -> None:
    """Redirect standard output to nothing: Python would write the rest again at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _StoreOnce(argparse.Action):
    """Stores a value; an option that is given twice, of which one value would be lost, is an error."""

    stored_in: argparse.Namespace | None = None

    def __call__(self, parser, namespace, values, option_string=None):
        if self.option_strings and self.stored_in is namespace:
            raise argparse.ArgumentError(self, "it is given twice, and one value counts: leave the other out")
        self.stored_in = namespace
        setattr(namespace, self.dest, values)


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        for action in (None, "store"):
            self.register("action", action, _StoreOnce)

    def parse_args(self, args=None, namespace=None):
        """Parse as argparse does, but name the command whose option is unknown."""
        found, unknown = self.parse_known_args(args, namespace)
        if unknown:
            given = vars(found)
            self.prog = " ".join(filter(None, (self.prog, given.get("command"), given.get("benchmark"))))
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return found

    def error(self, message: str) -> NoReturn:
        from ..sensing.files import escape

        self.exit(BAD_INPUT, f"{self.prog}: {escape(message)}; see {self.prog} --help\n")


def parser_of(chosen: str) -> argparse.ArgumentParser:
    """Make a parser that lists all commands, and loads only the chosen one."""
    top = Parser(prog="viewimit", description="View-based imitation. Alone: serve.", allow_abbrev=False)
    top.add_argument("--version", action="version", version=f"viewimit {__version__}")
    commands = top.add_subparsers(dest="command", metavar="command", required=True)
    for name, text in COMMANDS.items():
        parser = commands.add_parser(name, help=text, description=text, allow_abbrev=False)
        if name == chosen:
            module = importlib.import_module(MODULES.get(name, f".{name}"), __package__)
            module.add_options(parser)
            parser.set_defaults(run=module.run)
    return top


TAKE_NUMBERS = ("--demonstrator", "--start", "--undistort", "--lens", "--lens-left", "--lens-right", "--workspace-deg")


def attached(argv: Iterable[str]) -> list[str]:
    """Write `--start -20,30` as `--start=-20,30`, for argparse takes such a list of angles for an option."""
    joined: list[str] = []
    for word in argv:
        if joined and joined[-1] in TAKE_NUMBERS and re.match(r"-[\d.]", word):
            joined[-1] += "=" + word
        else:
            joined.append(word)
    return joined


if __name__ == "__main__":
    sys.exit(main())
