"""How wheels are built: as setuptools does, with the documentation in them, whose examples are executed for it.

Only a wheel asks for the generator and for what the examples need; an editable install asks for neither.
"""

import re
from pathlib import Path

from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

HERE = Path(__file__).parent
NEEDLESS = {"viser", "websockets", "segno"}  # of the page


def get_requires_for_build_wheel(config_settings=None):
    return [*build_meta.get_requires_for_build_wheel(config_settings), *documentation_needs()]


def documentation_needs():
    """Requirements of docs/build.py; none where there is no documentation to build."""
    if not (HERE / "docs" / "conf.py").is_file():
        return []
    project = tomllib.loads((HERE / "pyproject.toml").read_text("utf-8"))["project"]
    needs = [*project["dependencies"], *project["optional-dependencies"]["docs"]]
    return [need for need in needs if re.match(r"[\w.-]+", need)[0] not in NEEDLESS]
