"""One file a command: add_options(parser), and run(args) -> exit status. What it prints is computed elsewhere."""


class BadInput(Exception):
    """What the user gave cannot be; the message names the option, the file or the line."""
