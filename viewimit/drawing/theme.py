"""Colours and sizes of marks, and the stylesheet of the drawings' classes.

A role has one shape, and one colour per colour scheme. Drawings name roles only, as CSS variables or classes, so that
one drawing serves light and dark.
"""

import base64
from pathlib import Path

from ..assets import ROOT

# role: (light, dark)
ROLES = {
    "learner": ("#0072b2", "#56b4e9"),
    "demonstrator": ("#e69f00", "#f0ad1e"),
    "demonstrator-edge": ("#8a5a00", "#ffdf9e"),
    "recovered": ("#007f5c", "#3fd0a2"),
    "residual": ("#d55e00", "#ff8440"),
    "residual-edge": ("#b34e00", "#ff8440"),  # for its words
    "opponent": ("#6a3fa0", "#b99cf5"),
    "chosen": ("#b0508a", "#e79ac6"),
    "stopped": ("#d0342c", "#ff6b61"),
    "ink": ("#1b2430", "#f0f2f5"),
    "secondary": ("#5a6675", "#b3bbc6"),
    "rule": ("#dde1e7", "#45484d"),
    "paper": ("#ffffff", "#242424"),
    "card": ("#f6f7f9", "#2e2f31"),
    "hills": ("#46566b", "#a9bad2"),
}

# px in a drawing: hollow diamond, filled diamond (half diagonals), ring
RECOVERED, OBSERVED, RING = 3.7, 3.6, 8.5
HEAD = 4.6  # of a residual's arrow

DRAWING_CSS, WORDS_CSS = (
    Path(__file__).parent.joinpath("styles", f"{name}.css").read_text("utf-8") for name in ("drawing", "words")
)


def rgb(role: str, dark: bool = False) -> tuple[int, int, int]:
    """Return the red, green and blue of a role, 0 … 255 each."""
    colour = ROLES[role][dark]
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def half_white(role: str) -> tuple[int, int, int]:
    """Mix a role's colour half with white, as for the arms in 3-D, whose points have the full colour."""
    red, green, blue = rgb(role)
    return (red + 255) // 2, (green + 255) // 2, (blue + 255) // 2


def faint(role: str, dark: bool = False, strength: float = 0.35) -> tuple[int, int, int]:
    """Return a role's colour as it looks on paper with this opacity."""
    red, green, blue = (round(strength * c + (1 - strength) * p) for c, p in zip(rgb(role, dark), rgb("paper", dark)))
    return red, green, blue


def variables(dark: bool) -> str:
    """Return the CSS declarations of the roles' colours."""
    return "".join(f"--{role}:{colours[dark]};" for role, colours in ROLES.items())


def font_faces() -> str:
    """Return CSS rules with embedded fonts: Inter, and Minus, in which a hyphen is a real minus sign."""
    rules = []
    for name, more in (("Inter", "font-weight:400 700;font-display:block;"), ("Minus", "unicode-range:U+2D;")):
        data = base64.b64encode((ROOT / "fonts" / f"{name}.woff2").read_bytes()).decode()
        url = f'url("data:font/woff2;base64,{data}")'
        rules.append(f'@font-face{{font-family:{name};{more}src:{url} format("woff2")}}')
    return "".join(rules)
