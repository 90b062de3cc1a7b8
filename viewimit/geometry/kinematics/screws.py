"""Screw motions as matrices of projective space: exp(θG), G = A⁻¹SA of a twist S, in any projective frame A."""

import numpy as np
from numpy.typing import NDArray

LEAST_RATE = 1e-8  # of a joint that slides: its G² is 0


def twist_matrices(twists: NDArray) -> NDArray:
    """(..., 6), angular velocity ω and velocity v → (..., 4, 4): [[ω]× v; 0 0]."""
    S = np.zeros((*twists.shape[:-1], 4, 4))
    x, y, z = np.moveaxis(twists[..., :3], -1, 0)
    S[..., 0, 1], S[..., 0, 2], S[..., 1, 2] = -z, y, -x
    S[..., 1, 0], S[..., 2, 0], S[..., 2, 1] = z, -y, x
    S[..., :3, 3] = twists[..., 3:]
    return S


def powers(G: NDArray, rate: NDArray) -> NDArray:
    """I, G, G²/w² and G³/w³, of which every exponential is a sum. G: (..., 4, 4); rate: (...), w → (..., 4, 4, 4)."""
    w = np.maximum(rate, LEAST_RATE)[..., None, None]
    squared = G @ G / w**2
    return np.stack([np.broadcast_to(np.eye(4), G.shape), G, squared, squared @ G / w], -3)


def exponentials(powers: NDArray, rate: NDArray, angle: NDArray) -> NDArray:
    """exp(θG) = I + θG + (1 - cos wθ) G²/w² + (wθ - sin wθ) G³/w³ (Murray, Li & Sastry 1994, Ch. 2), as G⁴ = -w²G².

    powers: (..., m, 4, 4, 4); rate: (..., m), w = |ω|; angle: (B, m) → (..., B, m, 4, 4).
    """
    turn = np.maximum(rate, LEAST_RATE)[..., None, :] * angle
    terms = np.empty((*turn.shape, 4))
    terms[..., 0], terms[..., 1], terms[..., 2], terms[..., 3] = 1.0, angle, 1 - np.cos(turn), turn - np.sin(turn)
    motions = terms.swapaxes(-2, -3) @ powers.reshape(*powers.shape[:-2], 16)  # (..., m, B, 16)
    return motions.swapaxes(-2, -3).reshape(*turn.shape, 4, 4)
