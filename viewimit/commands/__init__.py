"""One file a command: add_options(parser), and run(args) -> exit status."""


class BadInput(Exception):
    """What the user gave cannot be; the message names the option, the file or the line."""
