"""Make fonts/Inter-Regular.ttf, fonts/Inter-SemiBold.ttf and fonts/Minus.woff2 from fonts/Inter.woff2.

    pip install fonttools brotli
    python assets/build_fonts.py

Browsers take the variable font; what makes PNGs of drawings takes one file a weight, and not compressed. The raised T
of a transposed matrix, which Inter lacks, is made of its T. Minus has one character: the hyphen, as which browsers
write the sign of a number in a box, looks like a real minus in it.
"""

from pathlib import Path

from fontTools import subset
from fontTools.pens.ttGlyphPen import TTGlyphPen
from fontTools.ttLib import TTFont
from fontTools.varLib.instancer import instantiateVariableFont

FONTS = Path(__file__).parent / "fonts"
FAMILY = "Inter"
WEIGHTS = {"Regular": 400, "SemiBold": 600}
FAMILY_NAMES = (1, 16)  # entries of the name table
RAISED_T, SMALLER, RAISED = 0x1D40, 0.6, 0.42  # its size and height, as shares of those of T and of an em


def build(style: str, weight: int) -> None:
    font = TTFont(FONTS / "Inter.woff2", recalcTimestamp=False)
    font = instantiateVariableFont(font, {"wght": weight})
    _add_raised_t(font)
    options = subset.Options(layout_features=["kern", "mark", "ccmp"], hinting=False, notdef_outline=True)
    reduced = subset.Subsetter(options)
    reduced.populate(unicodes=font.getBestCmap())
    reduced.subset(font)
    for name in FAMILY_NAMES:
        font["name"].setName(FAMILY, name, 3, 1, 0x409)
    for name, words in ((2, style), (17, style), (4, f"{FAMILY} {style}"), (6, f"{FAMILY}-{style}")):
        font["name"].setName(words, name, 3, 1, 0x409)
    font["OS/2"].usWeightClass = weight
    font.flavor = None
    font.save(FONTS / f"{FAMILY}-{style}.ttf")


def build_minus() -> None:
    font = instantiateVariableFont(TTFont(FONTS / "Inter.woff2", recalcTimestamp=False), {"wght": WEIGHTS["Regular"]})
    minus = font.getBestCmap()[ord("−")]
    for table in font["cmap"].tables:
        table.cmap = {ord("-"): minus}
    reduced = subset.Subsetter(subset.Options(layout_features=[], hinting=False, name_IDs=[]))
    reduced.populate(unicodes=[ord("-")])
    reduced.subset(font)
    font.flavor = "woff2"
    font.save(FONTS / "Minus.woff2")


def _add_raised_t(font: TTFont) -> None:
    big = font.getBestCmap()[ord("T")]
    pen = TTGlyphPen(font.getGlyphSet())
    pen.addComponent(big, (SMALLER, 0, 0, SMALLER, 0, round(RAISED * font["head"].unitsPerEm)))
    name, (advance, bearing) = "uni1D40", font["hmtx"][big]
    font.setGlyphOrder([*font.getGlyphOrder(), name])
    font["glyf"][name] = pen.glyph()
    font["hmtx"][name] = round(SMALLER * advance), round(SMALLER * bearing)
    for table in font["cmap"].tables:
        if table.isUnicode():
            table.cmap[RAISED_T] = name


if __name__ == "__main__":
    for each in WEIGHTS.items():
        build(*each)
    build_minus()
