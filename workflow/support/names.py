"""Names that become files and folders: conditions and tasks of the trial sheet."""

import unicodedata
from collections.abc import Iterable

from tepsipe.errors import InputError, quoted

LONGEST = 80
# file names that Windows keeps for devices, with any ending
DEVICES = {
    "con",
    "prn",
    "aux",
    "nul",
    *(f"{name}{number}" for name in ("com", "lpt") for number in range(1, 10)),
}


def check_name(name: str, what: str, here: str) -> None:
    """Refuse a name that could not be a file's, or not on every computer; ``here`` begins the message."""
    rule = (
        f"{here}: expected a {what} of letters, digits, dots and hyphens that begins with a letter or "
        f"digit and does not end with a dot, found {quoted(name)}: rename it"
    )
    if not name or not all(c.isalnum() or c in ".-" for c in name):
        raise InputError(rule)
    if not name[0].isalnum() or name.endswith("."):
        raise InputError(rule)
    if len(name) > LONGEST:
        raise InputError(
            f"{here}: expected a {what} of at most {LONGEST} characters, because it becomes a file name, "
            f"found {len(name)} ({quoted(name, 30)}): shorten it"
        )
    if name.partition(".")[0].casefold() in DEVICES:
        raise InputError(
            f"{here}: expected a {what} that can be a file name, found {name!r}, which Windows keeps for a "
            "device: rename it"
        )


def check_distinct(names: Iterable[str], what: str, here: str) -> None:
    """Refuse names that are one file where upper and lower case are not distinguished."""
    seen: dict[str, str] = {}
    for name in names:
        folded = unicodedata.normalize("NFC", name).casefold()
        other = seen.setdefault(folded, name)
        if other != name:
            raise InputError(
                f"{here}: expected each {what} to differ by more than upper and lower case, because file "
                f"names of many computers do not distinguish them, found {other!r} and {name!r}: rename one"
            )
