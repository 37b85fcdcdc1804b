"""What the processes that share the tests of one run make once."""

import os
import time


def made_once(tmp_path_factory, name, make):
    """A folder that ``make(folder)`` fills, in the first process of this run that wants it; others wait."""
    shared = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:  # a folder of its own in that of the run
        shared = shared.parent
    folder, made, failed = shared / name, shared / f"{name}.made", shared / f"{name}.failed"
    try:
        folder.mkdir()
    except FileExistsError:
        deadline = time.monotonic() + 1200.0
        while not made.exists():
            assert not failed.exists(), f"another process of this run could not make {folder}"
            assert time.monotonic() < deadline, f"another process of this run takes too long with {folder}"
            time.sleep(0.2)
        return folder
    try:
        make(folder)
        made.touch()
    finally:
        if not made.exists():
            failed.touch()
    return folder
