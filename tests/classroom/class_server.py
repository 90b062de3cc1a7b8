"""A `viewimit class` of one's own, and browsers of it without a page: what they send and hear."""

import json
import os
import re
import secrets
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from waiting import wait_until
from websockets.sync.client import connect

CODE = "abcdefghjkmnpqrstuvwxyz23456789"  # all signs of a code
STARTS_WITHIN_S = 90


class ClassServer:
    """On a free port unless one is given, once it answers; `restart` keeps port and file."""

    def __init__(self, *options, data=None, port=0, before=()):
        self.data = data or Path(tempfile.mkdtemp(prefix="viewimit-class-")) / "class.sqlite"
        self.options, self.port, self.before, self.lines = options, port, before, []
        self.start()

    def start(self):
        command = [*self.before, sys.executable, "-I", "-m", "viewimit.commands.cli", "class", "--port", str(self.port)]
        self.process = subprocess.Popen(
            [*command, "--data", str(self.data), *self.options],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env={**os.environ, "VIEWIMIT_LECTURER": CODE},
        )
        threading.Thread(target=self._read, args=(self.process,), daemon=True).start()
        found = wait_until(lambda: re.search(r"the class is at (http://\S+?:(\d+))/", self.log), STARTS_WITHIN_S)
        self.url, self.port = found[1], int(found[2])
        wait_until(self._answers, STARTS_WITHIN_S)

    def _answers(self):
        assert self.process.poll() is None, self.log
        try:
            Student(self).close()
        except OSError:
            return False
        return True

    def _read(self, process):
        for line in process.stdout:
            self.lines.append(line)

    @property
    def log(self):
        return "".join(self.lines)

    def kill(self):
        self.process.kill()
        self.process.wait()

    def stop(self):
        self.process.terminate()
        assert self.process.wait(20) in (0, -15), self.log

    def restart(self):
        self.kill()
        self.lines.clear()
        self.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.kill()


class Student:
    """One browser. heard: all messages, oldest first."""

    def __init__(self, server, token=None, name="", hello=True, path="/socket", linked=True, **headers):
        self.token = token or secrets.token_hex(16)
        self.name, self.heard, self.closed = name, [], None
        own = {"origin": server.url, "user_agent_header": None, "compression": None, "proxy": None}
        self.socket = connect(server.url.replace("http", "ws") + path, **{**own, **headers})
        self._seq = 0
        threading.Thread(target=self._hear, daemon=True).start()
        if hello:
            self.send("hello", token=self.token, name=name, linked=linked, **self.further())
            self.wait("orders")

    def further(self):
        return {}

    def _hear(self):
        try:
            for text in self.socket:
                self.heard.append({**json.loads(text), "received": time.monotonic()})
        except Exception as error:
            self.closed = error
        self.closed = self.closed or self.socket.close_code

    def send(self, kind, **fields):
        self.socket.send(json.dumps({"kind": kind, **fields}))

    def answer(self, lesson, step, answer, round=0, **fields):
        self._seq += 1
        self.send("answer", seq=self._seq, lesson=lesson, step=step, answer=answer, round=round, **fields)
        return self._seq

    def vote(self, round, choice, right=None, lesson="tour", step="eyes"):
        """And wait until it is kept or refused."""
        seq = self.answer(lesson, step, {"choice": choice}, round, right=right)
        return self.reply(seq)

    def reply(self, seq):
        return wait_until(lambda: next((m for m in self.heard if m.get("seq") == seq), None))

    def last(self, kind):
        return next((message for message in reversed(self.heard) if message["kind"] == kind), None)

    def wait(self, kind, where=lambda message: True):
        """The newest message of a kind, once it is as it should be."""

        def found():
            message = self.last(kind)
            return message if message is not None and where(message) else None

        return wait_until(found)

    def orders(self, where):
        return self.wait("orders", where)

    def close(self):
        self.socket.close()


class Lecturer(Student):
    """One who has typed the code."""

    def __init__(self, server, token=None, session=None):
        self.session = session
        super().__init__(server, token)
        if session is None:
            self.send("login", code=CODE)
            self.session = self.wait("lecturer")["session"]

    def further(self):
        return {} if self.session is None else {"session": self.session}

    def ask(self, lesson="tour", step="eyes", **fields):
        """→ the number of the round."""
        before = (self.last("orders").get("asked") or {}).get("round")
        self.send("ask", lesson=lesson, step=step, **fields)
        return self.orders(lambda o: o.get("asked") and o["asked"]["round"] != before)["asked"]["round"]

    def counted(self, **now):
        """The results, once they are so now."""
        right = lambda m: m["results"] and {name: m["results"]["now"][name] for name in now} == now
        return self.wait("count", right)["results"]
