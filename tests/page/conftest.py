"""Browser tests of the page that still expect its composition before it was laid out anew.

They are expected to fail until they have been read through, one file after the other; then their file leaves this list.
"""

from pathlib import Path

import pytest

HERE = Path(__file__).parent
REASON = "written for the page as it was laid out before"
TO_BE_READ = {
    "test_keys_and_names",
    "test_points_by_hand",
    "test_touching",
}  # most fail
SOME_FAIL = {
    "test_behind_nginx",
    "test_browser_scene",
    "test_layout",
    "test_presenting",
    "test_scene_nodes",
    "test_stylesheet",
    "test_unseen",
    "test_view",
}


def pytest_collection_modifyitems(items):
    for item in items:
        if item.path.parent == HERE and item.get_closest_marker("browser"):
            if item.path.stem in TO_BE_READ:
                item.add_marker(pytest.mark.xfail(reason=REASON, run=False))
            elif item.path.stem in SOME_FAIL:
                item.add_marker(pytest.mark.xfail(reason=REASON, strict=False))
