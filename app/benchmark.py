"""What one pass of a session costs with its drawings: `OPENBLAS_NUM_THREADS=1 python -m viewimit.app.benchmark`.

CPU time of this process, medians over many passes. viser's own sending is left out: the handles that the
drawings write into take the values and send nothing.
"""

import argparse
import contextlib
import time
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

from viewimit.session import Session
from viewimit.settings import Settings

from .control.inbox import Inbox
from .control.visitor import View
from .panels.panels import Panels
from .scene.scene3d import Scene3D

RUNS = 25


class QuietHandle:
    """Stands for any handle of viser and what it hangs on: keeps what is assigned, sends nothing, can be a context."""

    content, value, visible, disabled, label, max = "", None, True, False, "", None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __call__(self, *args, **kwargs):
        return QuietHandle()


@dataclass
class QuietClient:
    """A page's client without a browser."""

    client_id: int = 0
    scene: QuietHandle = field(default_factory=QuietHandle)
    gui: QuietHandle = field(default_factory=QuietHandle)
    camera: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(image_width=552, image_height=720, position=np.ones(3))
    )

    def atomic(self):
        return contextlib.nullcontext()


def run(settings: Settings, chosen: int | None, runs: int = RUNS) -> dict[str, float]:
    """Median ms of CPU of the loop's pass, of its drawings, and of both together."""
    session = Session(settings)
    panels = Panels(QuietClient(), Inbox(), False)
    scene = Scene3D(QuietClient(), lambda point: None, 60.0, lambda: None)
    show = View().show
    costs: dict[str, list[float]] = {"loop": [], "drawings": [], "whole": []}
    for start in np.random.default_rng(0).uniform(*np.transpose(session.scene.range_deg), (runs, 2)):
        session.begin(Settings(transfer=settings.transfer, servo=settings.servo, start_deg=tuple(start.tolist())))
        scene.build(session.world)
        panels.set_world(session.world, session.snapshot)
        panels.show_landscape(panels.make_landscape(session.world, session.snapshot))
        while session.snapshot.motion < 30:
            began = time.process_time()
            moved = session.step()
            stepped = time.process_time()
            scene.draw_poses(session.snapshot.theta, session.snapshot.theta_demo)
            scene.draw(session.snapshot, chosen, show)
            panels.draw_images(session.snapshot, chosen, False)
            panels.draw_path(session, None)
            panels.draw_status(session, True)
            done = time.process_time()
            if not moved:
                break
            for name, cost in (("loop", stepped - began), ("drawings", done - stepped), ("whole", done - began)):
                costs[name].append(1e3 * cost)
    return {name: float(np.median(values)) for name, values in costs.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=RUNS, help="starts of each row (%(default)s)")
    runs = parser.parse_args().runs
    print("ms of CPU a motion, median: look, fit, recover, evaluate, servo; then 3-D, images, path, status")
    print(f"{'transfer':10}{'servo':18}{'point':8}{'loop':>7}{'drawings':>10}{'whole':>8}")
    for transfer in ("epipolar", "linear"):
        for servo in ("broyden", "gradient-retuned"):
            for chosen in (None, 4):
                cost = run(Settings(transfer=transfer, servo=servo), chosen, runs)
                name = "none" if chosen is None else "chosen"
                print(f"{transfer:10}{servo:18}{name:8}{cost['loop']:7.2f}{cost['drawings']:10.2f}{cost['whole']:8.2f}")


if __name__ == "__main__":
    main()
