"""The paper's experiments and the benchmarks: thin scripts on the library."""

from .paper import fig7, fig8, fig9, fig10

EXPERIMENTS = {"fig7": fig7.run, "fig9": fig9.run, "fig10": fig10.run}
ON_PICTURES = {"fig8": fig8.run, "fig9": fig9.on_pictures}
