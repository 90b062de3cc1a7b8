"""What pyproject.toml cannot say: app/ and assets/ stand at the top and install inside viewimit; and what README is
on a package index, which has neither its picture nor the files that it links to."""

import re
from pathlib import Path

from setuptools import find_packages, setup

inside = {folder: f"viewimit.{folder}" for folder in ("app", "assets")}
packages = find_packages(include=["viewimit", "viewimit.*"])
for folder, name in inside.items():
    packages += [name, *(f"{name}.{package}" for package in find_packages(folder))]

readme = Path(__file__).with_name("README.md").read_text("utf-8")
readme = re.sub(r"^!\[[^\]]*\]\((?!https:)[^)]*\)\n+", "", readme, flags=re.MULTILINE)
readme = re.sub(r"\[([^\]]*)\]\((?!https:)[^)]*\)", r"\1", readme)

setup(
    packages=packages,
    package_dir={name: folder for folder, name in inside.items()},
    long_description=readme,
    long_description_content_type="text/markdown",
)
