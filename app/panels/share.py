"""What a visitor takes away: a replay, pictures, and a link to what the page shows, with its QR code and the code that
repeats it."""

import html
from typing import Any

import segno
from viser import Icon

from viewimit.loop.codegen import as_command, as_python
from viewimit.sensing.files import file_name

from ..lab.address import lab_address
from ..model.page_model import PageModel
from ..model.pictures import FORMATS, PICTURES, lacking
from ..sessions.link import encode_link, files_named
from .panel import Layout, put_html

REPLAY = "all motions as one file that any browser opens, without a server"
PICTURE = "at print size, in colours of print, with the caption that makes it citable; S"
MOST_IN_QR = 1_200  # characters that a telephone still reads from a screen
SCALE, BORDER = 3, 2  # px a module of a QR code, and modules around it


def save(layout: Layout, model: PageModel) -> None:
    """The folder in which the session is saved as a replay, and panels as pictures."""
    gui = layout.gui
    with layout.folder("Save"):
        layout.button(("Save replay", Icon.MOVIE), "save_replay", hint=REPLAY)
        layout.dropdown("Picture", list(PICTURES), lambda model: model.view.picture, "picture")
        layout.dropdown("As", list(FORMATS), lambda model: model.view.picture_as, "picture_format")
        layout.button(("Save picture", Icon.PHOTO_DOWN), "save_picture", hint=PICTURE)
        if why := lacking():
            gui.add_html(f'<div class="vi-why">{html.escape(why)}</div>')


def share(layout: Layout, model: PageModel) -> None:
    """The card with a link."""
    origin = layout.info.public_url or layout.info.origin
    card: Any = None  # the open modal, whose class viser does not name
    inside: Any = None

    def key(model: PageModel) -> tuple:
        if not model.view.share:
            return (False,)
        return True, model.snapshot, model.view, model.player.speed, model.preset.name

    def show(model: PageModel) -> None:
        nonlocal card, inside
        if card is not None and not model.view.share:
            card.close()
            card = None
        if not model.view.share:
            return
        if card is None:
            card = layout.gui.add_modal("What this page shows, for others")
            with card:
                done = layout.gui.add_button("Close")  # first, so that it has the focus and is in sight
                inside = layout.gui.add_html("")
            layout.queue.on_click(done, "share")
        put_html(inside, share_html(model, origin))

    layout.drawing(key, show)


def share_html(model: PageModel, origin: str | None) -> str:
    """origin: scheme://host:port by which the server is known, None if nobody says."""
    parts, script = [], model.session.script.renamed(file_name)
    try:
        text = encode_link(model.linked())
        address = f"{origin or ''}/?s={text}"
        parts.append(_copied("A link that opens this very state", address))
        parts.append(_bound(files_named(text)))
        parts.append(_qr(address) if origin is not None else "")
    except ValueError as error:
        parts.append(f"<p>{html.escape(str(error))}</p>")
    in_lab = lab_address(model.snapshot)
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


def draw_qr(address: str, name: str, error: str = "m") -> str:
    """Draw a QR code that a telephone reads in both colour schemes, as HTML. name: for screen readers; error: how much
    of it may be hidden, as segno has it."""
    code = segno.make(address, error=error, micro=False)
    drawn = code.svg_inline(border=BORDER, dark="#000", light="#fff", omitsize=True)
    width = code.symbol_size(SCALE, BORDER)[0]
    return f'<div class="vi-qr" role="img" aria-label="{name}" style="width:{width}px">{drawn}</div>'
