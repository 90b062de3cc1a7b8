"""Every preset, run until it rests or gives up, does what its lesson says."""

from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import numpy as np
import pytest
from viewimit.app.model.choices import PRESETS, presets_from
from viewimit.app.presets import read_presets
from viewimit.app.server.limits import ServerOptions

from viewimit.analysis.self_assessment import Assessment, assess
from viewimit.estimation.transfers.registry import BADLY_CONDITIONED
from viewimit.estimation.transfers.transfer import conflict
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot

MOTIONS = 600  # within which all but the paper's own laws rest
PATIENCE = 20


@dataclass(frozen=True)
class End:
    """off_deg: (T,) largest joint error after each motion; E_there: px², in the demonstrator's posture"""

    last: Snapshot
    off_deg: np.ndarray
    known: Assessment | None
    first_E: float
    E_there: float

    @property
    def off(self) -> float:
        return float(self.off_deg[-1])


ENDS: dict[str, Callable[[End], bool]] = {
    "Beyond the paper": lambda end: end.off < 0.1 and end.last.motion <= 12,
    "The paper's experiment": lambda end: end.off < 3 and end.known.at_local_minimum,
    "The paper's law, as printed": lambda end: end.off > 3 and np.abs(end.last.moved).max() < np.radians(0.5),
    "A transfer with perspective": lambda end: end.off < 0.1 and end.last.E < 0.01,
    "Seen from far away": lambda end: end.off < 0.5 and end.last.E < 0.05,
    "Seen from close by": lambda end: end.known.at_local_minimum and end.last.E > 1,
    "The paper's law, retuned": lambda end: (
        100 < np.argmax(end.off_deg < 3) < MOTIONS and end.last.motion == MOTIONS and end.last.status != "converged"
    ),
    "A transfer without lines": lambda end: end.off < 3 and end.known.at_local_minimum,
    "Seven joints": lambda end: end.off < 0.3 and end.known.std_per_px[5:].min() > 1.5 * end.known.std_per_px[:5].max(),
    "Eyes turned inwards": lambda end: end.off > 5 and end.last.status == "settled" and end.last.E < end.E_there,
    "Eyes turned inwards, rectified": lambda end: end.off < 0.2 and end.last.rectification is not None,
    "Face to face": lambda end: end.off > 10 and end.last.E > 20,
    "Five points": lambda end: end.last.E < 0.5 and end.off > 10 and 0 in end.known.unobservable,
    "Points in one plane": lambda end: end.last.flatness > BADLY_CONDITIONED,
    "Noisy pictures": lambda end: end.off > 1,
    "Points that get lost": lambda end: end.last.usable.sum() < len(end.last.usable),
    "Points without names": lambda end: (
        end.off < 0.2 and end.last.naming.certain.all() and np.isnan(end.first_E) and end.last.status == "converged"
    ),
    "KUKA iiwa": lambda end: end.off < 3,
}


@pytest.mark.parametrize("preset", [p for p in PRESETS if p.settings.sensor == "projected"], ids=lambda p: p.name)
def test_a_lesson_comes_true(preset):
    assert preset.name in ENDS, "say there how a run ends that keeps what the preset's sentence promises"
    session = Session(preset.settings)
    last = session.run(MOTIONS, PATIENCE).last
    first = session.history[0]
    views = session.world.look(first.theta_demo, first.theta_demo)
    there = float(conflict(first.fit(views).residual(views)))
    off = [np.degrees(np.abs(moment.theta - moment.theta_demo).max()) for moment in session.history]
    end = End(last, np.array(off), assess(session), first.E, there)
    assert ENDS[preset.name](end), (last.status, last.motion, off[-1])


def test_the_page_begins_with_the_papers_method_and_offers_the_best_next():
    assert ServerOptions().settings == Settings.paper()
    assert next(iter(presets_from(ServerOptions().settings).values())).name == "The paper's experiment"
    assert [preset.settings for preset in PRESETS[:2]] == [Settings.paper(), Settings()]


@pytest.mark.parametrize("line, what", [("sped = 2", "sped"), ('speed = "fast"', "speed"), ("key = 3", "key")])
def test_a_preset_with_an_unknown_field_or_a_wrong_type_is_named(line, what):
    wrong = f'[[preset]]\nname = "a"\nsays = "b"\n{line}\n' + ("" if what == "key" else 'key = "c"\n')
    with pytest.raises(msgspec.ValidationError, match=what):
        read_presets(wrong.encode())
