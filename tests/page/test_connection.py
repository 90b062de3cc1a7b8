"""In a browser: a connection that is lost is said where all look."""

import pytest
from browsing import open_page, wait
from serving import Server

pytestmark = pytest.mark.browser


def test_a_lost_connection_is_said_in_the_strip(browser):
    served = Server()
    page = open_page(browser, served.url)
    said = lambda: page.evaluate("getComputedStyle(document.querySelector('.vi-status'), '::before').content")
    assert said() == "none"
    assert served.stop() == 0
    wait(page, lambda: said() == '"Connection lost, reconnecting …"')
    page.close()
