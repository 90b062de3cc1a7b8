"""Who may import whom, read from the source; and what `import viewimit` loads."""

import ast
import functools
import re
import subprocess
import sys
from pathlib import Path

import pytest

import viewimit

ROOT = Path(__file__).parent.parent
LAYERS = (  # folders and modules of viewimit/: each imports only from lines above its own, or itself
    {"assets", "processes"},
    {"language"},
    {"geometry"},
    {"estimation"},
    {"servo", "sensing"},
    {"simulation"},
    {"loop"},
    {"analysis"},
    {"drawing"},
    {"experiments"},
    {"app"},
    {"commands"},
    {"__main__"},
)
# rooms and modules of app/: each imports only what stands in a line above its own, or itself
APP_ORDER = (
    {"viser_private", "static", "drawing", "lab"},
    {"jobs", "sessions", "classroom"},
    {"model"},
    {"commands", "panels", "scene"},
    {"page"},
    {"server"},
)
OF_OTHERS = {"_exit", "_repr_html_", "_prop_hints", "_is_protocol"}  # names of Python's, IPython's and viser's
# image points, nothing of the world
ESTIMATORS_SEE = {
    "estimation": {"geometry", "language"},
    "servo": {"geometry", "estimation", "language"},
}
MOST_AT_THE_TOP = 20  # entries of app/
EVERYTHING = sorted(path for folder in ("viewimit", "app", "assets") for path in ROOT.joinpath(folder).rglob("*.py"))
MAKE_ASSETS = {path for path in EVERYTHING if path.parent.name == "assets" and path.name != "__init__.py"}
SOURCES = [path for path in EVERYTHING if path not in MAKE_ASSETS]


def module_of(path):
    """viewimit.geometry.rigid, of its file; app/ and assets/ install inside the package."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = parts if parts[0] == "viewimit" else ("viewimit", *parts)
    return parts[:-1] if parts[-1] == "__init__" else parts


@functools.cache
def nodes_of(path):
    """All of a file's syntax tree."""
    return tuple(ast.walk(ast.parse(path.read_text())))


def imports_of(path):
    """(module as a tuple, AST node) of everything that a file imports, at any depth."""
    here = module_of(path) if path.name == "__init__.py" else module_of(path)[:-1]
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield tuple(alias.name.split(".")), node
        elif isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level + 1] if node.level else ()
            base += tuple(node.module.split(".")) if node.module else ()
            if base == ("viewimit",):  # from . import geometry
                for alias in node.names:
                    yield (*base, alias.name), node
            else:
                yield base, node


def parts_imported(path):
    """Parts of viewimit, such as geometry, that a file imports."""
    return {module[1] for module, _ in imports_of(path) if module[0] == "viewimit" and len(module) > 1}


def in_part(part):
    return [path for path in SOURCES if module_of(path)[1:2] == (part,)]


def test_the_reader_of_imports_sees_them_all():
    assert parts_imported(ROOT / "viewimit/loop/session.py") == {
        "estimation",
        "loop",
        "sensing",
        "servo",
        "simulation",
    }
    assert "viser" in {module[0] for path in in_part("app") for module, _ in imports_of(path)}


def test_every_part_has_its_layer():
    parts = {module_of(path)[1] for path in SOURCES if len(module_of(path)) > 1}
    assert parts <= set().union(*LAYERS)


@pytest.mark.parametrize("layer", range(len(LAYERS)), ids=lambda layer: "-".join(sorted(LAYERS[layer])))
def test_parts_import_only_from_lower_layers(layer):
    below = set().union(*LAYERS[:layer])
    for part in LAYERS[layer]:
        for path in in_part(part):
            assert parts_imported(path) - {"__version__"} <= below | {part}, path


