"""What files say, as a terminal and a message may be given it."""

MOST_SAID, MOST_NAME = 900, 80  # characters of a message that quotes what a file says, and of a name


def printable(text: str, most: int = MOST_SAID, keep: str = "") -> str:
    """Of what a file says no more than a person would read, and nothing that a terminal would obey: characters that do
    so are escaped, but those to keep."""
    if len(text) > most:
        text = f"{text[: most // 2]} … {text[-most // 2 :]}"
    return "".join(one if one.isprintable() or one in keep else ascii(one)[1:-1] for one in text)
