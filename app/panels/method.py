"""Transfer, servo, and the joints that imitate; and what makes it harder, the less frequent disturbances folded."""

from viewimit.drawing.glossary import key_of
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.settings import MAX_SEED
from viewimit.servo import SERVOS

from ..drawing.glossary import beside
from ..model.choices import (
    FRAMES,
    OF_ARMS,
    OF_IMAGES,
    Amount,
    chosen_joints,
    joint_choices,
    servo_names,
    transfer_names,
)
from ..model.page_model import PageModel
from .panel import Layout, put


def method(layout: Layout, model: PageModel) -> None:
    gui = layout.gui
    with layout.folder("Method", _method):
        gui.add_html(beside("transfer"))
        transfers, servos = list(transfer_names().values()), list(servo_names().values())
        layout.dropdown("Transfer", transfers, lambda model: TRANSFERS[model.settings.transfer].title, "transfer")
        gui.add_html(beside("servo"))
        layout.dropdown("Servo", servos, lambda model: SERVOS[model.settings.servo].title, "servo")
        joints = gui.add_dropdown("Joints", ["–"], initial_value="–")
        layout.queue.on_value(joints, "joints")
    offered: list[str] = []

    def show_joints(model: PageModel) -> None:
        nonlocal offered
        choices = joint_choices(model.settings)
        if offered != list(choices):
            offered = joints.options = list(choices)
        put(joints, chosen_joints(model.settings, choices))

    layout.drawing(lambda model: (model.generation, model.settings.joints, model.inputs), show_joints)


def disturbances(layout: Layout, model: PageModel) -> None:
    gui = layout.gui
    with layout.folder("Disturbances", _disturbances):
        for amount in OF_IMAGES:
            _add_amount(layout, amount, model)
        with gui.add_folder("Arm and chance", expand_by_default=False):
            for amount in OF_ARMS:
                _add_amount(layout, amount, model)
            seed = gui.add_number("Seed", model.settings.seed, min=0, max=MAX_SEED, step=1)
            layout.value(seed, lambda model: model.settings.seed, "seed")


def _method(model: PageModel) -> str:
    """Transfer and servo, by the first words of their titles."""
    transfer, servo = TRANSFERS[model.settings.transfer].title, SERVOS[model.settings.servo].title
    return f"{transfer.split()[0].lower()}, {servo.split(' on ')[0].split(' (')[0]}"


def _disturbances(model: PageModel) -> str:
    """The first two, by their names."""
    amounts = {amount.label: amount.shown(model.settings) for amount in (*OF_IMAGES, *OF_ARMS)}
    there = [label for label, shown in amounts.items() if shown > (label == FRAMES.label) or shown < 0]
    return (", ".join(there[:2]).lower() + (" …" if len(there) > 2 else "")) or "none"


def _add_amount(layout: Layout, amount: Amount, model: PageModel) -> None:
    """A slider, which reaches farther if the page is asked to begin there."""
    begun = amount.shown(model.settings)
    low, high = min(amount.low, begun), max(amount.high, begun)
    if (key := key_of(amount.label)) is not None:
        layout.gui.add_html(beside(key))
    shown = lambda model: amount.shown(model.settings)
    layout.slider(amount.label, low, high, amount.step, shown, "disturbance", amount.name, hint=amount.hint)
