"""How students join: the address of the page, and large enough to be read from the last row, with its QR code. HTML."""

from viewimit.drawing.svg import escape

from ...control.classroom.lecturer import ClassView
from ...drawing.links import button
from ..qr import draw_qr

NOBODY_JOINS = "Nobody else reaches this page: start the server with <code>--host 0.0.0.0</code>, on a network."
LETTER = 0.56  # of the height of a letter: its mean width


def joining_html(address: str | None, shared: str | None) -> str:
    """A line of the lecturer's tab. address: that links begin with, None for none; shared: scheme://host:port by which
    others know the server, None where they cannot reach it."""
    if shared is None:
        return f'<p class="vi-class-join">{NOBODY_JOINS}</p>'
    large = '<span class="vi-class-button">Show large</span>'
    shows = "" if address is None else button(address, "class/invite", "Show large, with a QR code", large)
    return f'<p class="vi-class-join">Students open <b>{escape(shared)}</b> {shows}</p>'


def invitation_html(view: ClassView, address: str | None, shared: str | None) -> str:
    """Over all of the page, and wherever it is clicked, it goes again."""
    if not view.invites or address is None or shared is None:
        return ""
    here = len(view.students)
    inside = (
        f'<span class="vi-join-words"><small>Join the class</small>'
        f'<b style="font-size:min(11dvh,{90 / (LETTER * len(shared)):.1f}vw)">{escape(shared)}</b></span>'
        f"{draw_qr(shared, 'QR code of the address')}"
        f"<small><b>{here}</b> here · a click or Escape hides this</small>"
    )
    return button(address, "class/invite", "Hide the address", inside).replace("<a ", '<a class="vi-join" ', 1)
