"""Who may import whom, read from the source; and what `import viewimit` loads."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import viewimit

ROOT = Path(__file__).parent.parent
LAYERS = (  # folders and modules of viewimit/: each imports only from lines above its own, or itself
    {"assets", "processes", "wording"},
    {"geometry"},
    {"estimation"},
    {"servo", "sensing"},
    {"simulation"},
    {"loop"},
    {"analysis"},
    {"drawing"},
    {"experiments"},
    {"options"},
    {"app"},
    {"commands"},
    {"__main__"},
)
SEE = {"estimation": {"geometry"}, "servo": {"geometry", "estimation"}}  # image points, nothing of the world
HEAVY = {  # package: the parts that import it
    "viser": {"app"},
    "pybullet": {"simulation"},
    "pybullet_utils": {"simulation"},
    "cv2": {"sensing", "experiments"},
    "h5py": {"sensing"},
    "distributed": {"experiments"},
    "resvg_py": {"drawing"},
    "typst": {"drawing"},
    "ziamath": {"drawing"},
    "pandas": set(),
    "scipy": set(),
    "matplotlib": set(),
    "pybullet_data": set(),
}
SOURCES = sorted(path for folder in ("viewimit", "app") for path in ROOT.joinpath(folder).rglob("*.py"))


def module_of(path):
    """viewimit.geometry.rigid, of its file; app/ installs inside the package."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = parts if parts[0] == "viewimit" else ("viewimit", *parts)
    return parts[:-1] if parts[-1] == "__init__" else parts


def imports_of(path):
    """Yield modules as tuples, of everything that a file imports, at any depth; of `from a import b` both a and a.b."""
    here = module_of(path) if path.name == "__init__.py" else module_of(path)[:-1]
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level + 1] if node.level else ()
            base += tuple(node.module.split(".")) if node.module else ()
            yield base or ("",)
            yield from ((*base, alias.name) for alias in node.names)


IMPORTS = {module_of(path): set(imports_of(path)) for path in SOURCES}


def parts_used(part):
    """The parts of viewimit, such as geometry, that one of them imports."""
    names = {name for module, names in IMPORTS.items() if module[1:2] == (part,) for name in names}
    found = {name[1] for name in names if name[0] == "viewimit" and len(name) > 1}
    return found - {part, "__version__"} - set(viewimit.__all__)


def test_parts_import_only_from_lower_layers():
    assert {module[1] for module in IMPORTS if len(module) > 1} <= set().union(*LAYERS)
    for place, layer in enumerate(LAYERS):
        for part in layer:
            assert parts_used(part) <= set().union(*LAYERS[:place]), part


def test_estimators_and_servos_know_image_points_only():
    for part, seen in SEE.items():
        assert parts_used(part) <= seen | {"wording", "assets"}, part


def test_the_page_s_model_and_commands_know_no_widgets():
    for module, names in IMPORTS.items():
        if module[1:3] in (("app", "model"), ("app", "commands"), ("app", "jobs")):
            assert not {"viser", "viser_private"} & {part for name in names for part in name}, module


def test_no_modules_import_each_other_in_a_circle():
    left = {}
    for module, names in IMPORTS.items():
        packages = {name[:-1] for name in names if name in IMPORTS}  # `from package import module` needs the module
        left[module] = (names & set(IMPORTS)) - packages - {module, ("viewimit",)}
    while left:
        leaves = {module for module, found in left.items() if not found & set(left)}
        assert leaves, f"a circle among {sorted('.'.join(module) for module in left)}"
        left = {module: found for module, found in left.items() if module not in leaves}


def test_a_heavy_package_is_imported_where_it_belongs():
    for package, parts in HEAVY.items():
        users = {module[1] for module, names in IMPORTS.items() if any(name[:1] == (package,) for name in names)}
        assert users <= parts, package


def loaded_by(code):
    command = [sys.executable, "-I", "-c", f"{code}\nimport sys\nprint(*sys.modules)"]
    return set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())


EVERYTHING = "import viewimit\nfor name in viewimit.__all__: getattr(viewimit, name)\n"
COMMANDS = "import viewimit.commands.imitate, viewimit.commands.landscape, viewimit.commands.bench"
PAGE = "import viewimit.app.server.serve, viewimit.app.page.page"


@pytest.mark.parametrize(
    "code, absent",
    [
        ("import viewimit", {"numpy", "viser", "pybullet", "trimesh", "resvg_py", "ziamath"}),
        (EVERYTHING + COMMANDS, {"viser", "pybullet", "trimesh", "resvg_py", "ziamath"}),
        (f"{PAGE}\nfrom viewimit.simulation.robot import link_meshes\nlink_meshes('panda')", {"trimesh", "scipy"}),
    ],
    ids=["import viewimit", "library and commands", "page with a shipped robot"],
)
def test_what_is_not_needed_is_not_loaded(code, absent):
    assert not loaded_by(code) & absent
