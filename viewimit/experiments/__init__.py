"""The paper's experiments and the benchmarks: thin scripts on the library.

A new experiment is a file, and a line here; ON_PICTURES are those that look at rendered pictures.
"""

from .experiment import Experiment
from .paper import fig7, fig7_figure, fig8, fig8_figure, fig9, fig9_figure, fig10, fig10_figure

EXPERIMENTS: dict[str, Experiment] = {
    "fig7": Experiment("Fig. 7: landscape and minima", fig7.run, fig7_figure.draw),
    "fig9": Experiment("Fig. 9: posture imitation", fig9.run, fig9_figure.draw),
    "fig10": Experiment("Fig. 10: trajectory imitation", fig10.run, fig10_figure.draw, ("motion",), fig10.imitation),
}
ON_PICTURES: dict[str, Experiment] = {
    "fig8": Experiment("Fig. 8: landscape of pictures", fig8.run, fig8_figure.draw),
    "fig9": Experiment("Fig. 9: posture imitation", fig9.on_pictures, fig9_figure.draw),
}

__all__ = ["EXPERIMENTS", "ON_PICTURES", "Experiment"]
