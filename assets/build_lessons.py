"""Writes lessons/data.json: what the library computes for the shipped lessons. It takes half a minute.

    python assets/build_lessons.py

Run it again if a lesson's settings, figures or measures change, or what they are computed with. Words need none.
"""

import json
import sys

from viewimit.app.lab.lessons.source import questions, shipped
from viewimit.app.lab.lessons.step_data import DATA, Scenes, compute_questions, compute_step, digest_of


def main() -> int:
    scenes, computed = Scenes(), {}
    for lesson in shipped().values():
        for step in lesson.step:
            own_scenes, computed[digest_of(lesson, step)] = compute_step(lesson, step)
            scenes |= own_scenes
    found = {"scenes": scenes, "computed": computed, "questions": compute_questions(questions().item)}
    lines = ",\n".join(
        f'"{kind}":{{\n' + ",\n".join(f'"{key}":{_line(one)}' for key, one in table.items()) + "\n}"
        for kind, table in found.items()
    )
    DATA.write_text(f"{{{lines}}}\n", "utf-8")
    return 0


def _line(made: object) -> str:
    return json.dumps(made, separators=(",", ":"), allow_nan=False, ensure_ascii=False)


if __name__ == "__main__":
    sys.exit(main())
