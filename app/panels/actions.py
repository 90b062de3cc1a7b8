"""Hidden text widgets between the page's script and its server: for clicks in drawings, and for what the tab keeps."""

from ..control.actions import KEPT_LABEL, LABEL, Actions
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

        self._kept = layout.gui.add_text(KEPT_LABEL, "", visible=False)

    @property
    def last(self) -> int:
        """The number of the last action that was taken."""
        return self.actions.last

    def send_part(self, part: str) -> None:
        """Send the tab a part of what it is to keep."""
        push_input(self._kept, part)

    def depends_on(self, state: PageState) -> tuple:
        return ()

    def show(self, state: PageState) -> None:
        """It shows nothing."""
