"""A page as it is kept, and how another one goes on from that."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from ..sessions.saved import SavedPage, SavedSession
from .page_model import PageModel
from .queue import Queued
from .view import SWITCHES, switched


def memory_of(model: PageModel) -> SavedSession:
    """The opponent of a duel and what runs in the tab Experiments is not kept."""
    there, view = model.past.present, model.view
    history, cursor, log = there.runs[0]
    head = SavedPage(
        begun=model.begun,
        cursor=cursor,
        length=len(history),
        preset=there.preset.name,
        speed=there.speed,
        chosen=view.chosen,
        show={name: getattr(view, name) for name in SWITCHES},
        dark=view.dark,
        motion=model.motions.file,
        offered=model.tour_offered,
        log=log,
    )
    return SavedSession(head, history)


def go_on(model: PageModel, memory: SavedSession) -> None:
    """With a session that was kept; the loop is paused."""
    model.session.resume(memory.history, memory.head.cursor, memory.head.log)
    _show_as(model, memory.head)
    model.view = replace(model.view, chosen=memory.head.chosen)
    model.undoable.begin_anew()


def begin_like(model: PageModel, memory: SavedSession) -> None:
    """By points from where a session that was kept stands, until its first camera images are there."""
    model.undoable.begin_like(memory.history[memory.head.cursor].settings)
    _show_as(model, memory.head)
    model.undoable.begin_anew()


def require_fit(model: PageModel) -> None:
    """Raises ValueError if the session's moments are of another arm or other points than its scene's."""
    session, present = model.session, model.session.snapshot
    if present.theta.shape != session.embodiment.lower.shape or len(present.views.demo) != len(session.world.body):
        raise ValueError("its moments are not of this scene")


def _show_as(model: PageModel, head: SavedPage) -> None:
    model.presets.choose_named(head.preset)
    model.player.speed = head.speed
    model.view = replace(switched(model.view, head.show), dark=head.dark)
    model.tour_offered = head.offered


@dataclass(frozen=True, eq=False)
class Resume(Queued):
    """A kept session with camera images goes on: its first look takes them."""

    memory: SavedSession
    moves: ClassVar[bool] = True

    def needs_camera(self, model: Any) -> bool:
        return True

    def apply(self, model: Any, now: float) -> None:
        go_on(model, self.memory)
