"""What the library raises when its input cannot be used."""


class InputError(ValueError):
    """Input that cannot be used.

    The message is one sentence for the person who recorded the data: it names the file or the
    quantity, what was expected, what was found and what to do. No units; raised by every reader
    and by every step that could otherwise return a silent NaN.
    """
