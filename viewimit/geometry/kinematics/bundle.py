"""Levenberg-Marquardt for models of few parameters and many points (Triggs et al. 2000).

Parameters p and points X are adjusted together. Each step eliminates the points from the normal equations by the Schur
complement:

    [A  B] [δp]     [g]
    [Bᵀ C] [δX] = - [h],     C block diagonal,     (A - B C⁻¹ Bᵀ) δp = B C⁻¹ h - g,     δX = -C⁻¹ (h + Bᵀ δp).

For noise of 1 px the parameters have the covariance (A - B C⁻¹ Bᵀ)⁻¹. A point follows them by -C⁻¹ Bᵀ, and has the
covariance C⁻¹ in addition.

References
----------
Triggs, McLauchlan, Hartley and Fitzgibbon, "Bundle adjustment: a modern synthesis", 2000.
Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, section 10.3.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

FD_STEP = 1e-6  # of forward differences
MAX_ITER, MAX_RETRIES = 30, 6  # steps, and larger dampings tried for each
INITIAL_DAMPING, DAMPING_DECREASE, DAMPING_INCREASE = 1e-3, 0.1, 10.0
FTOL, MIN_RMS_PX = 1e-3, 1e-9  # relative gain of a step that goes on, and rms residual that counts as zero
REGULARISATION = 1e-9  # added to the diagonal of the normal equations, relative to it
MIN_EIGENVALUE = 1e-12  # relative to the largest: below it a direction is not determined

Model = TypeVar("Model", bound=Any)  # a dataclass with parameters (..., P) and points (..., N, 3)
Residuals = Callable[[Any], NDArray[np.float64]]  # a model, or several at once → (..., K, N, 3) px


def levenberg_marquardt(
    initial: Model, residuals_of: Residuals, prior: NDArray[np.float64], ftol: float = FTOL, max_iter: int = MAX_ITER
) -> Model:
    """Minimise the squared residuals and the weighted squares of the parameters.

    Parameters
    ----------
    initial : dataclass
        Has `parameters`, (P,), and `points`, (N, 3).
    residuals_of : callable
        Residuals of such a model, (K, N, 3) px, which depend on no other point. Of several at once, with (..., P)
        parameters and (..., N, 3) points: (..., K, N, 3).
    prior : (P,) array
        Weights of the squared parameters [px²].
    ftol : float
        Share of the cost by which a step must lower it, for another one to follow.
    max_iter : int
        Steps at most.

    Returns
    -------
    dataclass
        The model at the minimum.
    """
    found = initial
    residuals, damping = residuals_of(found), INITIAL_DAMPING
    cost = float((residuals**2).sum() + prior @ found.parameters**2)
    for _ in range(max_iter):
        if cost < residuals.size * MIN_RMS_PX**2:
            break
        damped_step, gained = _linearised(found, residuals_of, residuals, prior), 0.0
        for _ in range(MAX_RETRIES):
            trial = damped_step(damping)
            trial_residuals = residuals_of(trial)
            gained = cost - float((trial_residuals**2).sum() + prior @ trial.parameters**2)
            if gained > 0:
                break
            damping *= DAMPING_INCREASE
        if not gained > 0:
            break
        found, residuals = trial, trial_residuals
        cost, damping = cost - gained, damping * DAMPING_DECREASE
        if gained < ftol * cost:
            break
    return found


def jacobian(model: Any, residuals_of: Residuals, residuals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Derivatives of the residuals by each parameter and each coordinate of their point: (P + 3, K, N, 3) px."""
    P = len(model.parameters)
    parameters = model.parameters + FD_STEP * np.eye(P + 3, P)
    points = model.points + FD_STEP * np.eye(P + 3, 3, -P)[:, None, :]
    stepped = replace(model, parameters=parameters, points=points)
    return np.nan_to_num((residuals_of(stepped) - residuals) / FD_STEP, copy=False)


def _linearised(
    found: Model, residuals_of: Residuals, residuals: NDArray[np.float64], prior: NDArray[np.float64]
) -> Callable[[float], Model]:
    """Return the function from a damping to the minimum of the damped linear model."""
    J, P = jacobian(found, residuals_of, residuals), len(found.parameters)
    A, B, C = normal_equations(J, P)
    A = A + np.diag(prior)
    g = J[:P].reshape(P, -1) @ residuals.ravel() + prior * found.parameters
    h = np.einsum("akni,kni->na", J[P:], residuals)
    diag_A, diag_C = np.diag(A), np.einsum("naa->na", C)
    B_flat = B.transpose(0, 2, 1).reshape(-1, P)  # a row for each coordinate of a point

    def damped_step(damping: float) -> Model:
        raised = damping * diag_C + REGULARISATION * diag_C.sum(1, keepdims=True) + np.finfo(float).tiny
        inverse = np.linalg.inv(C + raised[..., None] * np.eye(3))
        BC = (B @ inverse).transpose(1, 0, 2).reshape(P, -1)
        reduced = A + np.diag(damping * diag_A + REGULARISATION * diag_A.mean()) - BC @ B_flat
        step = np.linalg.solve(reduced, BC @ h.ravel() - g)
        points = found.points - np.einsum("nab,nb->na", inverse, h + (B_flat @ step).reshape(-1, 3))
        return replace(found, parameters=found.parameters + step, points=points)

    return damped_step


def normal_equations(
    J: NDArray[np.float64], n_parameters: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Blocks of JᵀJ for derivatives (P + 3, K, N, 3): A (P, P), B (N, P, 3) and C (N, 3, 3).

    A is summed over points: BLAS would start threads for one large product, which takes longer than all small ones.
    """
    P, by_point = n_parameters, J.transpose(2, 0, 1, 3).reshape(J.shape[2], len(J), -1)
    products = by_point @ by_point.swapaxes(1, 2)
    return products[:, :P, :P].sum(0), products[:, :P, P:], products[:, P:, P:]


def sqrt_inverse(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """R of (..., k, k) with R Rᵀ its pseudo-inverse."""
    values, vectors = np.linalg.eigh(matrix)
    determined = values > MIN_EIGENVALUE * values[..., -1:]
    return vectors * np.where(determined, 1 / np.sqrt(np.where(determined, values, 1.0)), 0.0)[..., None, :]
