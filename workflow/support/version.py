"""Which version of the code is running."""

import subprocess
from pathlib import Path


def code_version(root: str | Path) -> dict[str, str | bool | None]:
    """Commit of the checkout, its date, and whether files differ from it; None where there is no checkout."""
    if not (Path(root) / ".git").exists():  # an installation, which may lie in a repository of the user
        return dict.fromkeys(("commit", "date", "modified"))

    def git(*arguments: str) -> str | None:
        command = ["git", "-C", str(root), *arguments]
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=True)
        except (OSError, subprocess.CalledProcessError):
            return None
        return done.stdout.strip()

    commit = git("rev-parse", "HEAD")
    changed = git("status", "--porcelain", "--untracked-files=no")
    date = git("show", "--no-patch", "--format=%cs", "HEAD")
    return {"commit": commit, "date": date, "modified": None if changed is None else bool(changed)}
