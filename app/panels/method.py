"""Transfer, servo, and the joints that imitate."""

from ..commands.method import FreeJoints, change_servo, change_transfer
from ..drawing.glossary import beside
from ..model.choices import chosen_joints, joint_choices, servo_names, transfer_names
from ..model.state import PageState
from .panel import Layout, Panel
from .widgets import put


class MethodPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        gui, queue, settings = layout.gui, layout.queue, state.settings
        transfers, servos = transfer_names(), servo_names()
        with gui.add_folder("Method"):
            gui.add_html(beside("transfer"))
            self._transfer = gui.add_dropdown(
                "Transfer", list(transfers.values()), initial_value=transfers[settings.transfer]
            )
            gui.add_html(beside("servo"))
            self._servo = gui.add_dropdown("Servo", list(servos.values()), initial_value=servos[settings.servo])
            self._joints = gui.add_dropdown("Joints", ["–"], initial_value="–")
        queue.on_value(self._transfer, change_transfer)
        queue.on_value(self._servo, change_servo)
        queue.on_value(self._joints, FreeJoints.parse)
        self._generation = -1

    def depends_on(self, state: PageState) -> tuple:
        return state.generation, state.settings, state.refusals

    def show(self, state: PageState) -> None:
        settings = state.settings
        if state.generation != self._generation:
            self._generation, self._choices = state.generation, joint_choices(settings)
            self._joints.options = list(self._choices)
        put(self._transfer, transfer_names()[settings.transfer])
        put(self._servo, servo_names()[settings.servo])
        put(self._joints, chosen_joints(settings, self._choices))
