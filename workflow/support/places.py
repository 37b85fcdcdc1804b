"""Places of the project's files: one folder in a checkout, two in an installation.

A wheel has the library as the package ``tepsipe``, and everything else that studies need below its folder
``_study`` (`setup.py`).
"""

from functools import cache
from pathlib import Path

INSTALLED = "_study"
ROOT = Path(__file__).parents[2]


@cache
def library_beside(root: str) -> str:
    """Folder with the package ``tepsipe`` that belongs to a folder of rules."""
    return str(Path(root).parents[1]) if Path(root).name == INSTALLED else root


def place_of(path: str, root: str | Path) -> str:
    """Place of a file that is named as in a checkout, below the folder of rules or beside it."""
    root = str(root)
    return f"{library_beside(root) if f'{path}/'.startswith('tepsipe/') else root}/{path}"
