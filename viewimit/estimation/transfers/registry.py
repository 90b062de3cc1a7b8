"""The transfers by name, with the description of each: title, prose, LaTeX and storage.

The mathematics of a transfer is in its own module. Only `fit` is required of an entry; all other fields have defaults.
"""

from collections import UserDict

import numpy as np
from numpy.typing import NDArray

from ...geometry.affine import DEMO_PAIR, VIEW_PAIRS
from ..equations import HOLE, Equation, column, each, matrix, number, short
from . import epipolar, linear, projective, rank3
from .epipolar import EpipolarTransfer
from .linear import AffineTransfer
from .projective import ProjectiveTransfer
from .rank3 import Rank3Transfer
from .transfer import TransferFunction, TransferMethod, transfer_method

PROJECTIVE_MIN_POINTS = 8  # 32 coordinates for the 19 parameters of the projective transfer
LINE_PAIRS = tuple("lrLR"[p] + "lrLR"[q] for p, q in np.delete(VIEW_PAIRS, DEMO_PAIR, 0))  # of the rows of 𝐀, Eq. (4)
ILL_CONDITIONED, BADLY_CONDITIONED = 40.0, 200.0  # condition numbers from which a transfer is, and is badly


class Transfers(UserDict[str, TransferMethod]):
    """Transfers by name. Assign a `TransferMethod` or a plain function; TypeError for anything else."""

    def __setitem__(self, name: str, given: TransferMethod | TransferFunction) -> None:
        super().__setitem__(name, transfer_method(given))


def default_transfer(points: int) -> str:
    """Return the name of the best transfer for this number of points."""
    return "projective" if points >= PROJECTIVE_MIN_POINTS else "epipolar"


def _epipolar_equations(
    fitted: EpipolarTransfer, demo: NDArray[np.float64], own: NDArray[np.float64], name: str
) -> tuple[Equation, ...]:
    A, B = epipolar.linear_system(fitted.f.reshape(4, 5, 1))
    centred = demo - fitted.demo_mean
    solution = fitted.matrix @ centred
    return (
        Equation(
            "(4)",
            f"point {name} recovered, px about the centroids: so f₃₃ = 0",
            rf"𝐀\,{{}}^{{LR}}\hat{{𝐮}}_{{{HOLE}}}=-𝐁𝐜_{{{HOLE}}}:\;{matrix(5, 4)}{column(4)}\approx{column(5)}",
            (name, name, *each(A[0], 2), *each(solution, 1), *each(-B[0] @ centred, 1)),
            wide=True,
            lines=LINE_PAIRS,
        ),
    )


def _affine_equations(
    fitted: AffineTransfer | Rank3Transfer, demo: NDArray[np.float64], own: NDArray[np.float64], name: str
) -> tuple[Equation, ...]:
    """One 4 x 4 map of points about their centroids replaces Eq. (4)."""
    centred = demo - fitted.demo_mean
    recovered = fitted.own_mean + fitted.matrix @ centred
    return (
        Equation(
            "",
            f"replaces (4), point {name}: centroid + map · (c − its centroid), px",
            rf"{{}}^{{LR}}\hat{{𝐮}}_{{{HOLE}}}={column(4)}+{matrix(4, 4)}{column(4)}={column(4)}",
            (name, *each(fitted.own_mean, 0), *each(fitted.matrix, 2), *each(centred, 1), *each(recovered, 1)),
            wide=True,
        ),
    )


def _projective_equations(
    fitted: ProjectiveTransfer, demo: NDArray[np.float64], own: NDArray[np.float64], name: str
) -> tuple[Equation, ...]:
    u = (demo - fitted.demo_mean) @ fitted.basis
    shape = fitted.coefficients[0] + u @ fitted.coefficients[1:]
    recovered = fitted.recover(demo[None, :2], demo[None, 2:])[0]
    latex = (
        rf"{{}}^{{LR}}\hat{{𝐮}}_{{{HOLE}}}=\bar{{𝐲}}+\frac{{𝐚_0+𝐀^{{\top}}𝐮_{{{HOLE}}}}}{{1+𝐩\cdot 𝐮_{{{HOLE}}}}}"
        rf"={column(4)}+{column(4)}\big/{HOLE}={column(4)}"
    )
    depth = number(float(1 + u @ fitted.p), 3)
    numbers = (name, name, name, *each(fitted.own_mean, 0), *each(shape, 1), depth, *each(recovered, 1))
    title = f"replaces (4), point {name}: one depth for L and R, px"
    return (Equation("", title, latex, numbers, wide=True),)


def _rank3_conflict(E: float) -> Equation:
    latex = rf"E=\frac{{1}}{{2N}}\sum_{{k=1}}^{{5}}\lambda_k(𝐖)={HOLE}"
    return Equation("", "replaces (6): what all four images leave beyond rank 3", latex, (short(E),))


TRANSFERS = Transfers(
    {
        "epipolar": TransferMethod(
            title="Epipolar (paper)",
            assumes="Affine cameras. Each point is where the epipolar lines of its images in l and r cross.",
            limitations="Nearly parallel lines, and perspective: the lowest E is degrees off, so no claim.",
            fit=epipolar.fit,
            equations=_epipolar_equations,
            crosses_lines=True,
            condition_name="cond A",
            degenerate_message="The epipolar lines are nearly parallel, so E may mislead.",
        ),
        "linear": TransferMethod(
            title="Linear combination",
            assumes="Affine cameras. Each image of the learner is an affine function of the demonstrator's shape.",
            limitations="Perspective: the lowest E is degrees off, so no claim. It never intersects lines.",
            fit=linear.fit,
            equations=_affine_equations,
        ),
        "rank3": TransferMethod(
            title="Rank 3, all views",
            assumes="Affine cameras, and equal noise in all four images, which it fits at once.",
            limitations="Perspective: the largest bias without noise, so no claim. It is steady under much noise.",
            fit=rank3.fit,
            equations=_affine_equations,
            conflict_equation=_rank3_conflict,
        ),
        "projective": TransferMethod(
            title="Projective combination",
            assumes="Parallel optical axes, or rectified images: a point has one depth in both.",
            limitations="Distorting lenses, and much noise: average several images of the demonstrator.",
            fit=projective.fit,
            equations=_projective_equations,
        ),
    }
)
