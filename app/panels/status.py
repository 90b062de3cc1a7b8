"""The strip over the scene: the learner's words, and beneath them the truth. Other words take their place: a message
while it lasts, a recording or replay, points that are edited, a previewed posture, and the warning that nothing is
saved. While an arm moves, both describe the posture in which it is displayed, as the images do."""

from viewimit.drawing.curves import describe_errors
from viewimit.drawing.status import BY_PAGE, StatusMessage, describe, describe_outcome, describe_truth, draw_status

from ..drawing.overlays import describe_body_points, describe_see_through, link
from ..model.page_model import PageModel
from .panel import SLOW, Layout, put_html

LOOKS_BACK = 5  # motions
STARTS_PICTURES = "Starting the camera pictures … Grey parts still show the moment before."
FOLLOWS = "Press Esc to stop: the page computes the link’s session."
RESTORES = "Press Esc to begin again: the page computes this tab’s session."
UNSAVED = "This browser’s storage for the page is full or forbidden: a reload would lose this session."
CHOICES = {  # by state: where a link leads, and its words
    "see-through": (("start/0", "Start here"), ("dismiss/0", "Let go")),
    "editing": (("best/0", "Best next"), ("remove/0", "Remove"), ("scene/0", "Save scene"), ("dismiss/0", "Done")),
    "proposed": (("best/0", "Take it"), ("dismiss/0", "Not this one")),
}


def status(layout: Layout, model: PageModel) -> None:
    strip = layout.named["status"] = layout.gui.add_html("")

    def key(model: PageModel) -> tuple:
        shown, message = model.displayed, model.message
        on_its_way = None if shown.interpolated_theta is None else shown.interpolated_theta.tobytes()
        snapshots = model.snapshot, shown.scene_snapshot, on_its_way, shown.preview, shown.playback, model.edited
        told = message and message.text, model.unsaved, model.following.goes_on, model.following.restores
        return *told, *snapshots, model.player.playing, _busy(model)

    def draw(model: PageModel) -> None:
        said, truth = _said(model), _truth(model)
        layout.named["truth"] = truth
        kind = "proposed" if said.state == "editing" and model.edited.proposal is not None else said.state
        choices = "".join(link(what, words, words) for what, words in CHOICES.get(kind, ()))
        choices += "<kbd>Esc</kbd>" if choices else ""
        put_html(strip, draw_status(said, truth, choices, _outcome(model, said)))

    # nobody reads faster what changes with every motion, and on the way
    moves = lambda model: model.player.playing or model.displayed.interpolated_theta is not None
    layout.drawing(key, draw, lambda model: SLOW if moves(model) else 0.0)


def show_fault(layout: Layout, text: str) -> None:
    """Show a fault without reading the model, which may be unreadable."""
    put_html(layout.named["status"], draw_status(StatusMessage("message", text), layout.named.get("truth", "")))


def _said(model: PageModel) -> StatusMessage:
    session, busy = model.session, _busy(model)
    if model.message is not None:
        return StatusMessage("message", model.message.text)
    if busy is not None:
        return StatusMessage(*busy)
    if model.following.goes_on:
        return StatusMessage("message", RESTORES if model.following.restores else FOLLOWS)
    points = model.edited
    if points.information is not None and not model.player.playing:
        joints = session.scene.moving_joints
        said = describe_body_points(joints, points.information, points.proposal, points.searching)
        return StatusMessage("editing", said)
    if model.displayed.preview is not None:
        return StatusMessage("see-through", describe_see_through(session.scene, model.displayed.preview))
    if model.unsaved:
        return StatusMessage("message", UNSAVED)
    before, joints = session.history[max(session.cursor - LOOKS_BACK, 0) : session.cursor], session.scene.moving_joints
    if (moving := model.displayed.moving_snapshot) is not None:
        return describe(moving, before, joints=joints)
    return describe(model.snapshot, before, model.player.playing, model.displayed.assessment, joints)


def _outcome(model: PageModel, said: StatusMessage) -> str:
    """What has come of it, of where the arm is seen; "" while the page itself says something."""
    if said.state in BY_PAGE:
        return '<i class="vi-waiting"></i>' if said.sentence == STARTS_PICTURES else ""
    moving = model.displayed.moving_snapshot
    now = model.snapshot if moving is None else moving
    theta_demo = model.displayed.snapshot.theta_demo
    return describe_outcome(now.status, now.motion, now.theta, theta_demo, model.player.playing)


def _truth(model: PageModel) -> str:
    shown = model.displayed
    if _busy(model) is not None and shown.playback is None and (off := describe_errors(shown.errors_deg)):
        return off + "."
    own = shown.snapshot if shown.moving_snapshot is None else shown.scene_snapshot
    return describe_truth(model.session.scene.moving_joints, own.theta, shown.snapshot.theta_demo)


def _busy(model: PageModel) -> tuple[str, str] | None:
    """State and sentence while a motion is recorded or replayed, or an imitation is seen."""
    motions = model.motions
    if model.displayed.playback is not None:
        return "replaying", model.displayed.playback
    if motions.recorder is None and motions.shown is None:
        return None
    return motions.describe() if motions.recorder is not None or motions.replaying else None
