"""Commands that change settings: method, joints that move, disturbances, what the learner observes with."""

from collections.abc import Callable
from typing import Annotated, Any

from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS

from ..model.choices import AMOUNTS, joint_choices, layout_choices
from ..model.page_model import PageModel
from ..model.queue import add_command, command, one_of, switch, titled, whole

TRANSFER, SERVO = titled(TRANSFERS, "transfer"), titled(SERVOS, "servo")


def _setting(name: str, fields: Callable[[Any], dict[str, Any]], parser: Callable, **options: Any) -> None:
    """Add a command that changes settings: those that fields(value) returns."""
    change = lambda model, value: model.undoable.change(**fields(value))
    add_command(name, change, parser, latest=True, moves=True, **options)


_setting("transfer", lambda name: {"transfer": name}, TRANSFER)
_setting("servo", lambda name: {"servo": name}, SERVO)
_setting("seed", lambda seed: {"seed": seed}, whole)
_setting("rectify", lambda on: {"rectify": "auto" if on else "off"}, switch)
_setting("camera", lambda on: {"sensor": "rendered" if on else "projected"}, switch, camera=lambda model, on: on)
add_command("duel", lambda model: model.duel.toggle(), moves=True)
add_command("opponent_transfer", lambda model, one: model.duel.choose(transfer=one), TRANSFER, latest=True, moves=True)
add_command("opponent_servo", lambda model, one: model.duel.choose(servo=one), SERVO, latest=True, moves=True)


@command("disturbance", latest=True, moves=True)
def change_disturbance(
    model: PageModel, name: Annotated[str, one_of(AMOUNTS.keys(), "there is no disturbance {value}")], value: float
) -> None:
    """Change a disturbance. value: in the units of its slider."""
    model.undoable.change(**{name: AMOUNTS[name].asked(value)})


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
