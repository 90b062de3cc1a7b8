"""Finds the packages: app/ and assets/ stand at the top and install inside viewimit. pyproject.toml cannot say so."""

from setuptools import find_packages, setup

inside = {folder: f"viewimit.{folder}" for folder in ("app", "assets")}
packages = find_packages(include=["viewimit", "viewimit.*"])
for folder, name in inside.items():
    packages += [name, *(f"{name}.{package}" for package in find_packages(folder))]
setup(packages=packages, package_dir={name: folder for folder, name in inside.items()})
