"""What camera images cost: `OPENBLAS_NUM_THREADS=1 python -m viewimit.app.camera_benchmark`.

Motions a second of a page that looks with pictures as fast as it can, and how long the ticks of another page take
meanwhile, beside how long they take alone. Pages without browsers: nothing is sent.
"""

import argparse
import asyncio
import threading
import time

import msgspec
import numpy as np

from viewimit.loop.settings import Settings

from .jobs.camera_images import CameraProcess
from .jobs.experiments import ExperimentWorker
from .jobs.threads import LandscapeWorker
from .model.services import Services, draw_all
from .page.page import Page
from .page.scheduler import Scheduler
from .quiet_client import quiet_client

SECONDS = 20.0
WAITS_S = 60.0  # for the first pictures
RESTLESS = Settings.paper(servo="gradient-retuned", start_deg=(25, -45))  # goes on for hundreds of motions


class TimedPage(Page):
    """ticks: s that each took."""

    def __init__(self, page_id: int, services: Services, settings: Settings):
        self.ticks: list[float] = []
        super().__init__(quiet_client(page_id), services, settings)

    def tick(self, now: float) -> None:
        began = time.perf_counter()
        super().tick(now)
        draw_all(self.drawings())
        self.ticks.append(time.perf_counter() - began)

    def play(self, speed: str) -> None:
        self.queue.call("speed", speed)
        self.queue.call("play")

    def switch_on(self) -> None:
        """Raises TimeoutError if no pictures come."""
        self.queue.call("camera", True)
        until = time.monotonic() + WAITS_S
        while self.busy or self.model.session.settings.sensor == "projected":
            if time.monotonic() > until:
                raise TimeoutError(f"no pictures after {WAITS_S:g} s: {self.layout.named['status'].content}")
            time.sleep(0.05)

    @property
    def motions(self) -> int:
        return len(self.model.session.history) - 1


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of each part (%(default)s)")
    seconds = parser.parse_args().seconds
    scheduler, camera, loop = Scheduler(lambda: None), CameraProcess(), asyncio.new_event_loop()
    services = Services(LandscapeWorker(), ExperimentWorker(), camera, scheduler.shedding, lambda robot, arm: None)
    threading.Thread(target=loop.run_forever, name="viewimit-pages", daemon=True).start()
    other = TimedPage(1, services, RESTLESS)
    other.play("10 a second")
    scheduler.add(other)
    scheduler.start(loop)
    print(f"ticks of another page, which makes 10 motions a second: {_ticks(other, seconds)}, alone")
    pictured = TimedPage(2, services, msgspec.structs.replace(RESTLESS, frames=Settings().frames))
    scheduler.add(pictured)
    pictured.switch_on()
    pictured.play("all it can")
    before, since = pictured.motions, time.monotonic()
    print(f"ticks of another page, which makes 10 motions a second: {_ticks(other, seconds)}, beside pictures")
    rate = (pictured.motions - before) / (time.monotonic() - since)
    print(f"motions a second of a page that looks with pictures: {rate:.1f}")
    scheduler.stop()
    services.experiments.stop()
    camera.stop()


def _ticks(page: TimedPage, seconds: float) -> str:
    """Median and 95th percentile over that time."""
    time.sleep(1.0)
    page.ticks.clear()
    time.sleep(seconds)
    median, high = np.quantile(page.ticks, (0.5, 0.95))
    return f"median {1e3 * median:.1f} ms, p95 {1e3 * high:.1f} ms"


if __name__ == "__main__":
    main()
