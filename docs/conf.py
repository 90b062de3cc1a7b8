"""How Sphinx builds the documentation; `python docs/build.py` asks it to."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from viewimit import __version__  # noqa: E402

project = "viewimit"
author = copyright = "The viewimit authors"
version = release = __version__
extensions = ["myst_parser", "directives"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_dmath_double_inline = True
myst_heading_anchors = 3
source_suffix = {".md": "markdown", ".ipynb": "markdown"}
exclude_patterns = ["directives"]
smartquotes = False  # two hyphens begin an option
html_theme = "furo"
html_title = f"viewimit {version}"
html_static_path = ["site.css", "reach.js"]
html_css_files = ["site.css"]
html_js_files = ["reach.js"]
html_math_renderer = "mathml"
html_show_search_summary = False  # it would fetch the pages, which no browser does from file://
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"top_of_page_buttons": []}
autodoc_member_order = "bysource"
autodoc_typehints = "signature"  # shapes and units, which types do not say, are in the tables of parameters
autodoc_typehints_format = "short"
python_maximum_signature_line_length = 80  # one parameter a line beyond
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
viewcode_line_numbers = True
html_search_scorer = str(Path(__file__).with_name("search_scorer.js"))  # how-tos first
autodoc_preserve_defaults = True
