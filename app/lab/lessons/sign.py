"""Ten finished runs to bet on: half of their arms are within CLAIM_DEG of the demonstrator, half are not."""

from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot
from viewimit.sensing.files import parse_toml
from viewimit.servo import SERVOS
from viewimit.simulation.world import World

from .records import CLAIM_DEG, claim_probability, plain, run, run_record
from .situation import Situation

MAX_MOTIONS = 60


class SignedRun(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A run of the file: its name, one sentence about its claim, and its settings."""

    name: str
    because: str
    settings: Settings

    @property
    def situation(self) -> Situation:
        return Situation(self.settings)

    @property
    def session(self) -> Session:
        """The run itself, made once."""
        return run(self.situation, self.settings.servo, MAX_MOTIONS)


@cache
def signed_runs() -> tuple[SignedRun, ...]:
    """Read the ten runs, in their order."""
    fields = parse_toml(Path(__file__).with_name("runs.toml").read_bytes())
    return msgspec.convert(fields["run"], tuple[SignedRun, ...])


def off_deg(last: Snapshot) -> NDArray[np.float64]:
    """(m,) degrees of each joint from the demonstrator's."""
    return np.degrees(np.abs(last.theta - last.theta_demo))


@cache
def runs_record() -> list[dict[str, Any]]:
    """All runs as the page has them: the learner's knowledge, and the truth."""
    return [_record(one) for one in signed_runs()]


def _record(signed: SignedRun) -> dict[str, Any]:
    session = signed.session
    last, world = session.snapshot, signed.situation.world
    off, seen = off_deg(last), last.usable
    return {
        "name": signed.name,
        **run_record(session),
        "method": method_text(signed.settings),
        "points": points_text(world, int(seen.sum())),
        "noise": noise_text(signed.settings),
        "demonstrator": plain(last.theta_demo, 6),
        "offDeg": plain(off),
        "holds": bool(off.max() <= CLAIM_DEG),
        "certificate": None
        if not last.status.is_claim or last.certificate is None
        else plain(claim_probability(last.certificate)),
        "own": plain(last.views.own[seen].ravel(), 5),
        "recovered": plain(last.recovered[seen].ravel(), 5),
        "because": signed.because,
    }


def method_text(settings: Settings) -> str:
    """Which servo moved the arm, and the transfer of one that goes to the least E."""
    servo, transfer = SERVOS[settings.servo], TRANSFERS[settings.transfer]
    return servo.title if servo.rigid else f"{servo.title}; {transfer.title}"


def points_text(world: World, seen: int) -> str:
    """How many points lie on which part of the arm, the parts being those that the moving joints turn."""
    first, second = world.scene.moving_joints
    link = world.body.link
    upper = (link >= first) & (link < second)
    parts = {"base": link < first, "upper arm": upper, "forearm and hand": link >= second}
    listed = ", ".join(f"{name} {part.sum()}" for name, part in parts.items() if part.any())
    return f"{seen}: {listed}"


def noise_text(settings: Settings) -> str:
    """The noise of the image points, and how many images are averaged."""
    averaged = "one picture at each pose" if settings.frames == 1 else f"{settings.frames} pictures averaged"
    return f"{settings.noise_px:g} px, {averaged}" if settings.noise_px else "none"
