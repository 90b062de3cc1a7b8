"""Links inside drawings, without a script: each asks the page for one thing, and leads to a frame that nobody sees."""

from .. import svg

SINK = "vi-sink"


def sink() -> str:
    """The frame. It has to stand on the page wherever links do, else a browser opens a tab of its own for them."""
    return f'<iframe name="{SINK}" title="" hidden=""></iframe>'


def link(address: str, what: str, name: str, inside: str, stop: bool = True) -> str:
    """address: that all links begin with; what: control/value; name: for who does not see it; stop: Tab stops there."""
    more = f' aria-label="{svg.escape(name)}"' if stop else ' tabindex="-1" aria-hidden="true"'
    return f'<a href="{address}/{what}" target="{SINK}"{more}>{inside}</a>'
