"""Links in drawings: the page's script sends what each asks for by the page's own connection."""

from viewimit.drawing import svg


def link(what: str, name: str, inside: str, stop: bool = True, pressed: bool | None = None) -> str:
    """Build one link.

    Parameters
    ----------
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
    return f'<a href="#" data-do="{what}"{more}>{inside}</a>'


def button(what: str, name: str, inside: str) -> str:
    """Build a link that a screen reader announces as a button."""
    return link(what, name, inside).replace("<a ", '<a role="button" ', 1)
