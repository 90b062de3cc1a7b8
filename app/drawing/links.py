"""Links in drawings that work without a script: each asks the page for one action and loads its answer unseen."""

from viewimit.drawing import svg

SINK = "vi-sink"


def sink() -> str:
    """Build the hidden frame that receives the answers; a page without it would open a tab for each link."""
    return f'<iframe name="{SINK}" title="" hidden=""></iframe>'


def link(address: str, what: str, name: str, inside: str, stop: bool = True, pressed: bool | None = None) -> str:
    """Build one link.

    Parameters
    ----------
    address
        Prefix of all links of a page.
    what
        The action, as control/value.
    name
        What a screen reader says.
    inside
        HTML or SVG of the link.
    stop
        Whether the Tab key stops there.
    pressed
        Whether the choice is made, for a toggle; None for other links.
    """
    more = f' aria-label="{svg.escape(name)}"' if stop else ' tabindex="-1" aria-hidden="true"'
    if pressed is not None:
        more += f' role="button" aria-pressed="{str(pressed).lower()}"'
    return f'<a href="{address}/{what}" target="{SINK}"{more}>{inside}</a>'


def button(address: str, what: str, name: str, inside: str) -> str:
    """Build a link that a screen reader announces as a button."""
    return link(address, what, name, inside).replace("<a ", '<a role="button" ', 1)
