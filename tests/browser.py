"""The Chromium or Chrome of the browser tests. `python tests/browser.py` prints its path, installs one if need be."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
ELSEWHERE = ("/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",)
OFF = (
    "WebUIOmniboxPopup",  # the address bar's lists, which nobody sees: each window would have a process for them
    "WebUIOmniboxAimPopup",
    "SpareRendererForSitePerProcess",  # a process made ready for a next page, of which there is mostly none
    # As Playwright has it, whose own list this takes the place of
    "DestroyProfileOnBrowserClose",
    "HttpsUpgrades",
    "LensOverlay",
    "MediaRouter",
    "OptimizationHints",
    "PaintHolding",
    "ThirdPartyStoragePartitioning",
)
FLAGS = [
    "--no-sandbox",  # tests run as root too; the page is our own
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",  # WebGL without a graphics card
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",  # what is not WebGL costs a third where no graphics card is imitated for it
    f"--disable-features={','.join(OFF)}",
]


def find() -> str | None:
    """The first that runs: of VIEWIMIT_CHROMIUM, on PATH, of Playwright."""
    chosen = os.environ.get("VIEWIMIT_CHROMIUM")
    if chosen:
        return chosen
    candidates = [*map(shutil.which, NAMES), *ELSEWHERE]
    return next((path for path in candidates if path and _runs(path)), None) or _playwrights_own()


def install() -> str | None:
    """Debian's where apt-get may be used, else Playwright's."""
    as_root = _as_root()
    if as_root is not None and shutil.which("apt-get"):
        quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        _try([*as_root, "apt-get", "update"], quiet)
        for package in ("chromium-headless-shell", "chromium"):  # the first has no windows, and costs less
            _try([*as_root, "apt-get", "install", "-y", "--no-install-recommends", package], quiet)
            if found := find():
                return found
    _try([sys.executable, "-m", "playwright", "install", "chromium"], dict(os.environ))
    return find()


def _as_root() -> list[str] | None:
    """What to put before a command that needs root; None if that cannot be had without a question."""
    if os.name != "posix":
        return None
    if os.geteuid() == 0:
        return []
    sudo = shutil.which("sudo")
    if sudo and subprocess.run([sudo, "-n", "true"], capture_output=True).returncode == 0:
        return [sudo, "-n"]
    return None


def _try(command: list[str], env: dict[str, str]) -> None:
    print("$", *command, file=sys.stderr)
    subprocess.run(command, env=env, stdout=sys.stderr, check=False)


def _runs(path: str) -> bool:
    """Ubuntu's package is a stub that asks for snap: only what answers counts."""
    try:
        return subprocess.run([path, "--version"], capture_output=True, timeout=60).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def _playwrights_own() -> str | None:
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        return None
    with sync_playwright() as playwright:
        path = playwright.chromium.executable_path
    return path if Path(path).is_file() and _runs(path) else None


if __name__ == "__main__":
    path = find() or install()
    if path is None:
        sys.exit("tests/browser.py: found no Chromium or Chrome, and could install none; set VIEWIMIT_CHROMIUM")
    print(path)
