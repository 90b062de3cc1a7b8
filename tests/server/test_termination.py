"""Signals end a server whatever it is just doing."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

from viewimit.app.server.processes import Termination

ALWAYS = """
import signal, sys
from viewimit.app.server.processes import Termination

def at_each_line(*_):
    signal.raise_signal(signal.SIGTERM)
    return at_each_line

ends = Termination()
signal.signal(signal.SIGTERM, lambda *_: ends.set())
sys.settrace(at_each_line)
told = ends.is_set(), ends.wait(0.1), ends.set()
sys.settrace(None)
print(told)
"""


def test_a_signal_may_come_in_the_midst_of_a_look_at_whether_one_came():
    done = subprocess.run([sys.executable, "-I", "-c", ALWAYS], capture_output=True, text=True, timeout=20)
    assert done.stdout == "(True, True, None)\n", done.stderr


def test_all_who_wait_are_told():
    ends = Termination()
    assert not ends.wait(0) and not ends.is_set()
    with ThreadPoolExecutor() as threads:
        waiting = [threads.submit(ends.wait, 20.0) for _ in range(3)]
        ends.set()
        assert all(one.result(5) for one in waiting)
    assert ends.wait(0) and ends.is_set()
