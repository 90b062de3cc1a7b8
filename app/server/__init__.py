"""Processes, connections, and what is refused of a browser. What a page does with a message is not here."""
