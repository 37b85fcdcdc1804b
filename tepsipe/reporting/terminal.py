"""Parser, progress and JSON of the command line: nothing is imported here that takes time."""

import argparse
import contextlib
import json
import math
import sys
import threading
from collections.abc import Iterator, Mapping
from typing import Any, NoReturn

from tepsipe.errors import nearest, quoted


class Parser(argparse.ArgumentParser):
    """Parser that answers an unknown name with the nearest one, in one sentence."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.set_defaults(parser=self)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            name = "a command" if isinstance(action, argparse._SubParsersAction) else _name_of(action)
            self.error(f"expected {name}, found {quoted(value)}: {nearest(value, action.choices)}")

    def parse_args(self, args=None, namespace=None):  # type: ignore[override]
        """Parse all arguments; an unknown option is answered by the command that it was given to."""
        chosen, unknown = self.parse_known_args(args, namespace)
        if unknown:
            chosen.parser.refuse(unknown[0])
        return chosen

    def refuse(self, unknown: str) -> NoReturn:
        """End because of an argument that the command does not have."""
        options = [option for action in self._actions for option in action.option_strings]
        if unknown.startswith("-"):
            self.error(
                f"expected an option of this command, found {quoted(unknown)}: {nearest(unknown, options)}"
            )
        self.error(f"expected no further argument, found {quoted(unknown)}: leave it out")

    def error(self, message: str) -> NoReturn:
        """Print one sentence and end with 2."""
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")


def _name_of(action: argparse.Action) -> str:
    return f"one of the values of {action.option_strings[0]}" if action.option_strings else str(action.dest)


@contextlib.contextmanager
def progress(what: str) -> Iterator[None]:
    """Show on a terminal, from the third second on, that something is at work and for how long."""
    if not sys.stderr.isatty():
        yield
        return
    done = threading.Event()

    def show() -> None:
        seconds = 2
        done.wait(2.0)
        while not done.is_set():
            print(f"\r{what}: {seconds} s", end="", file=sys.stderr, flush=True)
            seconds += 1
            done.wait(1.0)
        if seconds > 2:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

    shown = threading.Thread(target=show, daemon=True)
    shown.start()
    try:
        yield
    finally:
        done.set()
        shown.join()


def print_json(content: Mapping[str, Any]) -> None:
    """Print as JSON, with null for numbers that are not finite."""

    def plain(x: Any) -> Any:
        if isinstance(x, Mapping):
            return {key: plain(value) for key, value in x.items()}
        if isinstance(x, list | tuple):
            return [plain(value) for value in x]
        if isinstance(x, float):
            return float(x) if math.isfinite(x) else None
        return x if isinstance(x, str | int | None) else str(x)

    print(json.dumps(plain(content), indent=1, ensure_ascii=False, allow_nan=False))


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--json`` to a command."""
    parser.add_argument("--json", action="store_true", help="print the results as JSON")


def add_strict(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--strict`` to a command."""
    parser.add_argument("--strict", action="store_true", help="exit with code 3 if the result has notes")
