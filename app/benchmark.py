"""What one pass of a session costs with its drawings: `OPENBLAS_NUM_THREADS=1 python -m viewimit.app.benchmark`.

CPU time of this process, medians over many passes. viser's own sending is left out: the handles that the
drawings write into take the values and send nothing.
"""

import argparse
import time

import numpy as np

from viewimit.drawing.export.panels import make_landscape
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

from .commands import COMMANDS
from .commands.display import choose_point
from .jobs.camera_images import CameraProcess
from .jobs.experiments import ExperimentWorker
from .jobs.threads import LandscapeWorker
from .model.page_model import PageModel
from .model.queue import CommandQueue
from .model.services import LoadShedding, Redraw, Services
from .panels.images import images
from .panels.panel import Drawing, Layout
from .panels.plots import landscape
from .panels.status import status
from .quiet_client import quiet_client
from .scene.scene3d import Scene3D

RUNS = 25
SHOWN = images, landscape, status


def run(settings: Settings, chosen: int | None, runs: int = RUNS) -> dict[str, float]:
    """Median ms of CPU of the loop's pass, of its drawings, and of both together. runs: starts."""
    client, queue = quiet_client(0), CommandQueue(COMMANDS)
    services = Services(
        LandscapeWorker(), ExperimentWorker(), CameraProcess(), LoadShedding(0.05), lambda robot, arm: None
    )
    model = PageModel(0, settings, services, queue, lambda name, data: None)
    layout = Layout(client, queue)
    scene = Scene3D(client, queue, services.share)
    layout.build(SHOWN, model)
    session: Session = model.session
    costs: dict[str, list[float]] = {"loop": [], "drawings": [], "whole": []}
    low, high = np.transpose(session.scene.range_deg)
    for start in np.random.default_rng(0).uniform(low, high, (runs, 2)):
        session.begin(Settings.paper(transfer=settings.transfer, servo=settings.servo, start_deg=tuple(start.tolist())))
        model.undoable.after_restart()
        choose_point(model, chosen)
        scene.build(session.world)
        model.landscape.begin(session.world, session.snapshot)
        model.landscape.take(make_landscape(session.world, session.snapshot))
        model.refresh(0.0)
        redraw = Redraw()
        for drawing in _changed(layout, model, redraw):
            drawing.draw(model)
        while session.snapshot.motion < 30:
            began = time.process_time()
            moved = session.step()
            stepped = time.process_time()
            model.refresh(0.0)
            assert scene.arms is not None  # of the world that is built
            scene.arms.draw(*model.poses(0.0))
            scene.show(model)
            for drawing in _changed(layout, model, redraw):
                drawing.draw(model)
            done = time.process_time()
            if not moved:
                break
            for name, cost in (("loop", stepped - began), ("drawings", done - stepped), ("whole", done - began)):
                costs[name].append(1e3 * cost)
    return {name: float(np.median(values)) for name, values in costs.items()}


def _changed(layout: Layout, model: PageModel, redraw: Redraw) -> list[Drawing]:
    return [drawing for drawing in layout.drawings if redraw.changed(drawing.kind, drawing.key(model))]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--runs", type=int, default=RUNS, help="starts of each row (%(default)s)")
    runs = parser.parse_args().runs
    print("ms of CPU a motion, median: look, fit, recover, evaluate, servo; then 3-D, images, path, status")
    print(f"{'transfer':10}{'servo':18}{'point':8}{'loop':>7}{'drawings':>10}{'whole':>8}")
    for transfer in ("epipolar", "linear"):
        for servo in ("broyden", "gradient-retuned"):
            for chosen in (None, 4):
                cost = run(Settings.paper(transfer=transfer, servo=servo), chosen, runs)
                name = "none" if chosen is None else "chosen"
                print(f"{transfer:10}{servo:18}{name:8}{cost['loop']:7.2f}{cost['drawings']:10.2f}{cost['whole']:8.2f}")


if __name__ == "__main__":
    main()
