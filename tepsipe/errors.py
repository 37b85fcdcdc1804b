"""Error raised for unusable input, and helpers for its message."""


class InputError(ValueError):
    """Error for input that cannot be used.

    The message is one sentence for the person who recorded the data: it names the file or the
    quantity, what was expected, what was found and what to do. It is raised by every reader
    and by every step that could otherwise return a silent NaN. Line breaks and control characters, as in
    the name of a file, are shown by their hexadecimal codes.

    Examples
    --------
    >>> from tepsipe import InputError, load_example
    >>> try:
    ...     load_example("dumy")
    ... except InputError as refused:
    ...     print(refused)
    load_example: expected the name of an example, found 'dumy': did you mean 'dummy'?
    """

    def __str__(self) -> str:
        return printable(super().__str__())


def printable(text: str) -> str:
    """Text on one line: characters that cannot be printed as their escapes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def quoted(text: object, length: int = 60) -> str:
    """Quote ``text`` for a message: in quotes, cut to ``length`` characters."""
    quotation = repr(str(text)) if not isinstance(text, float | int | None) else repr(text)
    return quotation if len(quotation) <= length else f"{quotation[:length]}..."


def listed(names, most: int = 20) -> str:
    """List names for a message, at most ``most`` of them."""
    names = list(names)
    shown = ", ".join(quoted(name) for name in names[:most]) or "nothing"
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"


def nearest(name: object, names) -> str:
    """End of a message about an unknown name: the most similar of some names, or all where none is."""
    import difflib

    names = [str(known) for known in names]
    close = difflib.get_close_matches(str(name), names, n=1, cutoff=0.5)
    return f"did you mean {close[0]!r}?" if close else f"choose one of {listed(names)}"


def refuse_other_kind(value: object, kind: type, function: str, maker: str) -> None:
    """Refuse an argument of ``function`` that is not a ``kind``, made by ``maker``."""
    if not isinstance(value, kind):
        raise InputError(
            f"{function}: expected a {kind.__name__}, found {quoted(type(value).__name__)}: make one with "
            f"tepsipe.{maker}"
        )
