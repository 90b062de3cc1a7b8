"""Nothing that runs needs what only some systems have: Windows is faked here, and its types are checked elsewhere."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from viewimit import processes

ROOT = Path(__file__).parent.parent

WINDOWS = """
import asyncio, ctypes, http.server, multiprocessing.spawn, os, signal, socket, subprocess, sys, tempfile, webbrowser
import msgspec, numpy, PIL.Image, platformdirs, trimesh, viser, websockets

for module in (os, signal, socket):
    for name in ("fork", "nice", "killpg", "getuid", "sched_getaffinity", "SIGHUP", "SIGKILL", "pthread_sigmask",
                 "send_fds", "recv_fds", "AF_UNIX"):
        if hasattr(module, name):
            delattr(module, name)
for name in ("fcntl", "resource", "termios", "tty", "pwd", "grp"):
    sys.modules[name] = None  # an import of it fails


class Kernel32:
    calls = []

    def __getattr__(self, name):
        def call(*arguments):
            Kernel32.calls.append((name, *arguments))
        setattr(self, name, call)
        return call


ctypes.WinDLL = lambda name: Kernel32()
signal.SIGBREAK = signal.SIGUSR1
sys.platform = "win32"
"""


def on_windows(code):
    done = subprocess.run([sys.executable, "-c", WINDOWS + code], capture_output=True, text=True, cwd=ROOT / "tests")
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_all_modules_load_and_a_run_imitates_on_a_system_like_windows():
    code = """
import pkgutil, viewimit.app
in_app = pkgutil.walk_packages(viewimit.app.__path__, "viewimit.app.")  # which stands elsewhere in a clone
for found in [*pkgutil.walk_packages(viewimit.__path__, "viewimit."), *in_app]:
    makes_assets = found.name.startswith("viewimit.assets.")  # in a clone, with what that needs
    if not makes_assets and not found.name.endswith(("__main__", "physics")):
        __import__(found.name)
assert "viewimit.app.server.serve" in sys.modules
from viewimit.commands.cli import main
assert main(["imitate", "--demonstrator", "45,-90", "--start", "25,-45"]) == 0
"""
    assert "arrived" in on_windows(code)


@pytest.mark.skipif(sys.platform == "win32", reason="as other systems have it")
def test_a_child_process_stands_back_and_keeps_nohups_wish():
    code = """
import os, signal
from viewimit import processes
before = os.nice(0)
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # whatever began these tests
processes.lower_priority(3)
with processes.interrupts_withheld():
    print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))
print(os.nice(0) - before, [each.name for each in processes.stop_signals()])
processes.ignore_interrupts()
os.kill(os.getpid(), signal.SIGINT)
os.kill(os.getpid(), signal.SIGHUP)
print([each.name for each in processes.stop_signals()])
"""
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    lower = min(3, 19 - os.nice(0))  # no priority is lower than 19
    assert said.splitlines() == ["True", f"{lower} ['SIGINT', 'SIGTERM', 'SIGHUP']", "['SIGINT', 'SIGTERM']"]
    assert signal.SIGINT in processes.stop_signals()
