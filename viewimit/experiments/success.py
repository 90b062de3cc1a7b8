"""How often and how soon a servo arrives, from a grid of starts over the whole range."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..landscape import grid_axes, landscape
from ..session import Session
from ..snapshot import Settings
from ..transfer import TRANSFERS

FINE_DEG, AROUND_DEG = 0.05, 1.5  # of the search for the transfer's own minimum about the grid's
WITHIN_DEG = (1.0, 3.0)


@dataclass(frozen=True)
class Success:
    """Over `starts` runs: shares that ended within 1° and 3° of the transfer's own minimum (largest joint error),
    shares that came so near at some time, motions made, shares of claims and of false claims (beyond 3°)."""

    transfer: str
    servo: str
    starts: int
    minimum_deg: tuple[float, ...]
    ended_within: dict[float, float]
    came_within: dict[float, float]
    motions_median: float
    motions_95: float
    claimed: float
    claimed_falsely: float


def own_minimum(session: Session) -> NDArray:
    """(2,) rad: where the transfer's E is smallest for the demonstrator as now seen, whatever its posture."""
    views, fit = session.snapshot.views, TRANSFERS[session.settings.transfer]
    seen = views.visible[:, :2]
    coarse = landscape(session.world, fit, views.demo, seen, grid_axes(session.world)).minimum
    around = np.radians(np.arange(-AROUND_DEG, AROUND_DEG + FINE_DEG / 2, FINE_DEG))
    scene = session.scene
    axes = tuple(np.unique(np.clip(c + around, low, high)) for c, low, high in zip(coarse, scene.lower, scene.upper))
    return landscape(session.world, fit, views.demo, seen, axes).minimum


def run(transfer: str, servo: str, grid: tuple[int, int] = (10, 13), max_motions: int = 100) -> Success:
    """The scene's demonstrator, from a grid of starts over the range of both joints."""
    settings = Settings(transfer=transfer, servo=servo)
    session = Session(settings)
    minimum = own_minimum(session)
    starts = np.stack(
        np.meshgrid(*(np.linspace(*limits, n) for limits, n in zip(session.scene.range_deg, grid)), indexing="ij"), -1
    ).reshape(-1, 2)
    ended, nearest, motions, claims = [], [], [], []
    for start in starts:
        session.begin(Settings(transfer=transfer, servo=servo, start_deg=tuple(start.tolist())))
        while session.snapshot.motion < max_motions and session.step():
            pass
        errors = [np.abs(np.degrees(snapshot.theta - minimum)).max() for snapshot in session.history]
        ended.append(errors[-1])
        nearest.append(min(errors))
        motions.append(session.snapshot.motion)
        claims.append(session.snapshot.status == "converged")
    ended, nearest, claims = np.array(ended), np.array(nearest), np.array(claims)
    return Success(
        transfer,
        servo,
        len(starts),
        tuple(np.degrees(minimum).round(3).tolist()),
        {within: float(np.mean(ended <= within)) for within in WITHIN_DEG},
        {within: float(np.mean(nearest <= within)) for within in WITHIN_DEG},
        float(np.median(motions)),
        float(np.percentile(motions, 95)),
        float(claims.mean()),
        float(np.mean(claims & (ended > WITHIN_DEG[-1]))),
    )


def table(results: list[Success]) -> str:
    """For people."""
    lines = [
        "from a grid of starts over the whole range, against the transfer's own minimum",
        f"{'transfer':10}{'servo':18}{'starts':>7}{'ended ≤1°':>11}{'≤3°':>6}{'came ≤1°':>10}{'≤3°':>6}"
        f"{'motions':>9}{'95 %':>7}{'claimed':>9}{'falsely':>9}",
    ]
    for r in results:
        lines.append(
            f"{r.transfer:10}{r.servo:18}{r.starts:7d}{r.ended_within[1.0]:11.0%}{r.ended_within[3.0]:6.0%}"
            f"{r.came_within[1.0]:10.0%}{r.came_within[3.0]:6.0%}{r.motions_median:9.0f}{r.motions_95:7.0f}"
            f"{r.claimed:9.0%}{r.claimed_falsely:9.0%}"
        )
    return "\n".join(lines)
