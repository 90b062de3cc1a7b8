"""QR codes, which a telephone reads from a screen in both colour schemes. HTML."""

import segno

SCALE, BORDER = 3, 2  # px a module, and modules around it


def draw_qr(address: str, name: str, error: str = "m") -> str:
    """name: for who does not see it; error: how much of it may be hidden, as segno has it."""
    code = segno.make(address, error=error, micro=False)
    drawn = code.svg_inline(border=BORDER, dark="#000", light="#fff", omitsize=True)
    width = code.symbol_size(SCALE, BORDER)[0]
    return f'<div class="vi-qr" role="img" aria-label="{name}" style="width:{width}px">{drawn}</div>'
