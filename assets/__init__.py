"""Files that the package ships: robots (URDF, GLB), fonts and scenes; origins and licences in SOURCES.md."""

import pathlib

ROOT = pathlib.Path(__file__).parent