def test_rooms_of_the_page_import_only_what_stands_above_them():
    for path in in_part("app"):
        if path.parent.name == "app" and path.name == "__init__.py":
            continue
        room = module_of(path)[2]
        place = next(k for k, rooms in enumerate(APP_ORDER) if room in rooms)
        above = set().union(*APP_ORDER[:place], {room})
        found = {module[2] for module, _ in imports_of(path) if module[:2] == ("viewimit", "app") and len(module) > 2}
        found |= {
            alias.name for module, node in imports_of(path) if module == ("viewimit", "app") for alias in node.names
        }
        assert found <= above, path


def test_model_and_commands_know_no_widgets():
    for path in EVERYTHING:
        if module_of(path)[1:3] in (("app", "model"), ("app", "commands"), ("app", "jobs")):
            named = {part for module, node in imports_of(path) for part in (*module, *(a.name for a in node.names))}
            assert not {"viser", "viser_private"} & named, path


def test_panels_and_scene_are_given_what_they_show():
    for path in EVERYTHING:
        if module_of(path)[1:3] in (("app", "panels"), ("app", "scene")):
            imported = {module[1:3] for module, _ in imports_of(path) if module[0] == "viewimit"}
            assert not {part for part in imported if part[:1] in (("analysis",), ("sensing",))} - {("sensing", "files")}
            names = {alias.name for module, node in imports_of(path) for alias in node.names if module[0] == "viewimit"}
            assert not names & {"triangulate", "Silhouettes", "image_windows", "Session"}, path


def test_no_constructor_hands_on_what_is_made_only_after_it():
    """A lambda in it that reaches into self finds there whatever comes to be later."""
    for path in SOURCES:
        for node in nodes_of(path):
            if isinstance(node, ast.FunctionDef) and node.name == "__init__":
                for inner in ast.walk(node):
                    if isinstance(inner, ast.Lambda):
                        assert "self." not in ast.unparse(inner), f"{path}:{inner.lineno}"


def test_tests_reach_into_nothing_private():
    """Of the project: what they do is what its users could."""
    for path in sorted(ROOT.joinpath("tests").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            names = set()
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) not in ("self", "cls", "super()"):
                names = {node.attr}
            elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("setattr", "getattr", "delattr")):
                names = {one.value for one in node.args if isinstance(one, ast.Constant) and isinstance(one.value, str)}
            private = {name for name in names if re.match("_[^_]", name)} - OF_OTHERS
            assert not private, f"{path}:{node.lineno}: {', '.join(private)}"


@pytest.mark.parametrize("part", ESTIMATORS_SEE)
def test_estimators_and_servos_know_image_points_only(part):
    for path in in_part(part):
        assert parts_imported(path) <= ESTIMATORS_SEE[part] | {part}, path


# worlds, cameras and arms that project; fits and laws
COMPUTE = {"World", "Camera", "Cameras", "StereoHead", "Robot", "Session"}
METHODS = {"TRANSFERS", "SERVOS"}  # asked for their words only
COUNT = {"unobservable_joints", "weak_joints", "number", "with_minus"}  # functions that only compare or write numbers
DRAWINGS = sorted(
    {path for path in in_part("drawing") if path.stem != "equations" and path.parent.name != "export"}
    | {path for path in in_part("experiments") if path.stem.endswith("_figure")}
)


@pytest.mark.parametrize("path", DRAWINGS, ids=lambda path: path.stem)
def test_drawings_are_given_what_they_show(path):
    """Of other parts they import types and constants: no function, and nothing that fits, projects or analyses."""
    for module, node in imports_of(path):
        if module[0] == "viewimit" and module[1:2] not in (("drawing",), ("assets",), ("language",)):
            for name in {alias.name for alias in node.names} - COUNT:
                assert name[0].isupper() and name not in COMPUTE, f"{path.name}: {name}"
    called = {ast.unparse(node.func) for node in nodes_of(path) if isinstance(node, ast.Call)}
    assert not [one for one in called if re.match(rf"({'|'.join(METHODS)})\[[^]]*\](\.fit|\.step)?$", one)], path.name


