"""Commands that change settings: method, joints that move, disturbances, what the learner observes with."""

from typing import Annotated

from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS

from ..model.choices import AMOUNTS, joint_choices, layout_choices
from ..model.page_model import PageModel
from ..model.queue import choice, named, one_of
from .registry import command

Transfer = Annotated[str, lambda value: named(value, TRANSFERS, "there is no transfer {value}")]
Servo = Annotated[str, lambda value: named(value, SERVOS, "there is no servo {value}")]


@command("transfer", latest=True, moves=True)
def change_transfer(model: PageModel, name: Transfer) -> None:
    model.undoable.change(transfer=name)


@command("servo", latest=True, moves=True)
def change_servo(model: PageModel, name: Servo) -> None:
    model.undoable.change(servo=name)


@command("disturbance", latest=True, moves=True)
def change_disturbance(
    model: PageModel,
    name: Annotated[str, one_of(AMOUNTS.keys(), "there is no disturbance {value}")],
    value: float,
) -> None:
    """Change a disturbance. value: in the units of its slider."""
    model.undoable.change(**{name: AMOUNTS[name].asked(value)})


@command("seed", latest=True, moves=True)
def change_seed(model: PageModel, seed: int) -> None:
    model.undoable.change(seed=seed)


@command("rectify", latest=True, moves=True)
def switch_rectify(model: PageModel, on: bool) -> None:
    model.undoable.change(rectify="auto" if on else "off")


@command("camera", latest=True, moves=True, camera=lambda model, on: on)
def switch_camera(model: PageModel, on: bool) -> None:
    """Observe with camera images, or by projected points."""
    model.undoable.change(sensor="rendered" if on else "projected")


@command("joints", latest=True, moves=True)
def free_joints(model: PageModel, name: str) -> None:
    """Let other joints move, by the name of the choice; which there are depends on the scene."""
    settings = model.session.settings
    joints = choice(name, joint_choices(settings), "there is no choice of joints {value}")
    if joints != settings.joints:  # what the page has now may be meant by it
        model.undoable.change(**model.freedom.fields(settings, model.session.scene, joints))


@command("points", latest=True, moves=True)
def choose_layout(model: PageModel, name: str) -> None:
    """Choose a layout of body points by its name; which there are depends on the scene."""
    fields = choice(name, layout_choices(model.session.settings), "there is no layout {value}")
    if fields:
        model.undoable.change(**fields)


@command("duel", moves=True)
def toggle_duel(model: PageModel) -> None:
    model.duel.toggle()


@command("opponent_transfer", latest=True, moves=True)
def choose_opponent_transfer(model: PageModel, name: Transfer) -> None:
    model.duel.choose(transfer=name)


@command("opponent_servo", latest=True, moves=True)
def choose_opponent_servo(model: PageModel, name: Servo) -> None:
    model.duel.choose(servo=name)
