"""The card with a link to what the page shows, its QR code, and the code that repeats it."""

import html
from typing import Any

from viewimit.loop.codegen import as_command, as_python
from viewimit.sensing.files import file_name

from ...commands.display import ToggleShare
from ...lab.address import lab_address
from ...model.state import PageState
from ...sessions.link import encode_link, files_named
from ..panel import Layout, Panel
from ..qr import draw_qr
from ..widgets import put_html

MOST_IN_QR = 1_200  # characters that a telephone still reads from a screen


class SharePanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._gui, self._queue, self._origin = layout.gui, layout.queue, layout.shared or layout.origin
        self._card: Any = None  # the open modal, whose class viser does not name

    def depends_on(self, state: PageState) -> tuple:
        if not state.view.share:
            return (False,)
        return True, state.present, state.view, state.speed

    def show(self, state: PageState) -> None:
        if self._card is not None and not state.view.share:
            self._card.close()
            self._card = None
        if not state.view.share:
            return
        if self._card is None:
            self._card = self._gui.add_modal("What this page shows, for others")
            with self._card:
                done = self._gui.add_button("Close")  # first, so that it has the focus and is in sight
                self._inside = self._gui.add_html("")
            self._queue.on_click(done, ToggleShare())
        put_html(self._inside, share_html(state, self._origin))


def share_html(state: PageState, origin: str | None) -> str:
    """origin: scheme://host:port by which the server is known, None if nobody says."""
    parts, script = [], state.session.script.renamed(file_name)
    try:
        text = encode_link(state.linked())
        address = f"{origin or ''}/?s={text}"
        parts.append(_copied("A link that opens this very state", address))
        parts.append(_bound(files_named(text)))
        parts.append(_qr(address) if origin is not None else "")
    except ValueError as error:
        parts.append(f"<p>{html.escape(str(error))}</p>")
    in_lab = lab_address(state.present)
    if in_lab is not None:
        parts.append(_copied("The same in the lab, in the browser alone", f"{origin or ''}{in_lab}", tells=True))
    for what, said in ("in Python", as_python), ("as a command", as_command):
        try:
            parts.append(_copied(f"The same {what}", said(script), lines=True, tells=True))
        except ValueError as error:
            parts.append(f"<p>{html.escape(str(error))}</p>")
    return f'<div class="vi-share">{"".join(parts)}</div>'


def _copied(title: str, text: str, lines: bool = False, tells: bool = False) -> str:
    """With a button that copies it. lines: of code; tells: it shows the demonstrator's posture."""
    shown = html.escape(text)
    button = f'<button type="button" class="vi-copy" aria-label="Copy: {title}">Copy</button>'
    kind, hidden = ' class="vi-code"' if lines else "", ' class="vi-tells"' if tells else ""
    return f'<section{hidden}><h3>{title}</h3>{button}<pre{kind} tabindex="0">{shown}</pre></section>'


def _bound(files: list[str]) -> str:
    """Where a link opens, if not everywhere."""
    if not files:
        return ""
    names = html.escape(" and ".join(files))
    return f'<p class="vi-2nd">It opens only on a server that was started with {names}, which no link can hold.</p>'


def _qr(address: str) -> str:
    if len(address) > MOST_IN_QR:
        return '<p class="vi-2nd">Too long for a QR code that a telephone can read.</p>'
    return draw_qr(address, "QR code of the link", error="l")
