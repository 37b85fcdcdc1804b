"""Coverage study: the configuration of each drawn laboratory, and a run of its study.

Laboratory k has the coverage study's own configuration and trial sheet, but seeds of its own, and constants
drawn from its set. Every other laboratory is of the first set, which the analysis assumes; the others take
the further sets in turn. Neither depends on how many laboratories there are: those that are done stay.
"""

import copy
import json
import os
import runpy
import shutil
import sys
from collections.abc import Callable
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from random import Random

from tepsipe.errors import InputError, quoted
from tepsipe.signals.filters import WIDEST
from workflow.support.places import ROOT
from workflow.support.stopped import RECORDS, SENTENCE, records
from workflow.support.yaml_file import read_constants

TABLES = ("estimates", "uncertainty", "recovery")
RATE = "treadmill.capture.rate_hz"
# cutoffs of a standing person, which the analysis lowers to `WIDEST` of the rate
CUTOFFS = (("analysis", "stretch_cutoff_hz"), ("free_reflex", "lowpass_cutoff_hz"))


def set_of(coverage: dict, number: int) -> str:
    """Name of the set that a laboratory, counted from 1, is drawn from."""
    first, *others = coverage["sets"]
    return first if number % 2 or not others else others[(number // 2 - 1) % len(others)]


def seed_of(coverage: dict, number: int) -> int:
    """Seed of everything that is random in a laboratory and in the analysis of its recordings."""
    return Random(f"{coverage['seed']}/{number}").randrange(2**31)


def constants_of(constants: dict, coverage: dict, number: int) -> dict:
    """The constants before drawing, with what the laboratory's set changes; InputError for unknown ones."""
    name = set_of(coverage, number)
    chosen = coverage["sets"][name] or {}
    drawn = coverage.get("drawn", {}) | chosen.get("drawn", {})
    return changed_constants(constants, {**chosen, "drawn": drawn}, seed_of(coverage, number), name)


def changed_constants(constants: dict, chosen: dict, seed: int, name: str) -> dict:
    """The constants with a seed and with what a set, named in messages, changes and draws."""
    found = copy.deepcopy(constants) | {"seed": seed}
    for path, value in chosen.get("constants", {}).items():
        _replace(found, path, lambda _, value=value: value, name)
    for path, factor in chosen.get("factors", {}).items():
        _replace(found, path, lambda old, factor=factor: _times(old, factor), name)
    own = chosen["drawn"]
    if found["drawn"] is not None or own:
        drawn = {path: _changed(entry, chosen) for path, entry in (found["drawn"] or {}).items()}
        found["drawn"] = drawn | own
    return found


def _replace(constants: dict, path: str, change, name: str) -> None:
    *holders, last = path.split(".")
    place: object = constants
    for key in holders:
        place = place.get(key) if isinstance(place, dict) else None
    if not isinstance(place, dict) or last not in place or isinstance(place[last], dict):
        raise InputError(
            f"configuration: expected coverage.sets.{name} to name constants of the virtual laboratory, "
            f"found {quoted(path)}: correct it"
        )
    place[last] = change(place[last])


def _remove(settings: dict, path: str) -> None:
    """Take an entry, named by its keys joined by dots, out of settings; InputError if there is none."""
    *holders, last = path.split(".")
    place: object = settings
    for key in holders:
        place = place.get(key) if isinstance(place, dict) else None
    if not isinstance(place, dict) or last not in place:
        raise InputError(
            "configuration: expected coverage.left_out to name pathways or estimators of the configuration, "
            f"found {quoted(path)}: correct it"
        )
    del place[last]


def _times(value, factor: float):
    return [_times(part, factor) for part in value] if isinstance(value, list) else value * factor


def _changed(entry: dict, chosen: dict) -> dict:
    """An entry of ``drawn`` with the shape and the shift of the set."""
    entry = dict(entry)
    if chosen.get("student_freedom") is not None:
        if "rectangular" in entry:
            deviation = entry.pop("rectangular") / 3.0**0.5
        else:
            deviation = entry.pop("normal", None)
        deviation = entry["student"][0] if deviation is None else deviation
        entry["student"] = [deviation, chosen["student_freedom"]]
    if chosen.get("shift"):
        entry["shift"] = chosen["shift"]
    return entry


class Laboratories:
    """The laboratories of a coverage study; none of another study."""

    def __init__(self, config: dict) -> None:
        self.config, self.coverage = config, config["coverage"]

    @cached_property
    def constants(self) -> dict:
        """Constants of the file that the configuration names, which all laboratories have in common."""
        return read_constants(self.config["study"]["virtual_lab"])

    @cached_property
    def own_config(self) -> dict:
        """Configuration of a laboratory's study, which lies in a folder of its own, but for its seed."""
        own = copy.deepcopy(self.config)
        for path in self.coverage.get("left_out", []):
            _remove(own, path)
        own["coverage"] = None
        own["pathvars"] = {"results": "results", "logs": "results/logs"}
        own["study"] |= {"trial_sheet": "config/trials.tsv", "virtual_lab": "config/virtual_lab.yaml"}
        own["study"] |= {"recordings_folder": ".", "reported": None, "outside": False}
        return own

    @cached_property
    def sheet(self) -> str:
        """The trial sheet."""
        return Path(self.config["study"]["trial_sheet"]).read_text(encoding="utf-8")

    def about(self, number: int) -> dict:
        """Number, set and seed of a laboratory."""
        seed = seed_of(self.coverage, number)
        return {"number": number, "set": set_of(self.coverage, number), "seed": seed}

    def files(self, number: int, draw: Callable[[dict], dict]) -> dict[str, str]:
        """Path below the laboratory's folder -> text of the files that make it a study of its own.

        ``draw`` returns the constants after drawing: a laboratory knows the rate of its cameras.
        """
        constants = constants_of(self.constants, self.coverage, number)
        known = RATE in self.coverage.get("drawn", {})
        rate_hz = draw(constants)["treadmill"]["capture"]["rate_hz"] if known else None
        return self.files_of(constants, seed_of(self.coverage, number), rate_hz)

    def files_of(self, constants: dict, seed: int, rate_hz: float | None) -> dict[str, str]:
        """The same for given constants, seed of the analysis, and rate of the cameras if it is drawn."""
        own = self.own_config | {"study": self.own_config["study"] | {"seed": seed}}
        if rate_hz is not None:
            own |= _at_rate(own, rate_hz)
        return {
            "config/config.yaml": _text(own),
            "config/virtual_lab.yaml": _text(constants),
            "config/trials.tsv": self.sheet,
        }

    def all(self, name: str) -> list[str]:
        """A file of every laboratory, in their order."""
        last = self.coverage["laboratories"] if self.coverage else 0
        return [f"<results>/laboratories/{number}/{name}" for number in range(1, last + 1)]

    def sets(self) -> dict[str, dict]:
        """Set -> what it changes."""
        return {name: chosen or {} for name, chosen in (self.coverage or {"sets": {}})["sets"].items()}

    def drawn(self) -> dict[str, dict]:
        """Path of a constant -> its distribution in the first set."""
        if not self.coverage:
            return {}
        return (self.constants["drawn"] or {}) | self.coverage.get("drawn", {})


def _at_rate(config: dict, rate_hz: float) -> dict:
    """Sections of a configuration for cameras of a rate (Hz), with cutoffs that it allows."""
    standing = dict(config["standing"])
    for section, key in CUTOFFS:
        own = standing[section]
        standing[section] = own | {key: min(own[key], WIDEST * rate_hz)}
    return {
        "plate_treadmill": config["plate_treadmill"] | {"resample_rate_hz": rate_hz},
        "standing": standing,
    }


def _text(content: dict) -> str:
    """JSON, which is YAML, and ten times as fast to write."""
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def one_of_each_set(coverage: dict) -> list[int]:
    """The first laboratory of every set."""
    return [1, *(2 * k for k in range(1, len(coverage["sets"])))]


def run(files: dict[str, str], folder: Path) -> str:
    """Run a laboratory's study by the rules of this project, in this process; tables remain in the folder.

    Returns why it failed, in one sentence, if it would fail again; empty if it did not. Raises OSError if it
    was stopped by something else, such as a signal or a full disk: then the next run goes on from there.
    """
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        # what has not changed keeps its date, and what was done with it
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
    said = folder / "run.log"
    shutil.rmtree(folder / RECORDS, ignore_errors=True)
    status = _snakemake(folder, said)
    if status == 0:
        return ""
    stopped = records(folder)
    passing = [record for record in stopped if not record["lasting"]]
    for record in passing or stopped:
        sentence = record["said"] or f"{record['about']} ended without a word"
        if record["lasting"]:
            return sentence.removeprefix(SENTENCE)
        raise OSError(sentence)
    for line in said.read_text(encoding="utf-8", errors="replace").splitlines():
        if line.startswith(SENTENCE):
            return line.removeprefix(SENTENCE)
    raise OSError(f"{said}: expected the laboratory's study to end, found status {status}: look there")


def forget(folder: Path) -> None:
    """Remove everything of a laboratory's study but its configuration."""
    for name in ("results", ".snakemake"):
        shutil.rmtree(folder / name, ignore_errors=True)
    (folder / "run.log").unlink(missing_ok=True)


def _snakemake(folder: Path, said: Path) -> int:
    """Exit status of ``python -m snakemake`` in this process on a folder; what it says goes to a file.

    Jobs are processes that end with this one, also if it is killed.
    """
    arguments = ["--snakefile", str(ROOT / "Snakefile"), "--directory", str(folder.resolve())]
    configuration = str((folder / "config/config.yaml").resolve())
    arguments += ["--configfile", configuration, "--replace-workflow-config"]
    arguments += ["--executor", "tepsipe", "--cores", "1", "--scheduler", "greedy", "--rerun-incomplete"]
    # the run that has started this one holds the lock, and no other writes to this folder
    arguments += ["--nolock", "--quiet", "progress", "--workflow-profile", "none"]
    arguments += ["--", *(f"results/tables/{name}.csv" for name in TABLES)]
    with _elsewhere(said):
        sys.argv[1:] = arguments
        try:
            runpy.run_module("snakemake", run_name="__main__", alter_sys=True)
        except SystemExit as error:
            if isinstance(error.code, str):
                print(error.code, file=sys.stderr)
            return error.code if isinstance(error.code, int) else int(error.code is not None)
    return 0


@contextmanager
def _elsewhere(said: Path):
    """Let something change folder, environment, arguments and outputs of this process, and restore them."""
    here, kept, arguments = Path.cwd(), dict(os.environ), list(sys.argv)
    os.environ.pop("SNAKEMAKE_PROFILE", None)
    saved = [os.dup(stream) for stream in (1, 2)]
    sys.stdout.flush()
    sys.stderr.flush()
    with open(said, "w", encoding="utf-8") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
    try:
        yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for stream, former in zip((1, 2), saved, strict=True):
            os.dup2(former, stream)
            os.close(former)
        os.chdir(here)
        os.environ.clear()
        os.environ.update(kept)
        sys.argv = arguments
