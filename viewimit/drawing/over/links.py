"""Links inside drawings, without a script: each asks the page for one thing, and leads to a frame that nobody sees."""

from .. import svg

SINK = "vi-sink"


def sink() -> str:
    """The frame. It has to stand on the page wherever links do, else a browser opens a tab of its own for them."""
    return f'<iframe name="{SINK}" title="" hidden=""></iframe>'


def link(address: str, what: str, name: str, inside: str, stop: bool = True, pressed: bool | None = None) -> str:
    """address: that all links begin with; what: control/value; name: for who does not see it; stop: Tab stops there;
    pressed: of one that is chosen or not."""
    more = f' aria-label="{svg.escape(name)}"' if stop else ' tabindex="-1" aria-hidden="true"'
    if pressed is not None:
        more += f' role="button" aria-pressed="{str(pressed).lower()}"'
    return f'<a href="{address}/{what}" target="{SINK}"{more}>{inside}</a>'


def button(address: str, what: str, name: str, inside: str) -> str:
    """A link that is told as what it is: it acts, and leads nowhere."""
    return link(address, what, name, inside).replace("<a ", '<a role="button" ', 1)
