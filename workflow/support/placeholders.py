"""Placeholders that `tepsipe new-study` writes for what no file shows: refused until they are filled in."""

from tepsipe.errors import InputError, listed
from tepsipe.new_study.plan import PLACEHOLDER


def refuse_placeholders(config: dict, name: str) -> None:
    """Raise one sentence that names all keys of a configuration that still hold the placeholder."""
    keys = placeholders(config)
    if keys:
        raise InputError(
            f"{name}: expected a value for {listed(keys, most=6)}, found the placeholder {PLACEHOLDER}: "
            f"fill in what {PLACEHOLDER}.md beside this file lists"
        )


def refuse_placeholder_cells(cells: dict[str, str], here: str) -> None:
    """Raise one sentence for a row of the trial sheet that still holds the placeholder."""
    columns = [column for column, cell in cells.items() if cell == PLACEHOLDER]
    if columns:
        raise InputError(
            f"{here}: expected a value for {listed(columns)}, found the placeholder {PLACEHOLDER}: "
            f"fill in what {PLACEHOLDER}.md beside the sheet lists"
        )


def placeholders(content, where: str = "") -> list[str]:
    """Keys with the placeholder, with the sections around them and dots in between."""
    if content == PLACEHOLDER:
        return [where]
    if isinstance(content, dict):
        return [
            k
            for key, value in content.items()
            for k in placeholders(value, f"{where}.{key}" if where else str(key))
        ]
    if isinstance(content, list):
        return list(dict.fromkeys(where for item in content if placeholders(item, where)))
    return []
