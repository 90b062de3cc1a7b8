"""What the page's rules of style ask of a browser; how much of the page it styles anew, `test_unseen` measures."""

import re

from viewimit.app.static import stylesheet

OF_THE_ROOT = re.compile(r"(?<![\w-])(?::root|html|body|\.vi-presents)[^\s,{>+~]*:has\(")


def test_no_rule_asks_the_root_what_the_page_holds():
    """A browser would ask anew, and style all of the page anew, whatever comes or goes in it."""
    assert OF_THE_ROOT.search(":root:has(.vi-x) p{color:red}") and OF_THE_ROOT.search(
        ".vi-presents:not(:has(.vi-x)) p{}"
    )
    assert OF_THE_ROOT.findall(stylesheet()) == []
