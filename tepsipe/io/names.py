"""Names that become files and folders, such as conditions of the trial sheet; paths of recordings."""

import unicodedata
from collections.abc import Iterable

from tepsipe.errors import InputError, quoted

LONGEST = 80
# of Snakemake and YAML in paths, and what no shell takes as it is; characters that are none, too
SPECIAL = set('{}<>*?"|')
# file names that Windows keeps for devices, with any ending
DEVICES = {
    "con",
    "prn",
    "aux",
    "nul",
    *(f"{name}{number}" for name in ("com", "lpt") for number in range(1, 10)),
}


def special_in(path: str) -> list[str]:
    """Characters of a path that Snakemake would take for a pattern, and those that cannot be printed."""
    return sorted({c for c in path if c in SPECIAL or not c.isprintable()})


def usable_name(name: str, longest: int = LONGEST - 5) -> str:
    """A name of letters, digits, dots and hyphens as `check_name` asks for, also with a number at its end."""
    short = name[:longest].strip(".-") or "trial"
    device = short.partition(".")[0].casefold() in DEVICES
    return f"trial-{short}"[:longest].strip(".-") if device else short


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
