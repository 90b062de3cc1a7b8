"""The strip over the scene: what the learner says, and beneath it what is true.

What it says gives way to a message while that stays, to what is recorded or replayed, to points that are edited, to a
posture that is only looked at, and to that nothing is saved. Of an arm on its way both are of where it is seen, as the
images are.
"""

from viewimit.drawing.curves import describe_errors
from viewimit.drawing.status import StatusMessage, describe, describe_truth, draw_status

from ..drawing.joint_bars import describe_body_points
from ..drawing.overlays import describe_see_through, link
from ..model.state import PageState
from .panel import SLOW, Layout, Panel
from .widgets import put_html

LOOKS_BACK = 5  # motions
FOLLOWS = "Computing what the link holds: Esc lets it go."
RESTORES = "Computing this tab’s session again: Esc begins anew."
CHOICES = {  # by what is said: where a link leads, and its words
    "see-through": (("start/0", "Start here"), ("dismiss/0", "Let go")),
    "editing": (("best/0", "Best next"), ("remove/0", "Remove"), ("scene/0", "Save scene"), ("dismiss/0", "Done")),
    "proposed": (("best/0", "Take it"), ("dismiss/0", "Not this one")),
}


class StatusPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._status = layout.gui.add_html("")
        self._truth = ""

    @property
    def html(self) -> str:
        """As it is shown."""
        return self._status.content

    def depends_on(self, state: PageState) -> tuple:
        on_its_way = None if state.on_its_way is None else state.on_its_way.tobytes()
        moments = state.present, on_its_way, state.see_through, state.imitated, state.points
        return state.message, state.unsaved, state.follows_link, state.restores, *moments, state.playing, _busy(state)

    def period(self, state: PageState) -> float:
        """Nobody reads faster what changes with every motion, and on the way."""
        return SLOW if state.playing or state.on_its_way is not None else 0.0

    def show(self, state: PageState) -> None:
        said, self._truth = _said(state), _truth(state)
        kind = "proposed" if said.state == "editing" and state.points.proposal is not None else said.state
        choices = _choices(CHOICES.get(kind, ()))
        put_html(self._status, draw_status(said, self._truth, choices))

    def show_message(self, text: str) -> None:
        """Whatever the state."""
        put_html(self._status, draw_status(StatusMessage("message", text), self._truth))


def _choices(choices: tuple[tuple[str, str], ...]) -> str:
    """What may be done about a see-through arm, or while points are edited."""
    return "".join(link(what, words, words) for what, words in choices) + "<kbd>Esc</kbd>" if choices else ""


def _said(state: PageState) -> StatusMessage:
    session, busy = state.session, _busy(state)
    if state.message is not None:
        return StatusMessage("message", state.message)
    if busy is not None:
        return StatusMessage(*busy)
    if state.follows_link:
        return StatusMessage("message", RESTORES if state.restores else FOLLOWS)
    points = state.points
    if points.information is not None and not state.playing:
        joints = session.scene.moving_joints
        return StatusMessage(
            "editing", describe_body_points(joints, points.information, points.proposal, points.searching)
        )
    if state.see_through is not None:
        return StatusMessage("see-through", describe_see_through(session.scene, state.see_through))
    if state.unsaved is not None:
        return StatusMessage("message", f"{state.unsaved}: a reload would lose this session.")
    before = session.history[max(session.cursor - LOOKS_BACK, 0) : session.cursor]
    if (on_the_way := state.on_the_way) is not None:
        return describe(on_the_way, before, joints=session.scene.moving_joints)
    return describe(state.present, before, state.playing, state.assessment, session.scene.moving_joints)


def _truth(state: PageState) -> str:
    off = describe_errors(state.errors_deg) if _busy(state) is not None and state.imitated is None else ""
    if off:
        return off + "."
    own = state.seen.theta if state.on_the_way is None else state.shown.theta
    return describe_truth(state.session.scene.moving_joints, own, state.seen.theta_demo)


def _busy(state: PageState) -> tuple[str, str] | None:
    """State and sentence while a motion is recorded or replayed, or an imitation is seen."""
    motions = state.motions
    if state.imitated is not None:
        return "replaying", state.imitated
    return motions.describe() if motions.recording or motions.replaying else None
