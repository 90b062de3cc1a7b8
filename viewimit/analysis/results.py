"""What commands tell of a run, of names and of a misfit: plain data for JSON, and the same in words."""

from collections.abc import Iterable, Sequence

import numpy as np

from ..loop.session import Session
from ..loop.snapshot import RunResult
from ..servo import Misfit, Naming
from .self_assessment import assess


def outcome(session: Session, ended: RunResult) -> dict:
    """The JSON object of a run.

    `converged`, `std_error_deg` and `observable` are the learner's own claims; `error_deg`, of the worst joint, is the
    truth. `travel_deg` sums the joint that moved most in each motion, or one joint's motions.
    """
    last = session.snapshot
    found = assess(session) if last.certificate is None else None
    known = last.certificate if found is None else found.certificate
    rehearsed: dict = {} if last.settings.matched else {"naming": naming_json(last.naming)}
    if last.calibration is not None:
        rehearsed |= {"rehearsed": len(last.calibration), "rehearsal_holds": last.calibration_holds}
    return {
        "final_deg": np.degrees(last.theta),
        "demonstrator_deg": np.degrees(last.theta_demo),
        "error_deg": np.degrees(np.max(np.abs(last.theta - last.theta_demo))),
        "std_error_deg": None if known is None else np.degrees(known.simultaneous_std_error),
        "joints": [
            {
                "name": f"theta{joint}",
                "deg": np.degrees(last.theta[k]),
                "std_error_deg": None if known is None else np.degrees(known.std_error[k]),
                "observable": None if known is None else bool(known.observable[k]),
                "travel_deg": ended.joint_travel_deg[k],
            }
            for k, joint in enumerate(session.scene.moving_joints)
        ],
        "exchanged": last.exchanged,
        "misfit": misfit_json(last.misfit, session.scene.moving_joints),
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


def naming_json(naming: Naming | None) -> dict | None:
    """What was found about the names of the demonstrator's points, as JSON; None if they were never searched for."""
    if naming is None:
        return None
    return {
        "accepted": naming.accepted,
        "names": naming.names if naming.accepted else None,
        "probability": naming.probability,
        "certain": naming.certain,
        "without_partner": {"learner": np.flatnonzero(naming.names < 0), "demonstrator": naming.unnamed},
        "two_answers": naming.is_ambiguous,
        "E": naming.E,
        "E_noise": naming.E_noise,
    }


def misfit_json(misfit: Misfit | None, joints: Sequence[int], names: Sequence[str] = ()) -> dict | None:
    """Why a demonstrator is no body like the learner's, as JSON. joints: their numbers; names: of points."""
    if misfit is None:
        return None
    links = [
        {"joints": [joints[joint] for joint in link.joints], "change": link.change, "std": link.std}
        for link in misfit.links
    ]
    points = [names[point] for point in misfit.points] if names else misfit.points
    said = {"kind": misfit.kind, "points": points, "links": links, "amount": misfit.amount}
    if misfit.limits:
        said["limits"] = [
            {"joint": joints[one.joint], "beyond_deg": np.degrees(one.beyond), "std_deg": np.degrees(one.std)}
            for one in misfit.limits
        ]
    return said | {"text": misfit.describe(joints, names)}


def naming_words(naming: dict) -> str:
    """Say a naming, as of `naming_json`, in a line. Its lists may also be dictionaries by name."""
    if not naming["accepted"]:
        return "not found: no naming of the demonstrator's points explains its images"
    by_name = lambda values: values if isinstance(values, dict) else dict(enumerate(values))
    certain, probability = by_name(naming["certain"]), by_name(naming["probability"])
    without, extra = naming["without_partner"]["learner"], naming["without_partner"]["demonstrator"]
    named = [name for name in certain if name not in without]
    said = [f"{len(named)} points named"]
    if doubtful := [f"{name} ({probability[name]:.0%})" for name in named if not certain[name]]:
        said.append(f"uncertain {', '.join(doubtful)}")
    if len(without):
        said.append(f"no partner for {', '.join(map(str, without))}")
    if len(extra):
        said.append(f"none for {', '.join(map(str, extra))} of the demonstrator")
    if naming["two_answers"]:
        said.append("two answers: other names explain the images as well, in another posture")
    return "; ".join(said)


def posture(theta_deg: Iterable[float]) -> str:
    """A posture to a thousandth of a degree: smaller digits differ between machines."""
    return f"({', '.join(figure(round(angle, 3) + 0.0, '.4g', '°') for angle in theta_deg)})"


def figure(value: float, form: str, unit: str = "") -> str:
    """A number in words; a dash for NaN."""
    return "–" if np.isnan(value) else f"{value:{form}}{unit}"
