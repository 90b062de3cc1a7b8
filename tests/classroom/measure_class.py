"""What a class's server holds: `python tests/classroom/measure_class.py --students 300`.

All students answer within two seconds, then all follow the lecturer's screen ten times a second and answer once more.
Times are from the sending of a message to its acknowledgement on the disk, and from the lecturer's sending of a screen
to its arrival, as the Python clients have them. Exit status 1 if a target is missed.
"""

import argparse
import asyncio
import contextlib
import json
import os
import random
import secrets
import sys
import time
from pathlib import Path

import numpy as np
from websockets.asyncio.client import connect

sys.path.append(str(Path(__file__).parent.parent))
sys.path.append(str(Path(__file__).parent))

from class_server import ClassServer, Lecturer  # noqa: E402

TARGET_S, SHARE = 0.2, 95
SCREENS_PER_S = 10
SCREEN = {"lesson": "tour", "step": "eyes", "seed": 1, "revealed": False, "sliders": [["own 1", 20.5]] * 8}
ANSWERS_WITHIN_S = 2.0


class Many:
    """Students in one event loop. asked: the round of the question that is asked."""

    def __init__(self, server, count):
        self.server, self.tokens = server, [secrets.token_hex(16) for _ in range(count)]
        self.acked, self.screens, self.refused = [], [], 0

    async def run(self, job):
        async with contextlib.AsyncExitStack() as stack:
            self.sockets = []
            for token in self.tokens:
                self.sockets.append(await stack.enter_async_context(self.connection()))
                await self.sockets[-1].send(json.dumps({"kind": "hello", "token": token}))
                await self.sockets[-1].recv()
            listening = [asyncio.create_task(self._hear(one)) for one in self.sockets]
            await job()
            for one in listening:
                one.cancel()

    def connection(self):
        url = self.server.url.replace("http", "ws") + "/socket"
        return connect(url, origin=self.server.url, compression=None, proxy=None, ping_interval=None)

    async def _hear(self, connection):
        with contextlib.suppress(Exception):
            async for text in connection:
                now = time.monotonic()
                if text.startswith('{"kind":"screen"'):
                    self.screens.append(now - float(text[text.rfind(":") + 1 : -2]))  # its last field says when
                elif text.startswith('{"kind":"ack"'):
                    self.acked.append(now - self.sent[connection])
                elif text.startswith('{"kind":"refused"'):
                    self.refused += 1

    async def answer(self, round, within=ANSWERS_WITHIN_S):
        """All, at random times within so many seconds."""
        self.sent = {}

        async def one(connection):
            await asyncio.sleep(random.uniform(0, within))
            answer = {"choice": random.randrange(3)}
            message = {"kind": "answer", "seq": 1, "lesson": "tour", "step": "eyes", "round": round, "answer": answer}
            self.sent[connection] = time.monotonic()
            await connection.send(json.dumps(message))

        await asyncio.gather(*map(one, self.sockets))


async def lead(lecturer, seconds):
    """The lecturer's screen, ten times a second."""
    until, due = time.monotonic() + seconds, time.monotonic()
    while (now := time.monotonic()) < until:
        lecturer.send("state", state={**SCREEN, "at": now})
        due += 1 / SCREENS_PER_S
        await asyncio.sleep(max(0, due - time.monotonic()))


def cpu_s(process):
    times = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(times[11]) + int(times[12])) / os.sysconf("SC_CLK_TCK")


def percentile(times):
    return round(1000 * float(np.percentile(times, SHARE)), 1) if times else None


async def measure(server, students, seconds):
    lecturer, many, report = Lecturer(server), Many(server, students), {"students": students}

    async def job():
        # answers alone
        asked = lecturer.ask()
        await many.answer(asked)
        await until(lambda: len(many.acked) + many.refused >= students)
        report["answers_ms"], report["answered"] = percentile(many.acked), len(many.acked)
        lecturer.send("do", what="close")
        # all are led, and answer meanwhile at their own pace
        many.acked = []
        lecturer.send("switch", what="lead", on=True)
        await asyncio.sleep(1)
        before, begun = cpu_s(server.process), time.monotonic()
        leading = asyncio.create_task(lead(lecturer, seconds))
        await asyncio.sleep(seconds / 2)
        await many.answer(0, seconds / 3)
        await leading
        report["core"] = round((cpu_s(server.process) - before) / (time.monotonic() - begun), 2)
        await until(lambda: len(many.acked) >= students)
        report["led_answers_ms"], report["screens_ms"] = percentile(many.acked), percentile(many.screens)
        report["screens"] = len(many.screens)
        report["share_of_screens"] = len(many.screens) / (students * seconds * SCREENS_PER_S)
        lecturer.send("switch", what="lead", on=False)

    await many.run(job)
    lecturer.close()
    return report


async def until(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        await asyncio.sleep(0.02)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--students", type=int, default=300)
    parser.add_argument("--seconds", type=float, default=15.0)
    args = parser.parse_args()
    with ClassServer() as server:
        report = asyncio.run(measure(server, args.students, args.seconds))
    json.dump(report, sys.stdout, indent=1)
    print()
    slow = [name for name in ("answers_ms", "led_answers_ms", "screens_ms") if (report[name] or 1e9) > 1000 * TARGET_S]
    if slow or report["answered"] < args.students or report["share_of_screens"] < 0.95:
        sys.exit(f"missed: {', '.join(slow) or 'answers or screens are missing'}")


if __name__ == "__main__":
    main()
