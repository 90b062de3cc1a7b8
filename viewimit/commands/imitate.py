"""viewimit imitate: one run of the loop."""

import argparse
import csv
import sys
from pathlib import Path

import numpy as np

from .. import options
from ..analysis.results import figure, naming_words, outcome, posture
from ..drawing.svg import count_motions
from ..loop.history import MAX_HISTORY
from ..loop.self_calibration import SelfCalibration
from ..loop.session import Session
from ..loop.settings import FIELDS, SAFETY, Settings, option
from ..loop.snapshot import RunResult
from ..sensing.files import MAX_NAME_CHARS, escape
from ..servo import SERVOS, verdict
from .json_output import print_json

PAGES, TABLES = (".html", ".htm"), (".csv", ".npz")
TABLE_DIGITS = 12  # significant, of a number in a .csv table: fewer than conversion to degrees rounds


def add_options(parser: argparse.ArgumentParser) -> None:
    seen = ("demonstrator_deg", "transfer", "rectify", *options.SIGHT, "undistort", "sensor", "dynamics")
    options.add_settings(parser, *options.SCENE, *seen, *options.ARM, "servo", *SAFETY, defaults=Settings())
    unnamed = "the demonstrator's points come in an unknown order; find out which is which"
    parser.add_argument("--unmatched", dest="matched", action="store_false", default=None, help=unnamed)
    number = options.between(int, 0, MAX_HISTORY)
    parser.add_argument("--max-motions", type=number, default=1000, metavar="N", help="%(default)s")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="write the history, a row for each step, as .csv or .npz, or a replay of the run as one page, .html",
    )
    parser.add_argument(
        "--calibration", type=Path, metavar="FILE", help="begin with what `viewimit rehearse` has written to this file"
    )
    parser.add_argument(
        "--link",
        metavar="QUERY",
        help="play what a link of the page or of the lab holds, such as 'demo=45,-90&steps=8'",
    )
    options.add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    out, calibration = args.out, args.calibration
    if out:
        with options.naming("--out"):
            if out.suffix.lower() not in (*TABLES, *PAGES):
                known = ", ".join((*TABLES, *PAGES))
                raise ValueError(f"{out}: unknown extension {out.suffix.lower()!r}; there are {known}")
            if calibration and out.exists() and calibration.exists() and out.samefile(calibration):
                raise ValueError(f"{out} is the rehearsal that --calibration reads: name another file")
    if args.link is not None:
        with options.naming("--link"):
            session, ended = _played(args)
        settings = session.settings
    else:
        settings = options.settings_from(args, Settings())
        session = Session(settings)
        if calibration:
            _use_calibration(session, calibration)
        ended = session.run(args.max_motions)
    if out:
        with options.naming("--out"):
            size = _write(out, session)
        print(f"written to {out}{size}", file=sys.stderr)
    result = outcome(session, ended)
    if args.json:
        print_json(args, result, settings)
    else:
        _report(result, verdict(ended.status).label.lower())
    if result["converged"]:
        return options.DONE
    tell(ended)
    return options.MISSED


def _played(args: argparse.Namespace) -> tuple[Session, RunResult]:
    """Play a link; one without a step goes on to its end. Raises ValueError."""
    from viewimit.app.model.link import read_link  # it knows the presets

    others = [option(name) for name in (*FIELDS, "calibration") if vars(args).get(name) is not None]
    if others:
        raise ValueError(f"it says all settings: leave out {', '.join(others)}")
    script = read_link(args.link.partition("?")[2] or args.link.partition("#")[2] or args.link, Settings()).script
    session = Session(script.settings)
    session.play(script)
    if not session.snapshot.motion:
        return session, session.run(args.max_motions)
    moved = np.abs([past.moved for past in session.history[1:]])
    return session, RunResult(
        len(moved), float(moved.max(-1).sum()), moved.sum(0), session.snapshot, session.scene.moving_joints
    )


def tell(ended: RunResult) -> None:
    """Say how a run ended, as every front end does."""
    print(f"viewimit imitate: {verdict(ended.status).label}. {ended.message}", file=sys.stderr)


def _report(result: dict, label: str) -> None:
    print(f"demonstrator  {posture(result['demonstrator_deg'])}")
    if result.get("rehearsal_holds") is False:
        print("rehearsal     predicted too little: it has probed again; rehearse again, more poses if nothing moved")
    print(f"learner       {posture(result['final_deg'])} after {count_motions(result['motions'])}: {label}")
    by_joint = ", ".join(f"{joint['travel_deg']:.1f}°" for joint in result["joints"])
    print(f"travel        {result['travel_deg']:.1f}°; joint by joint {by_joint}")
    expected = result["std_error_deg"]
    estimate = (
        f"; its own estimate is {_at_least(expected, 0.1, '.2g', '°')}" if np.isfinite(expected or np.inf) else ""
    )
    print(f"joint error   {_at_least(result['error_deg'], 0.01, '.3g', '°')} at most{estimate}")
    unobservable = [escape(joint["name"], MAX_NAME_CHARS) for joint in result["joints"] if joint["observable"] is False]
    if unobservable:
        print(f"unobservable  {', '.join(unobservable)}: the points do not determine these joints")
    if result.get("naming"):
        print(f"names         {naming_words(result['naming'])}")
    if result["exchanged"]:
        named = " and ".join(f"{i} with {j}" for i, j in result["exchanged"])
        print(f"swapped       points {named} of the demonstrator, probably")
    if result["misfit"]:
        print(f"misfit        {result['misfit']['text']}")
    print(f"E             {_at_least(result['E'], 0.001, '.4g', ' px²')}")


def _write(path: Path, session: Session) -> str:
    """Write by extension; return a page's size in words. Raises OSError."""
    if path.suffix.lower() in PAGES:
        from ..app.lab.replay import replay  # it loads the drawing code

        return f", {replay(session).save(path) / 1e6:.2f} MB"
    if path.suffix.lower() == ".npz":
        with path.open("wb") as file:  # numpy would add the extension to a name that ends in .NPZ
            np.savez(file, **session.history.arrays())  # type: ignore[arg-type]
        return ""
    rows = session.history.table()
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(rows[0])
        table.writerows(
            [f"{value:.{TABLE_DIGITS}g}" if isinstance(value, float) else value for value in row.values()]
            for row in rows
        )
    return ""


def _use_calibration(session: Session, path: Path) -> None:
    """Raises BadInput for another kind of file, another body, or a servo that makes no use of it."""
    servo = session.settings.servo
    if not SERVOS[servo].predicts:
        able = ", ".join(name for name, found in SERVOS.items() if found.predicts)
        words = f"{servo} learns from its own steps alone; --servo {able} begins with a rehearsal"
        raise options.BadInput(f"--calibration: {words}")
    with options.naming("--calibration"):
        calibration = SelfCalibration.load(path)
        try:
            session.use_calibration(calibration)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None


def _at_least(value: float, least: float, form: str, unit: str) -> str:
    """A number in words, without digits below `least`, which differ between machines."""
    return f"below {least:g}{unit}" if value < least else figure(value, form, unit)
