"""A lesson with one step of each kind, as a page: what the runtime's tests play."""

import json
from functools import cache
from pathlib import Path

import numpy as np
from viewimit.app.lab.lessons import page
from viewimit.app.lab.lessons.source import load

SAMPLES = [
    {"demonstrator": np.radians([70, -65 - k]).tolist(), "start": np.radians([30, -100 - 5 * k]).tolist()}
    for k in range(5)
]
PLACE = [300.0, 110.0]  # px in L
PAGE_DATA = page.page_data
WALK = Path(__file__).parent / "walk.toml"


@cache
def data() -> dict:
    """The page's data, with starts sampled here and a claim that holds."""
    made = PAGE_DATA({"walk": load(WALK)})
    steps = {step["id"]: step for step in made["lessons"][0]["steps"]}
    servo, bet, place = steps["servo"], steps["bet"], steps["place"]
    place["ask"]["truth"] = "the place"
    place["facts"]["the place"] = {"value": PLACE, "unit": "", "text": "–"}
    servo["randomise"] = True
    for step in (servo, steps["bowl"]):
        step["samples"] = [{"state": {**step["state"], **sampled}} for sampled in SAMPLES]
    bet["ask"]["truth"] = "the claim holds"
    bet["facts"]["the claim holds"] = {"value": 1, "unit": "", "text": "true"}
    bet["records"]["runs"] = [{"holds": True}, {"holds": False}]
    return json.loads(json.dumps(made))


def written(path: Path, monkeypatch) -> Path:
    """The page, written to a file."""
    monkeypatch.setattr(page, "page_data", lambda *_: data())
    path.write_text(page.lesson_page({"walk": load(WALK)}), "utf-8")
    return path
