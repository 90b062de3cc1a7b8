"""What a student's page tells the lecturer of itself: small, and nothing that a person has written but a name."""

import numpy as np

from viewimit.drawing.svg import thinned
from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot
from viewimit.servo import ServoStatus

from ...classroom.messages import MOST_NAME, MOST_PATH, Answer, Summary
from ...lessons.course import Course
from ..page_model import PageModel


def name_of(text: str) -> str:
    """What somebody has typed, in one short line."""
    return "".join(c for c in " ".join(text.split()) if c.isprintable())[:MOST_NAME].strip()


def summary_of(model: PageModel, id: str, name: str) -> Summary:
    """In brief."""
    course = model.guided.course
    session = model.session if course is None else course.session
    moments = session.history[: session.cursor + 1] if course is None else course.moments
    present = moments[-1]
    landscape = model.landscape.made
    hills = b"" if course is not None or landscape is None else landscape.shades
    path, demo, plane = _in_plane(session, moments)
    E, off = float(present.E), float(np.degrees(np.abs(present.theta - present.theta_demo).max()))
    return Summary(
        id=id,
        name=name,
        state=_state(present, model.player.playing, course),
        E=round(E, 3) if np.isfinite(E) else None,
        off=round(off, 2),
        motions=present.motion,
        path=path,
        demo=demo,
        plane=plane,
        hills=hills if plane is not None else b"",
        lesson=None if course is None else (course.progress.lesson, course.progress.at + 1, len(course.screens)),
    )


def answer_of(course: Course) -> Answer | None:
    """To the step that is shown; None before it is answered."""
    given = course.given
    if not course.answered:
        return None
    answer = Answer(choice=given.choice, number=given.number, place=given.place)
    return None if answer == Answer() else answer


def _state(present: Snapshot, playing: bool, course: Course | None):
    if course is not None:
        return (ServoStatus.MOVING if present.motion else ServoStatus.READY).value
    if present.transfer is None:
        return "lost"
    if present.status.has_ended:
        return "arrived" if present.status.is_claim else present.status.value
    if present.motion and not playing:
        return "paused"
    return (ServoStatus.MOVING if present.motion else ServoStatus.READY).value


def _in_plane(session: Session, moments):
    """Path, demonstrator and the plane's ends in tenths of a degree; nothing unless two joints move."""
    if len(session.scene.moving_joints) != 2:
        return (), None, None
    kept = thinned(len(moments), MOST_PATH)
    postures = np.array([moments[k].theta for k in kept])
    path = np.rint(10 * np.degrees(postures)).astype(int).ravel().tolist()
    demo = np.rint(10 * np.degrees(moments[-1].theta_demo)).astype(int).tolist()
    (low, high), (left, right) = session.scene.range_deg
    return tuple(path), tuple(demo), tuple(round(10 * end) for end in (low, high, left, right))
