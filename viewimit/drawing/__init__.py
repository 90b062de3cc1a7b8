"""SVG and HTML of images, landscapes, curves, equations and status, for the page, files and notebooks.

Drawings compute nothing: they are given snapshots, landscapes and the like. `export` also computes these for files.
"""
