"""What a visitor takes away: a replay, pictures, and a link to what the page shows, its QR code, and its code."""

import html

import segno
from viser import Icon

from viewimit.loop.codegen import as_command, as_python
from viewimit.sensing.files import file_name
from viewimit.wording import listed

from ..model.choices import place_in_link
from ..model.keeping import lab_address, lab_lacks, share_link
from ..model.link import files_named
from ..model.page_model import PageModel
from ..model.pictures import FORMATS, PICTURES, lacking
from .panel import SLOWEST, Layout, key_of_link

REPLAY = "all steps as one file that any browser opens, without a server"
PICTURE = "at print size, in colours of print, with the caption that makes it citable; S"
MOST_IN_QR = 1_200  # characters that a telephone still reads from a screen
SCALE, BORDER = 3, 2  # px a module of a QR code, and modules around it
ONLY_HERE = """Start the server with <code>--host 0.0.0.0</code> so that others on your network can open this link.
 Now it opens on this machine only."""
WIDTH = 420  # px of a link's QR code, if its modules are not smaller than that: a projector's is read from a back row


def save(layout: Layout, model: PageModel) -> None:
    """The folder in which the session is saved as a replay, and panels as pictures."""
    gui = layout.gui
    with layout.folder("Save"):
        layout.button(("Save replay", Icon.MOVIE), "save_replay", hint=REPLAY)
        layout.dropdown("Picture", PICTURES, lambda model: model.view.picture, "picture")
        layout.dropdown("As", FORMATS, lambda model: model.view.picture_as, "picture_format")
        layout.button(("Save picture", Icon.PHOTO_DOWN), "save_picture", hint=PICTURE)
        if why := lacking():
            gui.add_html(f'<div class="vi-why">{html.escape(why)}</div>')


def share(layout: Layout, model: PageModel) -> None:
    """The card with a link."""
    origin = layout.info.public_url or layout.info.origin
    content = lambda model: share_html(model, origin, is_local=layout.info.public_url is None)
    layout.modal("What this page shows, for others", "share", content, key_of_link, SLOWEST)


def share_html(model: PageModel, origin: str | None, is_local: bool = False) -> str:
    """Write the card. origin: scheme://host:port by which the server is known, None if nobody says; is_local: by no
    other machine."""
    parts, script = [], model.session.script.renamed(file_name)
    try:
        address = f"{origin or ''}/?{share_link(model, hides=not model.view.truth)}"
        parts.append(_copied("A link that opens this very state", address))
        if files := html.escape(listed(files_named(model.session.script.renamed(place_in_link)))):
            only = f"It opens only on a server that was started with {files}: no link can hold these files."
            parts.append(f'<p class="vi-2nd">{only}</p>')
        if origin is not None:
            parts.append(f'<p class="vi-2nd">{ONLY_HERE}</p>' if is_local else "")
            parts.append(_qr(address))
    except ValueError as error:
        parts.append(f"<p>{html.escape(str(error))}</p>")
    in_lab = lab_address(model.snapshot)
    if in_lab is not None:
        lacking = lab_lacks(model.snapshot)
        same = f"In the lab, which does not have {listed(lacking)}" if lacking else "The same in the lab"
        parts.append(_copied(same, f"{origin or ''}{in_lab}", tells=True))
    for title, said in ("The same in Python", as_python), ("The same as a command", as_command):
        try:
            parts.append(_copied(title, said(script), lines=True, tells=True))
        except ValueError as error:
            parts.append(f"<p>{html.escape(str(error))}</p>")
    return f'<div class="vi-share">{"".join(parts)}</div>'


def _copied(title: str, text: str, lines: bool = False, tells: bool = False) -> str:
    """With a button that copies it. lines: of code; tells: it shows the demonstrator's posture."""
    shown = html.escape(text)
    button = f'<button type="button" class="vi-copy" aria-label="Copy: {title}">Copy</button>'
    kind, hidden = ' class="vi-code"' if lines else "", ' class="vi-tells"' if tells else ""
    return f'<section{hidden}><h3>{title}</h3>{button}<pre{kind} tabindex="0">{shown}</pre></section>'


def _qr(address: str) -> str:
    """A code that a telephone reads in both colour schemes."""
    if len(address) > MOST_IN_QR:
        return '<p class="vi-2nd">Too long for a QR code that a telephone can read.</p>'
    code = segno.make(address, error="l", micro=False)
    drawn = code.svg_inline(border=BORDER, dark="#000", light="#fff", omitsize=True)
    modules = int(code.symbol_size(1, BORDER)[0])
    width = modules * max(SCALE, WIDTH // modules)
    return f'<div class="vi-qr" role="img" aria-label="QR code of the link" style="width:{width}px">{drawn}</div>'
