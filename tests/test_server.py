"""Starting: what can go wrong is said before a server runs."""

import socket

import pytest
from viewimit.app.server import PortInUse, require_free, serve

from viewimit.session import Settings


def test_a_taken_port_is_named_with_the_next_free_one():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(PortInUse, match=rf"port {port} .* in use; try --port \d+"):
            require_free("127.0.0.1", port)


def test_bad_settings_fail_before_a_port_is_taken():
    with pytest.raises(ValueError, match="no scene 'moon'"):
        serve(port=0, settings=Settings(scene="moon"))
