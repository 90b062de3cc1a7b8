"""Files that the package ships: robots (URDF, GLB), fonts and scenes; origins and licences in SOURCES.md. Nothing but
what made them imports the library."""

import pathlib

ROOT = pathlib.Path(__file__).parent
