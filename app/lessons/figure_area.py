"""The figures of a step, large and at the side, in one of which a mark can be placed. HTML."""

from .figures import FIGURES, layers_of
from .format import Figure, Place
from .stage import Stage


def draw_figures(stage: Stage, address: str | None) -> str:
    step = stage.step
    main = "".join(_figure(stage, figure, address, False) for figure in step.main)
    side = "".join(_figure(stage, figure, address, True) for figure in step.side)
    kind = " vi-alone" if not step.side else ""
    names = " ".join(f"vi-main-{_class(figure.figure)}" for figure in step.main)
    beside = f'<div class="vi-guide-side">{side}</div>' if side else ""
    return f'<div class="vi-guide-stage{kind}"><div class="vi-guide-figures {names}">{main}</div>{beside}</div>'


def _figure(stage: Stage, figure: Figure, address: str | None, small: bool) -> str:
    layers = layers_of(stage, figure.show, figure.reveal, figure.hide)
    drawn = FIGURES[figure.figure].draw(stage, layers, small)
    ask = stage.step.ask
    kind = f"vi-figure vi-figure-{_class(figure.figure)}"
    if not (isinstance(ask, Place) and ask.figure == figure.figure and not stage.revealed) or address is None:
        return f'<div class="{kind}">{drawn}</div>'
    name = "Place your mark: click, or move it by the arrow keys"
    return (
        f'<div class="{kind} vi-place" id="vi-place" tabindex="0" role="application" aria-label="{name}"'
        f' data-place="{address}/lesson/place,">{drawn}</div>'
    )


def _class(name: str) -> str:
    return name.replace(" ", "-")
