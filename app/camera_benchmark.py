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

from viewimit.settings import BEST, Settings

from .benchmark import QuietClient, QuietHandle
from .control.scheduler import Scheduler
from .jobs.camera_images import CameraProcess
from .jobs.experiments import ExperimentWorker
from .jobs.landscapes import LandscapeWorker
from .page import Page
from .server.seat_counts import Tally

SECONDS = 20.0
WAITS_S = 60.0  # for the first pictures
RESTLESS = Settings(servo="gradient-retuned", start_deg=(25, -45))  # goes on for hundreds of motions


def quiet_client(page_id: int) -> QuietClient:
    client = QuietClient(page_id)
    client.gui.main_panel = QuietHandle()
    return client


class TimedPage(Page):
    """ticks: s that each took."""

    def __init__(self, page_id: int, camera: CameraProcess, scheduler: Scheduler, settings: Settings):
        self.ticks: list[float] = []
        workers = LandscapeWorker(), ExperimentWorker(), camera
        super().__init__(
            quiet_client(page_id), *workers, lambda: None, settings, lambda memory: None, scheduler.load, None
        )

    def tick(self, now: float) -> None:
        began = time.perf_counter()
        super().tick(now)
        self.ticks.append(time.perf_counter() - began)

    def play(self, speed: str) -> None:
        self._inbox.put("speed", speed)
        self._inbox.act("play")

    def switch_on(self) -> None:
        """Raises TimeoutError if no pictures come."""
        self._inbox.put("camera", True)
        until = time.monotonic() + WAITS_S
        while self._turns.busy or self._session.settings.camera == "points":
            if time.monotonic() > until:
                raise TimeoutError(f"no pictures after {WAITS_S:g} s: {self._message}")
            time.sleep(0.05)

    @property
    def motions(self) -> int:
        return len(self._session.history) - 1


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of each part (%(default)s)")
    seconds = parser.parse_args().seconds
    scheduler, camera = Scheduler(Tally().rows[0]), CameraProcess()
    other = TimedPage(1, camera, scheduler, RESTLESS)
    other.play("10 a second")
    scheduler.add(other)
    loop = asyncio.new_event_loop()
    threading.Thread(target=loop.run_forever, daemon=True).start()
    scheduler.start(loop)
    print(f"ticks of another page, which makes 10 motions a second: {_ticks(other, seconds)}, alone")
    pictured = TimedPage(2, camera, scheduler, msgspec.structs.replace(RESTLESS, frames=BEST.frames))
    scheduler.add(pictured)
    pictured.switch_on()
    pictured.play("all it can")
    before, since = pictured.motions, time.monotonic()
    print(f"ticks of another page, which makes 10 motions a second: {_ticks(other, seconds)}, beside pictures")
    rate = (pictured.motions - before) / (time.monotonic() - since)
    print(f"motions a second of a page that looks with pictures: {rate:.1f}")
    scheduler.stop()
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
