"""The header that all pages have, over each page of the documentation."""

from typing import Any

from sphinx.application import Sphinx
from viewimit.app.ways import Ways, header


def _add(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object) -> None:
    """The site's folder holds the documentation's; the theme's line for announcements takes the header."""
    context["theme_announcement"] = header(Ways.of_site("../" * (page.count("/") + 1)), "use")


def add_to(app: Sphinx) -> None:
    app.connect("html-page-context", _add)
