"""viewimit imitate: one run of the loop."""

import argparse
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..analysis.self_assessment import Assessment, assess
from ..loop.history import MAX_HISTORY
from ..loop.self_calibration import SelfCalibration
from ..loop.session import Session
from ..loop.settings import Settings
from ..loop.snapshot import RunResult
from ..sensing.files import MAX_NAME_CHARS, escape
from ..servo import SERVOS
from . import BadInput, history_file
from .json_output import print_json
from .options import (
    DONE,
    MISSED,
    add_camera_option,
    add_json_option,
    add_run_options,
    add_safety_options,
    add_setting_options,
    add_undistort_option,
    between,
    figure,
    naming,
    posture,
    settings_from,
)

PAGES = (".html", ".htm")


def add_options(parser: argparse.ArgumentParser) -> None:
    add_setting_options(parser, Settings())
    add_undistort_option(parser)
    add_camera_option(parser)
    add_run_options(parser, Settings())
    add_safety_options(parser)
    number = between(int, 0, MAX_HISTORY)
    parser.add_argument("--max-motions", type=number, default=1000, metavar="N", help="%(default)s")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="write the history, a row a motion, as .csv or .npz, or all that is seen of it as one page, .html",
    )
    parser.add_argument("--body", type=Path, metavar="FILE", help="begin with what `viewimit rehearse` has kept there")
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    if args.out:
        with naming("--out"):
            history_file.require_format(args.out, PAGES)
            if args.body and args.out.exists() and args.body.exists() and args.out.samefile(args.body):
                raise ValueError(f"{args.out} is the rehearsal that --body reads: name another file")
    settings = settings_from(args, Settings())
    session = Session(settings)
    if args.body:
        _remember(session, args.body)
    ended = session.run(args.max_motions)
    if args.out:
        with naming("--out"):
            size = _write(args.out, session)
        print(f"written to {args.out}{size}", file=sys.stderr)
    result = outcome(session, ended)
    if args.json:
        print_json(args, result, settings)
    else:
        print(f"demonstrator  {posture(result['demonstrator_deg'])}")
        if result.get("rehearsal_holds") is False:
            print(
                "rehearsal     foretold too little: it has probed anew; rehearse again, more postures if nothing moved"
            )
        print(f"learner       {posture(result['final_deg'])} after {result['motions']} motions, {result['status']}")
        print(f"travel        {result['travel_deg']:.1f}°; joint by joint {_each(ended.joint_travel_deg)}")
        expected = result["expected_error_deg"]
        reckoned = f"; it expects {_at_least(expected, 0.1, '.2g', '°')}" if np.isfinite(expected or np.inf) else ""
        print(f"joint error   {_at_least(result['error_deg'], 0.01, '.3g', '°')} at most{reckoned}")
        untold = [escape(joint["name"], MAX_NAME_CHARS) for joint in result["joints"] if joint["told"] is False]
        if untold:
            print(f"not told      {', '.join(untold)}: what it has seen does not say where that is")
        if result["exchanged"]:
            named = " and ".join(f"{i} with {j}" for i, j in result["exchanged"])
            print(f"exchanged     points {named} of the demonstrator, as it seems")
        print(f"E             {_at_least(result['E'], 0.001, '.4g', ' px²')}")
    if result["converged"]:
        return DONE
    print(f"viewimit imitate: not converged after {result['motions']} motions: {ended.message}", file=sys.stderr)
    return MISSED


def _write(path: Path, session: Session) -> str:
    """By its extension → how large it is, if that is for somebody to be sent. Raises OSError."""
    if path.suffix.lower() in PAGES:
        from ..drawing.export.replay import replay  # it loads all that draws

        return f", {replay(session).save(path) / 1e6:.2f} MB"
    history_file.write(path, session.history)
    return ""


def _remember(session: Session, path: Path) -> None:
    """Raises BadInput for a file that is none, of another body, or of no use to the servo."""
    servo = session.settings.servo
    if not SERVOS[servo].predicts:
        able = ", ".join(name for name, found in SERVOS.items() if found.predicts)
        raise BadInput(f"--body: {servo} learns from its own motions alone; --servo {able} begins with a rehearsal")
    with naming("--body"):
        body = SelfCalibration.load(path)
        try:
            session.use_calibration(body)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None


def _each(angles_deg: NDArray) -> str:
    return ", ".join(f"{angle:.1f}°" for angle in angles_deg)


def _at_least(value: float, least: float, form: str, unit: str) -> str:
    """Digits below `least` are the machine's, not the method's."""
    return f"below {least:g}{unit}" if value < least else figure(value, form, unit)


def _told(known: Assessment | None, joint: int) -> bool | None:
    """Whether its points tell a joint, by index; None where the visits that there are leave that open."""
    if known is None:
        return None
    if known.certificate.observable[joint]:
        return True
    return False if joint in known.unobservable else None


def outcome(session: Session, ended: RunResult) -> dict:
    """`converged`, `expected_error_deg` and `told` are the learner's own claims; `error_deg`, of the worst joint, is
    true; `travel_deg` sums the joint that moved most in each motion, or one joint's motions."""
    last, known = session.snapshot, assess(session)
    expected = None if known is None else known.certificate.std_error
    rehearsed = {}
    if last.calibration is not None:
        rehearsed = {"rehearsed": len(last.calibration), "rehearsal_holds": last.calibration_holds}
    return {
        "final_deg": np.degrees(last.theta),
        "demonstrator_deg": np.degrees(last.theta_demo),
        "error_deg": np.degrees(np.max(np.abs(last.theta - last.theta_demo))),
        "expected_error_deg": None if known is None else np.degrees(known.certificate.simultaneous_std_error),
        "joints": [
            {
                "name": f"theta{joint}",
                "deg": np.degrees(last.theta[k]),
                "expected_error_deg": None if expected is None else np.degrees(expected[k]),
                "told": _told(known, k),
                "travel_deg": ended.joint_travel_deg[k],
            }
            for k, joint in enumerate(session.scene.moving_joints)
        ],
        "exchanged": last.exchanged,
        "E": last.E,
        "motions": last.motion,
        "travel_deg": ended.travel_deg,
        **rehearsed,
        "converged": last.status.is_claim,
        "status": last.status,
        "history": [
            {"theta_deg": np.degrees(past.theta), "E": past.E, "probe": past.probe} for past in session.history
        ],
    }
