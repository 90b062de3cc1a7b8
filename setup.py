"""What pyproject.toml cannot say: app/ and assets/ stand at the top and install inside viewimit; a release's wheel
holds the built documentation; and what README is on a package index, which has neither its picture nor the files that
it links to.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

from setuptools import find_packages, setup
from setuptools.command.build_py import build_py

HERE = Path(__file__).parent

inside = {folder: f"viewimit.{folder}" for folder in ("app", "assets")}
packages = find_packages(include=["viewimit", "viewimit.*"])
for folder, name in inside.items():
    packages += [name, *(f"{name}.{package}" for package in find_packages(folder))]

readme = (HERE / "README.md").read_text("utf-8")
readme = re.sub(r"^!\[[^\]]*\]\((?!https:)[^)]*\)\n+", "", readme, flags=re.MULTILINE)
readme = re.sub(r"\[([^\]]*)\]\((?!https:)[^)]*\)", r"\1", readme)


class BuildWithDocumentation(build_py):
    """As viewimit/site, with VIEWIMIT_DOCS=1, made by the modules that are being installed."""

    def run(self):
        super().run()
        if self.editable_mode or os.environ.get("VIEWIMIT_DOCS") != "1":
            return
        built = Path(self.build_lib).resolve()
        command = [sys.executable, str(HERE / "docs" / "build.py"), str(built / "viewimit" / "site")]
        found = [str(built), *filter(None, [os.environ.get("PYTHONPATH")])]  # where pip has put the generator
        subprocess.run(command, check=True, env=os.environ | {"PYTHONPATH": os.pathsep.join(found)})


setup(
    cmdclass={"build_py": BuildWithDocumentation},
    packages=packages,
    package_dir={name: folder for folder, name in inside.items()},
    long_description=readme,
    long_description_content_type="text/markdown",
)
