"""Equations as MathML, which browsers show without a script. An equation's label is its number in the paper."""

import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator


def inline(translator: HTML5Translator, node: nodes.math) -> None:
    translator.body.append(_convert(node.astext(), "inline"))
    raise nodes.SkipNode


def block(translator: HTML5Translator, node: nodes.math_block) -> None:
    number = node.get("label")
    label = f'<span class="number">({number})</span>' if number else ""
    place = f' id="equation-{number}"' if number else ""
    translator.body.append(f'<div class="equation"{place}>{_convert(node.astext(), "block")}{label}</div>')
    raise nodes.SkipNode


def _convert(latex: str, display: str) -> str:
    return re.sub(r"\s*\n\s*", " ", convert(latex.strip(), display=display))


def add_to(app: Sphinx) -> None:
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
