"""Writes lessons/rounds.json: how the methods that "Design your own" offers do in its random scenes.

    python assets/build_rounds.py

It takes minutes. Run it again if the lesson's ranges or choices change, or a transfer, a servo or a disturbance.
"""

import json
import sys

from viewimit.app.lab.lessons.design import ROUNDS, compute_rounds
from viewimit.app.lab.lessons.facts import sample_states
from viewimit.app.lab.lessons.source import shipped
from viewimit.app.lab.lessons.step_data import SAMPLE_SEED, SCENE_SAMPLES, situation_of
from viewimit.assets import ROOT


def main() -> int:
    lesson = shipped()["design"]
    (step,) = lesson.step
    found = {
        one.digest: compute_rounds(one, ROUNDS)
        for one in sample_states(situation_of(lesson, step), SCENE_SAMPLES, SAMPLE_SEED)
    }
    ROOT.joinpath("lessons", "rounds.json").write_text(json.dumps(found, separators=(",", ":")) + "\n", "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
