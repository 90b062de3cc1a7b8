"""The text widget, seen by nobody, through which the page's script sends what is clicked in drawings."""

from ..control.actions import LABEL, Actions
from ..control.commands.touch import TOUCHES
from ..control.state import PageState
from ..viser_private import push_input
from .panel import Layout, Panel


class ActionsPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self.actions = Actions(layout.queue, TOUCHES)
        box = layout.gui.add_text(LABEL, "", visible=False)

        @box.on_update
        async def _(event) -> None:
            if event.client_id is not None:  # None: the page itself wrote it
                self.actions.take(event.target.value)
                push_input(box, str(self.actions.last))

    def depends_on(self, state: PageState) -> tuple:
        return ()

    def show(self, state: PageState) -> None:
        """It shows nothing."""
