"""Checks of the source that are no tests: style, types, public docstrings, forge files, faults. `python tests/lint.py`

CI runs it once, beside the tests. It needs the dependency groups `lint` and `test`.
"""

import importlib
import inspect
import json
import os
import pkgutil
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import typescript
from mutants import fault_in, mutants

import viewimit

ROOT = Path(__file__).parent.parent
SCRIPTS = ("examples", "studies")
LEAST_COMPLETE = 0.95  # share of the library's public names whose types are all known
SCHEMAS = {"github-workflows": ".github/workflows/*.yml", "readthedocs": ".readthedocs.yaml"}
# of numpydoc: something is missing in a public docstring, or is documented that does not exist
MISSING = {"GL07", "GL08", "SS01", "SS03", "SS05", "PR01", "PR02", "PR03", "PR07", "RT01", "RT03"}
OF_FIELDS = {"PR01", "PR02", "PR03", "PR07"}  # of a class with fields: each is documented beside the field
HAS_FIELDS = "__dataclass_fields__", "__struct_fields__", "__members__", "_is_protocol"


def main() -> int:
    """Run all checks. Return 0 if none finds anything."""
    failed = [name for name, check in CHECKS.items() if not _reported(name, check())]
    print(f"found something: {', '.join(failed)}" if failed else "nothing found")
    return len(failed)


def style() -> str:
    """Return what ruff finds."""
    return _run("ruff", "check", "--output-format=concise", ".") + _run("ruff", "format", "--check", "-q", ".")


def types() -> str:
    """Return what mypy finds here and as on Windows, in the installed package, the examples and the studies."""
    with _installed() as folder:
        examples = [word for part in SCRIPTS for path in (ROOT / part).glob("*.py") for word in ("-m", path.stem)]
        systems = ("linux", "win32")
        return "".join(_run("mypy", "-p", "viewimit", *examples, "--platform", one, cwd=folder) for one in systems)


def completeness() -> str:
    """Return the public names whose types are not known, if they are too many."""
    with _installed(("assets",)) as folder:
        words = ("--verifytypes", "viewimit", "--ignoreexternal", "--outputjson")
        command = [sys.executable, "-m", "basedpyright", *words]
        path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])  # whose packages are used
        environment = os.environ | {"PATH": path, "PYTHONPATH": folder}
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment)
    report = json.loads(done.stdout)["typeCompleteness"]
    unknown = [symbol["name"] for symbol in report["symbols"] if symbol["isExported"] and not symbol["isTypeKnown"]]
    return "" if report["completenessScore"] > LEAST_COMPLETE else "\n".join(unknown)


def docstrings() -> str:
    """Return what public docstrings lack, by name."""
    from numpydoc.validate import validate

    public = [f"viewimit.{name}" for name in viewimit.__all__ if callable(getattr(viewimit, name))]
    faults = []
    for dotted in [*public, *_protocols()]:
        for name, one in _members(dotted):
            asked = MISSING - OF_FIELDS if any(hasattr(one, mark) for mark in HAS_FIELDS) else MISSING
            faults += [f"{name}: {code} {text}" for code, text in validate(name)["errors"] if code in asked]
    return "\n".join(faults)


def forge() -> str:
    """Return where the workflows and the documentation host's file leave their schemas."""
    found = ""
    for schema, pattern in SCHEMAS.items():
        files = [str(path) for path in sorted(ROOT.glob(pattern))]
        found += _run("check_jsonschema", "--builtin-schema", f"vendor.{schema}", *files)
    return found


def faults() -> str:
    """Return which faults of tests/mutants.toml cannot be made any more."""
    return "\n".join(found for mutant in mutants() if (found := fault_in(mutant)))


def modules() -> str:
    """Return what TypeScript's checker, in its strict mode, finds in the lab's modules."""
    typescript.install()
    command = [typescript.node(), str(typescript.COMPILER), "-p", str(ROOT / "tests" / "lab")]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.stdout + done.stderr if done.returncode else ""


CHECKS = {
    "style": style, "types": types, "modules": modules, "completeness": completeness, "docstrings": docstrings,
    "forge": forge, "faults": faults,
}  # fmt: skip


def _reported(name: str, found: str) -> bool:
    print(f"{name}: {found.strip() or 'ok'}", flush=True)
    return not found


def _run(module: str, *words: str, cwd: str | Path = ROOT) -> str:
    """Return what a checker prints if it finds something."""
    done = subprocess.run([sys.executable, "-m", module, *words], cwd=cwd, capture_output=True, text=True)
    return done.stdout + done.stderr if done.returncode else ""


def _installed(parts: Sequence[str] = ("app", "assets")) -> tempfile.TemporaryDirectory[str]:
    """Make a folder that holds the package as it is installed, with these parts inside, and the scripts."""
    folder = tempfile.TemporaryDirectory()
    place = Path(folder.name)
    shutil.copytree(ROOT / "viewimit", place / "viewimit")
    for inside in parts:
        shutil.copytree(ROOT / inside, place / "viewimit" / inside)
    for scripts in SCRIPTS:
        shutil.copytree(ROOT / scripts, place, dirs_exist_ok=True)
    shutil.copy(ROOT / "pyproject.toml", place)
    return folder


def _protocols() -> Iterator[str]:
    """Yield every protocol of the library that a user may implement, by its dotted name."""
    for module in pkgutil.walk_packages(viewimit.__path__, "viewimit."):
        if module.name.split(".")[1] in ("app", "assets") or module.name.endswith("__main__"):
            continue
        for name, one in vars(importlib.import_module(module.name)).items():
            if getattr(one, "_is_protocol", False) and one.__module__ == module.name and not name.startswith("_"):
                yield f"{module.name}.{name}"


def _members(dotted: str) -> Iterator[tuple[str, object]]:
    """Yield a public name, and the public methods that its class defines."""
    module, _, name = dotted.rpartition(".")
    one = getattr(importlib.import_module(module), name)
    yield dotted, one
    if inspect.isclass(one):
        for method, function in vars(one).items():
            if not method.startswith("_") and callable(getattr(function, "__func__", function)):
                yield f"{dotted}.{method}", function


if __name__ == "__main__":
    sys.exit(main())
