"""The server: processes, connections, and the checks that a browser's messages pass."""
