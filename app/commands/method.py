"""Commands that change settings: method, joints that move, disturbances, what the learner observes with."""

from collections.abc import Callable
from typing import Any

from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS

from ..model.choices import AMOUNTS, joint_choices, layout_choices
from ..model.page_model import PageModel
from ..model.queue import add, command, number, one_of, switch, titled, whole

TRANSFER, SERVO = titled(TRANSFERS, "transfer"), titled(SERVOS, "servo")
DISTURBANCE = one_of(AMOUNTS.keys(), "there is no disturbance {value}")


def _setting(name: str, fields: Callable[..., dict[str, Any]], *parsers: Callable, **options: Any) -> None:
    """Add a command that changes settings: those that fields(*values) returns."""
    change = lambda model, *values: model.undoable.change(**fields(*values))
    add(name, change, *parsers, latest=True, moves=True, **options)


_setting("transfer", lambda name: {"transfer": name}, TRANSFER)
_setting("servo", lambda name: {"servo": name}, SERVO)
_setting("disturbance", lambda name, value: {name: AMOUNTS[name].asked(value)}, DISTURBANCE, number)
_setting("seed", lambda seed: {"seed": seed}, whole)
_setting("rectify", lambda on: {"rectify": "auto" if on else "off"}, switch)
_setting("camera", lambda on: {"sensor": "rendered" if on else "projected"}, switch, camera=lambda model, on: on)
add("duel", lambda model: model.duel.toggle(), moves=True)
add("opponent_transfer", lambda model, name: model.duel.choose(transfer=name), TRANSFER, latest=True, moves=True)
add("opponent_servo", lambda model, name: model.duel.choose(servo=name), SERVO, latest=True, moves=True)


@command("joints", latest=True, moves=True)
def free_joints(model: PageModel, name: str) -> None:
    """Let other joints move, by the name of the choice; which there are depends on the scene."""
    settings = model.session.settings
    joints = one_of(joint_choices(settings), "there is no choice of joints {value}")(name)
    if joints != settings.joints:  # what the page has now may be meant by it
        model.undoable.change(**model.freedom.fields(settings, model.session.scene, joints))


@command("points", latest=True, moves=True)
def choose_layout(model: PageModel, name: str) -> None:
    """Choose a layout of body points by its name; which there are depends on the scene."""
    fields = one_of(layout_choices(model.session.settings), "there is no layout {value}")(name)
    if fields:
        model.undoable.change(**fields)