def test_no_modules_import_each_other_in_a_circle():
    modules = {module_of(path): path for path in SOURCES}
    imports = {}
    for module, path in modules.items():
        named = {(found, (*found, alias.name)) for found, node in imports_of(path) for alias in node.names}
        found = {inside if inside in modules else base for base, inside in named}
        imports[module] = (found & set(modules)) - {module}
    while imports:
        leaves = {module for module, found in imports.items() if not found & set(imports)}
        assert leaves, f"a circle among {sorted('.'.join(module) for module in imports)}"
        imports = {module: found for module, found in imports.items() if module not in leaves}


def test_a_folder_says_what_it_holds():
    for folder in {path.parent for path in EVERYTHING}:
        assert ast.get_docstring(ast.parse((folder / "__init__.py").read_text())), folder
    assert len([entry for entry in (ROOT / "app").iterdir() if entry.name != "__pycache__"]) <= MOST_AT_THE_TOP


def test_the_page_and_the_lab_are_imported_by_their_commands_alone_and_only_when_called():
    for path in SOURCES:
        if module_of(path)[1:2] == ("app",):
            continue
        for module, node in imports_of(path):
            if module[:2] == ("viewimit", "app"):
                assert module_of(path) in {
                    ("viewimit", "commands", name) for name in ("serve", "lab", "class_", "handout", "exam", "markers")
                }
                assert node.col_offset > 0, "at the top of the module"


@pytest.mark.parametrize(
    "package, parts",
    [
        ("viser", {"app"}),
        ("pybullet", {"simulation"}),
        ("pybullet_utils", {"simulation"}),
        ("cv2", {"sensing", "experiments"}),
        ("h5py", {"sensing"}),
        ("distributed", {"experiments"}),
        ("pandas", set()),
        ("resvg_py", {"drawing"}),
        ("typst", {"drawing"}),
        ("ziamath", {"drawing"}),
        ("matplotlib", set()),
        ("pybullet_data", set()),
    ],
)
def test_a_heavy_package_is_imported_where_it_belongs(package, parts):
    users = {module_of(path)[1] for path in SOURCES for module, _ in imports_of(path) if module[0] == package}
    assert users <= parts


def loaded_by(code):
    listing = f"{code}\nimport sys\nprint(*sys.modules)"
    command = [sys.executable, "-I", "-c", listing]
    return set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())


def test_import_viewimit_loads_next_to_nothing():
    assert not loaded_by("import viewimit") & {"numpy", "viser", "pybullet", "trimesh", "resvg_py", "ziamath"}


def test_the_library_and_the_commands_load_neither_viser_nor_pybullet():
    everything = f"import viewimit\nfor name in viewimit.__all__: getattr(viewimit, name)\n{COMMANDS}"
    assert not loaded_by(everything) & {"viser", "pybullet", "trimesh", "resvg_py", "ziamath"}


def test_a_server_loads_what_reads_meshes_for_a_robot_of_ones_own_alone():
    begun = "import viewimit.app.server.serve, viewimit.app.page.page"
    with_meshes = f"{begun}\nfrom viewimit.simulation.robot import link_meshes\nlink_meshes('panda')"
    assert not loaded_by(with_meshes) & {"trimesh", "scipy"}


COMMANDS = (
    "import viewimit.commands.serve, viewimit.commands.imitate, viewimit.commands.landscape, viewimit.commands.bench"
)


def test_public_names_exist_and_are_documented():
    for name in viewimit.__all__:
        assert getattr(viewimit, name) is not None
        assert re.search(rf"\b{name}\b", viewimit.__doc__), f"{name} is missing from the docstring"
    assert set(viewimit.__all__) <= set(dir(viewimit))
    with pytest.raises(AttributeError, match="no attribute 'imitate_everything'"):
        viewimit.imitate_everything  # noqa: B018
