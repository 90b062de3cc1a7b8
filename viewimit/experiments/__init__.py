"""The paper's experiments and the benchmarks: thin scripts on the library.

A new experiment is a file, and a line here.
"""

from functools import partial

from .experiment import Experiment
from .paper import fig7, fig8, fig9, fig10

EXPERIMENTS: dict[str, Experiment] = {
    "fig7": Experiment("Fig. 7: landscape and minima", fig7.run, fig7.draw),
    "fig9": Experiment("Fig. 9: posture imitation", fig9.run, fig9.draw),
    "fig10": Experiment("Fig. 10: trajectory imitation", fig10.run, fig10.draw, ("motion",), fig10.imitation),
}
ON_PICTURES: dict[str, Experiment] = {  # those on rendered pictures
    "fig8": Experiment("Fig. 8: landscape of pictures", fig8.run, fig8.draw),
    "fig9": Experiment("Fig. 9: posture imitation", partial(fig9.run, **fig9.ON_PICTURES), fig9.draw),
}

__all__ = ["EXPERIMENTS", "ON_PICTURES", "Experiment"]
