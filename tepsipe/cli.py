"""The command line: ``tepsipe fit``, ``calibrate``, ``info``, ``new-study``, ``plan``, ``export`` and more.

Commands call the library; ``fit`` and ``calibrate`` its public functions. A command returns 0; if its input
cannot be used, it prints one sentence to the standard error and returns 2. ``check`` returns 1 if it finds a
fault that does not stop a run. Notes are printed to the standard error, too; with ``--strict``, a command
with notes returns 3. On a terminal, a line on the standard error shows that what takes more than 2 s is at
work. Nothing that takes time is imported before it is used.
"""

import argparse
import contextlib
import errno
import json
import math
import os
import re
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

from tepsipe import __version__
from tepsipe.errors import InputError, listed, nearest, printable, quoted


class Parser(argparse.ArgumentParser):
    """Parser that answers an unknown name with the nearest one, in one sentence."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.set_defaults(parser=self)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            name = "a command" if isinstance(action, argparse._SubParsersAction) else _name_of(action)
            self.error(f"expected {name}, found {quoted(value)}: {nearest(value, action.choices)}")

    def parse_known_args(self, args=None, namespace=None):  # type: ignore[override]
        """Parse arguments; of a command that hands them on to Snakemake, only its own options."""
        if not self._defaults.get("hands_on"):
            return super().parse_known_args(args, namespace)
        own = {option for action in self._actions for option in action.option_strings}
        chosen, _ = super().parse_known_args([word for word in args if word in own], namespace)
        chosen.others = [word for word in args if word not in own]
        return chosen, []

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
def progress(what: str) -> Iterator[Callable[[str], None]]:
    """Show on a terminal, from the third second on, that something is at work and for how long.

    Gives a function that takes how far it is, for example "3 of 12 files".
    """
    far = [""]
    if not sys.stderr.isatty():
        yield far.append
        return
    done = threading.Event()

    def show() -> None:
        seconds = 2
        done.wait(2.0)
        while not done.is_set():
            print(f"\r{printable(what + far[-1])}: {seconds} s\x1b[K", end="", file=sys.stderr, flush=True)
            seconds += 1
            done.wait(1.0)
        if seconds > 2:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

    shown = threading.Thread(target=show, daemon=True)
    shown.start()
    try:
        yield far.append
    finally:
        done.set()
        shown.join()


def show(text: str) -> None:
    """Print text, in which a file may have put characters that control a terminal: these as their escapes."""
    print("\n".join(map(printable, text.split("\n"))))


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

    text = json.dumps(plain(content), indent=1, ensure_ascii=False, allow_nan=False)
    print("".join(c if c.isprintable() or c == "\n" else json.dumps(c)[1:-1] for c in text))


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--json`` to a command."""
    parser.add_argument("--json", action="store_true", help="print the results as JSON")


def add_strict(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--strict`` to a command."""
    parser.add_argument("--strict", action="store_true", help="exit with code 3 if the result has notes")


def add_output(parser: argparse.ArgumentParser, metavar: str, default: str | None, text: str) -> None:
    """Add the option ``--output`` to a command."""
    path = None if default is None else Path(default)
    parser.add_argument("--output", type=Path, default=path, metavar=metavar, help=text)


# options of a design that a person types: name, type, unit, meaning and default
PLAN_OPTIONS = (
    ("stiffness", float, "Nm/rad", "expected K; default 10, of a standing person's ankles 400"),
    ("damping", float, "Nms/rad", "expected B; default 0.1, of a standing person's ankles 10"),
    ("number", int, "N", "perturbations; default 14, for a standing person 40, for a walking one 150"),
    ("amplitude", float, "m/s", "peak velocity of the pulse; default 0.3, for a standing person 0.4"),
    ("profile", str, "NAME", "profile of the pulse: sine (default), minjerk, half-sine or ramp"),
    ("duration", float, "s", "length of the pulse; default 0.1"),
    ("pathway", str, "NAME", "estimator: joint-likelihood (default), joint-likelihood-linear, leg or foot"),
    ("marker-noise", float, "m", "noise of a marker in each direction; default 6.5e-06"),
    ("camera-rate", float, "Hz", "rate of the cameras; default 250"),
    ("frame", float, "Hz", "fore-aft resonance of the empty treadmill under a standing person; default 52"),
    ("needed", str, "TABLE", "tables/needed.csv of a walking study, for --experiment walking"),
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    arguments: arguments after ``tepsipe``; the process's own if left out.
    Returns: 0, 1 where ``check`` finds a fault or ``compensate --strict`` writes nothing, 2 where the input
    cannot be used, or 3 where ``--strict`` is given and there are notes.
    """
    for stream in (sys.stdout, sys.stderr):  # a character that the terminal lacks is shown by its code
        with contextlib.suppress(AttributeError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    parser = _parser()
    if "_ARGCOMPLETE" in os.environ:  # the shell asks for completions
        import argcomplete

        argcomplete.autocomplete(parser)
    chosen = parser.parse_args(arguments)
    if chosen.command is None:
        parser.print_help()
        return 0
    try:
        notes = chosen.command(chosen) or ()
        if isinstance(notes, int):  # a command with exit codes of its own
            return notes
    except InputError as error:
        print(f"tepsipe: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # the output has been closed
        return 0
    except OSError as error:
        print(f"tepsipe: {printable(_refused_by_the_system(error))}", file=sys.stderr)
        return 2
    _print_notes(notes)
    return 3 if notes and chosen.strict else 0


def _print_notes(notes: Sequence[str]) -> None:
    for note in notes:
        print(f"tepsipe: note: {printable(note)}", file=sys.stderr)


def _refused_by_the_system(error: OSError) -> str:
    """Sentence about what the operating system has refused."""
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f"{error.filename or 'output'}: expected space to write to, found the disk full: free some"
    if error.filename is None and isinstance(error, FileNotFoundError):
        return "expected a working directory, found that it was removed: change to a folder that exists"
    return f"{error.filename or 'system'}: {error.strerror}: check the path and its permissions"


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="tepsipe",
        description="Estimate the mechanical impedance of a joint: inertia, damping and stiffness.",
    )
    parser.add_argument("--version", action="version", version=f"tepsipe {__version__}")
    parser.set_defaults(command=None, strict=False)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    for add in (_add_fit, _add_calibrate, _add_compensate, _add_info, _add_new_study, _add_plan):
        add(commands)
    for add in (_add_check, _add_run, _add_archive, _add_export, _add_benchmark):
        add(commands)
    return parser


# signal of a table -> its units; the first is that of a column whose name states none
FIT_UNITS = {
    "angle": ("rad", "deg"),
    "torque": ("Nm", "Nmm", "mNm"),
    "belt-velocity": ("m/s", "mm/s", "cm/s", "km/h"),
}


def _add_fit(commands: argparse._SubParsersAction) -> None:
    fit = commands.add_parser(
        "fit",
        help="estimate the impedance from a table of time, angle and torque",
        description="Estimate I, B and K from a text table of time, angle and torque. Prints a table "
        "and writes it as CSV, with a figure as PNG.",
    )
    fit.add_argument("table", type=Path, help="text table with a header: CSV or TSV, .gz allowed")
    for name, unit in (("time", " (s)"), ("angle", ""), ("torque", "")):
        fit.add_argument(f"--{name}", required=True, metavar="COLUMN", help=f"column of the {name}{unit}")
    fit.add_argument(
        "--belt-velocity",
        metavar="COLUMN",
        help="column of the belt velocity; with it, every perturbation is fitted separately",
    )
    fit.add_argument(
        "--rest",
        nargs=2,
        type=float,
        default=(2.0, 2.0),
        metavar=("BEFORE", "AFTER"),
        help="with --belt-velocity: unperturbed time at the start and at the end (s); default 2 2",
    )
    fit.add_argument(
        "--until",
        choices=("stop", "rest"),
        default="stop",
        help="with --belt-velocity: a window ends when the belt stops (default), or when the joint is at "
        "rest again, which narrows the interval of K of a passive joint",
    )
    fit.add_argument(
        "--baseline",
        choices=("rest", "each"),
        default="rest",
        help="with --belt-velocity: zero of angle and torque at rest (default), or before each perturbation",
    )
    for name, units in FIT_UNITS.items():
        text = f"default: the one that ends the column's name, else {units[0]}"
        fit.add_argument(f"--{name}-unit", choices=units, help=text)
    fit.add_argument(
        "--torque-sign",
        type=int,
        default=1,
        choices=(1, -1),
        help="-1 if a torque that resists a positive angle is recorded as negative",
    )
    fit.add_argument(
        "--model",
        default="ibk",
        choices=("ibk", "cascade"),
        help="ibk: one second-order model; cascade: intrinsic stiffness and stretch reflex",
    )
    fit.add_argument(
        "--cutoff",
        type=float,
        metavar="HZ",
        help="cutoff of the low-pass filter; default 20, with --model cascade 30",
    )
    fit.add_argument(
        "--thesis",
        action="store_true",
        help="do not subtract the torque at rest, as in the printed equation (3-9) of the thesis",
    )
    add_output(fit, "PREFIX", None, "write PREFIX.csv and PREFIX.png; default: the table's name with _fit")
    fit.add_argument(
        "--uncertainty",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="standard uncertainty of Type B: torque_scale or angle_scale (relative), or torque_delay_s (s), "
        "which --model cascade does not take; give the option once for each",
    )
    add_json(fit)
    add_strict(fit)
    fit.set_defaults(command=_fit)


def _add_calibrate(commands: argparse._SubParsersAction) -> None:
    calibrate = commands.add_parser(
        "calibrate",
        help="fit models of the belt-induced load to one recording and evaluate them on another",
        description="Fit models of the loads that an accelerated belt induces to TRAIN and evaluate them on "
        "TEST, two recordings of an unloaded treadmill: C3D or D-Flow text with force plates, or text "
        "tables. Prints the scores and writes them with the models, for tepsipe compensate.",
    )
    calibrate.add_argument(
        "train", type=Path, help="C3D, D-Flow text, or text table: time, load, belt velocity"
    )
    calibrate.add_argument("test", type=Path, help="another recording of the same treadmill")
    _add_belt(calibrate, ", once for each recording")
    calibrate.add_argument(
        "--cutoff", type=float, default=6.0, metavar="HZ", help="cutoff of the low-pass filter; default 6"
    )
    calibrate.add_argument(
        "--zero-lag", action="store_true", help="filter forwards and backwards, for offline use"
    )
    text = "write PREFIX.json, PREFIX.csv and PREFIX.png; default treadmill_models"
    add_output(calibrate, "PREFIX", "treadmill_models", text)
    add_json(calibrate)
    add_strict(calibrate)
    calibrate.set_defaults(command=_calibrate)


def _add_belt(command: argparse.ArgumentParser, often: str = "") -> None:
    """Add the options that name loads and belt velocity of a recording; ``often``: how often the latter."""
    command.add_argument(
        "--time",
        metavar="COLUMN",
        help="column of the time (s); default: the first of a table with three columns",
    )
    command.add_argument(
        "--load",
        action="append",
        default=[],
        metavar="NAME",
        help="in a table: column of a load; default: the second of three. In files with force plates: a name "
        "such as 'plate 1 Fy' or Fy; default: all loads. Give the option once for each load",
    )
    command.add_argument(
        "--load-unit", default="Nm", choices=("Nm", "N"), help="unit of the load in a table; default Nm"
    )
    command.add_argument(
        "--velocity",
        action="append",
        default=[],
        metavar="NAME",
        help="column or analog channel of the belt velocity; default: the third of three columns. Or a text "
        f"table with the velocity on the clock of the recording, as FILE or FILE:COLUMN{often}",
    )
    command.add_argument(
        "--velocity-scale",
        type=float,
        metavar="M/S",
        help="belt velocity per unit of the channel (m/s); default: from the channel's unit",
    )
    command.add_argument(
        "--velocity-offset",
        type=float,
        default=0.0,
        metavar="VALUE",
        help="value of the channel while the belt stands still; default 0",
    )
    command.add_argument(
        "--belt-markers",
        nargs="+",
        default=[],
        metavar="LABEL",
        help="belt-fixed markers, from which the velocity is derived",
    )


def _add_compensate(commands: argparse._SubParsersAction) -> None:
    compensate = commands.add_parser(
        "compensate",
        help="remove the belt-induced load from a recording: the same file with corrected loads",
        description="Subtract from a recording the loads that an accelerated belt induces, with the models "
        "of tepsipe calibrate. Writes the same kind of file with corrected forces, moments and centres of "
        "pressure. All other channels and parameters stay as they were. The models are listed in a note in "
        "the file. Prints the accuracy, and writes a figure of the loads before and after the correction.",
    )
    compensate.add_argument("recording", type=Path, help="C3D, D-Flow text or text table")
    compensate.add_argument(
        "--models", type=Path, required=True, metavar="FILE", help="models, as tepsipe calibrate writes them"
    )
    compensate.add_argument(
        "--output", type=Path, required=True, metavar="FILE", help="file to write; the figure is FILE.png"
    )
    _add_belt(compensate)
    compensate.add_argument(
        "--model", metavar="NAME", help="model for all loads; default: the recommended model of each"
    )
    add_json(compensate)
    compensate.add_argument(
        "--strict",
        action="store_true",
        help="write nothing and exit with code 1 if the belt moves outside the range of the calibration",
    )
    compensate.set_defaults(command=_compensate)


def _add_info(commands: argparse._SubParsersAction) -> None:
    info = commands.add_parser(
        "info",
        help="list the contents of a file: channels, rates, units, gaps",
        description="List the contents of a text table, a C3D, EDF or MATLAB file, an HDF5 file of the study "
        "or a file of treadmill models.",
    )
    info.add_argument("file", type=Path, help="file to read")
    info.add_argument(
        "--plot",
        nargs="?",
        type=Path,
        const=Path(),
        metavar="PNG",
        help="also draw the signals; default: the file's name with .png, in the current folder",
    )
    add_json(info)
    info.set_defaults(command=_info)


def _add_check(commands: argparse._SubParsersAction) -> None:
    check = commands.add_parser(
        "check",
        help="check a study before it runs, or the force plates of C3D files",
        description="For C3D files: look for faults of the force plates, such as a wrong origin, sign, axis "
        "or unit, an offset, drift, clipping or filters. The centre of pressure is compared with the markers "
        "of the feet. The exit code is 1 if there are findings, otherwise 0. Without C3D files: check the "
        "configuration files and the trial sheet that they name, without running anything from them. "
        "Repeated keys, unknown keys, and values, names and folders that cannot be used are reported with "
        "file and line. Then every recording is read as the study will read it: columns, rates, "
        'markers, plates, perturbations, masses. Lines with "to be recorded" list what K of a standing '
        'person still needs. Lines with "verdict" state for each trial of a dummy and each task of a person '
        "whether K will be quotable, and its expected interval or the reason. The exit code is 2 if the run "
        "would stop. It is 1 if the run would finish, but a recording has a fault, or there are verdicts and "
        "none is that K will be quotable. Otherwise it is 0. "
        "Run it in the folder of the study.",
    )
    check.add_argument(
        "files",
        nargs="*",
        metavar="FILE",
        help="C3D files; or configuration files, as for snakemake --configfile",
    )
    check.add_argument(
        "--mass", type=float, metavar="KG", help="for C3D files: mass of the person on the force plates"
    )
    add_json(check)
    check.set_defaults(command=_check)


def _add_run(commands: argparse._SubParsersAction) -> None:
    run = commands.add_parser(
        "run",
        usage="tepsipe run [-h] [--any-version] [TARGET ...] [option of Snakemake ...]",
        help="run the study in the current folder",
        description="Run the study in the current folder with Snakemake, on all cores, and go on after a run "
        "that was killed. A target is a file of the results or a trial, for example dummy/sine-0.3; without "
        "one, everything is made. Options of Snakemake are passed on: -n lists what would be run, -c2 uses "
        "two cores, --configfile FILE ... names further configuration files. requirements.txt of the study "
        "names the version of tepsipe that it was made with; another version is refused.",
    )
    run.add_argument(
        "--any-version", action="store_true", help="run a study that was made with another version of tepsipe"
    )
    run.set_defaults(command=_run, hands_on=True)


def _add_archive(commands: argparse._SubParsersAction) -> None:
    archive = commands.add_parser(
        "archive",
        help="write a finished study with its provenance into one zip file",
        description="Write the finished study in the current folder into one zip file, for a data repository "
        "or a colleague: settings, trial sheet, tables, figures and report, versions of all packages, "
        "checksums of the recordings, and the provenance of every result as a Workflow Run RO-Crate. In the "
        "unpacked folder, tepsipe run repeats the study, if the recordings are in its folder recordings "
        "(see --with-recordings).",
    )
    archive.add_argument(
        "files", nargs="*", metavar="CONFIG", help="configuration files, as for snakemake --configfile"
    )
    archive.add_argument(
        "--output", metavar="FILE", help="zip file to write; default: the name of the study, with .zip"
    )
    archive.add_argument("--with-recordings", action="store_true", help="also pack the recordings")
    archive.add_argument("--agent", metavar="NAME", help="person who ran the study, for the provenance")
    archive.add_argument(
        "--licence", metavar="LICENCE", help="licence of the zip file: an address or a name; default: none"
    )
    archive.set_defaults(command=_archive)


def _add_export(commands: argparse._SubParsersAction) -> None:
    export = commands.add_parser(
        "export",
        help="write a trial or a fit as a MATLAB or OpenSim file",
        description="Write a trial (results/trials) or a fit (results/fits) of the study as a MATLAB file "
        "(mat), its angle or ground reactions as an OpenSim motion file (mot), or its torque as an OpenSim "
        "storage file (sto).",
    )
    export.add_argument("file", type=Path, help="HDF5 file of the study")
    export.add_argument("--to", required=True, choices=("mat", "mot", "sto"), help="kind of file")
    export.add_argument(
        "--trial", type=Path, help="trial of the fit, needed if the fit's file has no time (mot, sto)"
    )
    export.add_argument("--pathway", help="pathway of the fit (mot, sto); default: leg")
    export.add_argument(
        "--coordinate",
        default="ankle_angle_r",
        help="coordinate of the OpenSim model (mot, sto); default ankle_angle_r",
    )
    text = "file to write; default: the input's name with the new ending, in the current folder"
    add_output(export, "FILE", None, text)
    export.set_defaults(command=_export)


def _add_benchmark(commands: argparse._SubParsersAction) -> None:
    benchmark = commands.add_parser(
        "benchmark",
        help="make problems with a hidden truth, answer them, and score answers",
        description="Make problems whose true values are kept in a separate file, answer them with published "
        "methods, and score answers. The problems are recordings of joints in simulated laboratories. Some "
        "contain a fault, which a method should flag.",
    )
    parts = benchmark.add_subparsers(title="parts", metavar="PART", required=True)
    make = parts.add_parser(
        "make",
        help="write problems into a folder, and their truth into a file",
        description="Write problems into FOLDER, as arrays and as files of instruments, and the truth into a "
        "file outside it. The same seed gives the same bytes. The seed reveals the truth: keep it until all "
        "answers are in.",
    )
    make.add_argument("folder", type=Path, help="new or empty folder, which may be published")
    make.add_argument("--seed", type=int, metavar="N", help="seed; default: a secret one of 128 bits")
    make.add_argument(
        "--per-kind", type=int, default=10, metavar="N", help="problems of each of four kinds; default 10"
    )
    make.add_argument(
        "--truth", type=Path, metavar="FILE", help="file of the truth; default FOLDER-truth.json, beside it"
    )
    make.set_defaults(command=_benchmark_make)
    score = parts.add_parser(
        "score",
        help="compare answers with the truth",
        description="Compare tables of answers with the truth: bias, RMS error, coverage and interval score "
        "on nominal problems, spoiled problems that are flagged, and false alarms. Prints a table and writes "
        "all scores as CSV, with a figure as PNG.",
    )
    score.add_argument(
        "answers",
        type=Path,
        nargs="+",
        help="table of answers (CSV); the name of the file is used as the name of the method",
    )
    score.add_argument("truth", type=Path, help="file with the true values, such as practice-truth.json")
    add_output(score, "PREFIX", "scores", "write PREFIX.csv and PREFIX.png")
    add_json(score)
    add_strict(score)
    score.set_defaults(command=_benchmark_score)
    baselines = parts.add_parser(
        "baselines",
        help="answer the problems by published methods",
        description="Answer the problems in FOLDER by published methods, among them those of this project, "
        "and write a table of answers for each.",
    )
    baselines.add_argument("folder", type=Path, help="folder of the problems")
    add_output(baselines, "DIR", "answers", "folder to write to; default answers")
    baselines.set_defaults(command=_benchmark_baselines)


def _benchmark_make(chosen: argparse.Namespace) -> None:
    options = _handed_on(chosen, "per-kind", "seed", "truth")
    _by_rules("benchmark", [*options, "--", str(chosen.folder)], "simulating")


def _benchmark_score(chosen: argparse.Namespace) -> Sequence[str]:
    import hashlib

    from tepsipe.drawing.style import save_png
    from tepsipe.reporting import benchmark

    table, png = _outputs(chosen.output, (".csv", ".png"), *chosen.answers, chosen.truth)
    truth = benchmark.read_truth(chosen.truth)
    rows, notes = [], []
    for path in chosen.answers:
        outcomes = benchmark.read_answers(path, truth)
        rows += benchmark.scores_of(path.stem, outcomes, truth)
        notes += benchmark.notes_of(str(path), outcomes, truth)
    benchmark.SCORES.write(table, rows)
    save_png(benchmark.draw_scores(rows), png)
    digest = hashlib.sha256(chosen.truth.read_bytes()).hexdigest()
    if chosen.json:
        scores = [vars(row) for row in rows]
        print_json({"scores": scores, "notes": notes, "truth": digest, "written": [table, png]})
    else:
        show(f"{benchmark.table_of(rows)}\n\nSHA-256 of the truth: {digest}\nwritten: {table}, {png}")
    return notes


def _benchmark_baselines(chosen: argparse.Namespace) -> None:
    from tepsipe.experiments.benchmark.baselines import METHODS, answer_all
    from tepsipe.experiments.benchmark.problems import ANSWERS, read_problems

    with progress(f"answering {chosen.folder}") as tell:
        answers = answer_all(read_problems(chosen.folder), METHODS, tell)
    chosen.output.mkdir(parents=True, exist_ok=True)
    for method, rows in answers.items():
        path = chosen.output / f"{method}.csv"
        ANSWERS.write(path, rows)
        show(f"written: {path}")


def _export(chosen: argparse.Namespace) -> None:
    from tepsipe.io.stored import read_stored
    from tepsipe.io.trial import Trial

    output = chosen.output or Path(f"{chosen.file.stem}.{chosen.to}")
    if _is_one_of(output, chosen.file, chosen.trial):
        raise InputError(f"{output}: expected a file of its own to write to, found the input: choose another")
    _refuse_missing_folder(output, "--output")
    content = read_stored(chosen.file)
    if chosen.to == "mat":
        from tepsipe.io.mat_export import export_mat

        export_mat(content, output)
    else:
        from tepsipe.io.opensim_export import motion_of, torque_of, write_storage

        trial = None if chosen.trial is None else read_stored(chosen.trial)
        if trial is not None and not isinstance(trial, Trial):
            raise InputError(
                f"{chosen.trial}: expected a trial, found a result: name a file of results/trials"
            )
        make = motion_of if chosen.to == "mot" else torque_of
        write_storage(make(content, str(chosen.file), trial, chosen.pathway, chosen.coordinate), output)
    show(f"written: {output}")


def _add_new_study(commands) -> None:
    """Arguments of ``tepsipe new-study``."""
    study = commands.add_parser(
        "new-study",
        help="write trial sheet and configuration for a folder of recordings",
        description="Inspect the recordings in a folder and write trials.tsv, config.yaml and MISSING.md, "
        "which lists what the files do not contain. Nothing is overwritten, and recordings are only read.",
    )
    study.add_argument("folder", type=Path, help="folder of the recordings")
    study.add_argument("--name", metavar="N", help="name of the study; default: the folder's name")
    add_output(study, "DIR", None, "folder to write to; default: a folder with the study's name")
    study.set_defaults(command=_new_study)


def _add_plan(commands: argparse._SubParsersAction) -> None:
    plan = commands.add_parser(
        "plan",
        help="predict the uncertainty of I, B and K in an experiment, and how many perturbations it needs",
        description="Predict the standard uncertainty of I, B and K in an experiment, Type A and Type B, and "
        "the number of perturbations that K needs. The defaults describe the ankle dummy and the treadmill "
        "of the thesis; a design file describes everything else. Prints a table and writes it as CSV, with a "
        "figure as PNG.",
    )
    plan.add_argument(
        "--design",
        type=Path,
        metavar="FILE",
        help="design file, TOML or JSON; the options below replace its values",
    )
    plan.add_argument(
        "--experiment",
        choices=("dummy", "standing", "walking"),
        help="ankle dummy, ankles of a standing person, or strides of a walking person; default dummy",
    )
    for name, kind, unit, meaning in PLAN_OPTIONS:
        plan.add_argument(f"--{name}", type=kind, metavar=unit, help=meaning)
    plan.add_argument(
        "--optimise", action="store_true", help="also find the best pulse within the limits of the design"
    )
    add_output(plan, "PREFIX", "plan", "write PREFIX.csv and PREFIX.png")
    add_json(plan)
    plan.set_defaults(command=_plan)


def _fit(chosen: argparse.Namespace) -> tuple[str, ...]:
    from tepsipe.drawing.style import save_png
    from tepsipe.identification.fits import fit_impedance, fit_parallel_cascade
    from tepsipe.identification.notes import of_column
    from tepsipe.io.readers.any_table import table_columns
    from tepsipe.io.readers.text_table import read_text_table
    from tepsipe.io.trial import Signal
    from tepsipe.signals.perturbations import find_perturbations

    if chosen.until == "rest" and (chosen.model == "cascade" or not chosen.belt_velocity):
        raise InputError(
            "--until: expected stop without perturbations, found rest: give --belt-velocity, and no --model "
            "cascade"
        )
    prefix = chosen.output or Path(chosen.table.name.split(".")[0] + "_fit")
    csv, png = _outputs(prefix, (".csv", ".png"), chosen.table)
    _, delimiter = table_columns(chosen.table)
    names = {"time": chosen.time, "angle": chosen.angle, "torque": chosen.torque}
    if chosen.belt_velocity:
        names["belt velocity"] = chosen.belt_velocity
    options = {key: f"--{key.replace(' ', '-')}" for key in names}
    table = read_text_table(chosen.table, names, delimiter, options)
    table["torque"] = chosen.torque_sign * table["torque"]
    signals, notes = {}, ()
    for key, unit, wanted in (
        ("time", None, "s"),
        ("angle", chosen.angle_unit, "rad"),
        ("torque", chosen.torque_unit, "Nm"),
        ("belt velocity", chosen.belt_velocity_unit, "m/s"),
    ):
        if key in names:
            unit, said = of_column(names[key], key, unit, wanted)
            signals[key], notes = Signal(table[key], unit), notes + said
    time, angle, torque = (signals[key] for key in ("time", "angle", "torque"))
    further = {} if chosen.cutoff is None else {"cutoff_hz": chosen.cutoff}
    if chosen.uncertainty:
        further["uncertainty"] = _stated(chosen.uncertainty)
    try:
        with progress(f"fitting {chosen.table.name}"):
            if chosen.model == "cascade":
                fit = fit_parallel_cascade(time, angle, torque, **further)
            elif chosen.belt_velocity:
                before, after = chosen.rest
                pulses = find_perturbations(
                    time,
                    signals["belt velocity"],
                    until=chosen.until,
                    angle=angle if chosen.until == "rest" else None,
                    rest_before_s=before,
                    rest_after_s=after,
                )
                further |= {"perturbations": pulses, "thesis": chosen.thesis, "baseline": chosen.baseline}
                fit = fit_impedance(time, angle, torque, **further)
            else:
                fit = fit_impedance(time, angle, torque, thesis=chosen.thesis, **further)
    except InputError as error:
        raise InputError(f"{chosen.table}: {_with_options(str(error))}") from error
    fit.to_frame().to_csv(csv)
    save_png(fit.plot(), png)
    notes = (*notes, *map(_with_options, fit.notes))
    if chosen.json:
        content = {name: getattr(fit, name) for name in ("estimator", "vaf", "vaf_of", "confidence")}
        content["findings"] = [*map(_with_options, fit.findings)]
        content["quantities"] = {name: vars(quantity) for name, quantity in fit.quantities.items()}
        content |= {"notes": notes, "perturbations": len(fit.windows), "written": [csv, png]}
        print_json(content)
    else:
        show(f"{_with_options(replace(fit, notes=()).summary())}\n\nwritten: {csv}, {png}")
    return notes


def _stated(options: list[str]) -> dict[str, float]:
    """Standard uncertainties by name, from ``NAME=VALUE``."""
    stated = {}
    for option in options:
        name, _, text = option.partition("=")
        try:
            value = float(text)
        except ValueError as error:
            raise InputError(
                f"--uncertainty: expected NAME=VALUE with a number, found {quoted(option)}: give, for "
                "example, torque_delay_s=0.0005"
            ) from error
        if name in stated:
            raise InputError(f"--uncertainty: expected each name once, found {name} twice: leave one out")
        stated[name] = value
    return stated


def _with_options(sentence: str) -> str:
    """Sentence of the library with options of the command instead of a `Signal` or an argument."""
    sentence = sentence.replace('find_perturbations with until="rest"', "--until rest")
    sentence = sentence.replace('baseline="each"', "--baseline each")
    return re.sub(
        r'Signal\((angle|torque|belt_velocity), "(\S+?)"\)',
        lambda found: f"--{found[1].replace('_', '-')}-unit {found[2]}",
        sentence,
    )


def _calibrate(chosen: argparse.Namespace) -> tuple[str, ...]:
    from tepsipe.drawing.style import save_png
    from tepsipe.experiments.belt.file_calibration import calibrate_files

    models, csv, png = _outputs(chosen.output, (".json", ".csv", ".png"), chosen.train, chosen.test)
    with progress("calibrating"):
        calibration = calibrate_files(
            chosen.train, chosen.test, _channels(chosen, 2), cutoff_hz=chosen.cutoff, zero_lag=chosen.zero_lag
        )
    calibration.save(models)
    calibration.to_frame().to_csv(csv, index=False)
    save_png(calibration.plot(), png)
    if chosen.json:
        contents = {}
        for load, one in calibration.loads.items():
            contents[load] = {name: getattr(one, name) for name in ("recommended", "validated", "notes")}
            contents[load]["scores"] = [vars(score) for score in one.scores]
            contents[load]["calibrated"] = next(iter(one.models.values())).calibrated
        content = contents.popitem()[1] if len(contents) == 1 else {"loads": contents}
        print_json(content | {"written": [models, csv, png]})
    else:
        show(f"{calibration.summary()}\n\nwritten: {models}, {csv}, {png}")
    return calibration.notes


def _channels(chosen: argparse.Namespace, count: int) -> list[Any]:
    """What is read of some recordings of a belt."""
    from tepsipe.experiments.belt.files import BeltChannels, BeltVelocity

    if len(chosen.velocity) not in (0, 1, count):
        raise InputError(
            f"--velocity: expected it once{' or twice' if count == 2 else ''}, found it "
            f"{len(chosen.velocity)} times: name a channel, or one file for each recording"
        )
    names = chosen.velocity or [None]
    further = tuple(chosen.belt_markers), chosen.velocity_scale, chosen.velocity_offset
    velocities = [BeltVelocity(name, *further) for name in (names * count)[:count]]
    return [BeltChannels(velocity, chosen.load, chosen.time, chosen.load_unit) for velocity in velocities]


def _compensate(chosen: argparse.Namespace) -> int:
    from tepsipe.drawing.style import save_png
    from tepsipe.experiments.belt.compensation import compensate

    (png,) = _outputs(chosen.output, (".png",), chosen.recording, chosen.models)
    (channels,) = _channels(chosen, 1)
    with progress(f"compensating {chosen.recording.name}"):
        done = compensate(
            chosen.recording, chosen.models, chosen.output, channels, model=chosen.model, strict=chosen.strict
        )
    refused = done.output is None
    _print_notes(done.notes)
    if not refused:
        save_png(done.plot(), png)
    written = [] if refused else [chosen.output, png]
    if chosen.json:
        loads = done.to_frame().to_dict("records")
        content = {"loads": loads, "kept": done.kept, "steps": done.steps, "notes": done.notes}
        pressure = {
            name: dict(zip(("shift_m", "half_width_m"), x, strict=True)) for name, x in done.pressure.items()
        }
        print_json(content | {"centre_of_pressure": pressure, "written": written})
    else:
        show(f"{done.summary()}\n\nwritten: {', '.join(map(str, written)) or 'nothing'}")
    return int(refused)


def _info(chosen: argparse.Namespace) -> None:
    from tepsipe.io.formats import contents_of

    with progress(f"reading {chosen.file.name}"):
        contents = contents_of(chosen.file)
    if chosen.json:
        channels = [
            {key: x for key, x in vars(channel).items() if not hasattr(x, "shape")}
            for channel in contents.channels
        ]
        content = {"file": chosen.file, "kind": contents.kind, "facts": contents.facts}
        print_json(content | {"channels": channels, "events": contents.events})
    else:
        show(f"{chosen.file}: {contents.summary()}")
    if chosen.plot is not None:
        from tepsipe.drawing.contents import draw_contents
        from tepsipe.drawing.style import save_png

        png = _picture(chosen.file, chosen.plot)
        save_png(draw_contents(contents, chosen.file.name), png)
        if not chosen.json:
            show(f"\nwritten: {png}")


def _new_study(chosen: argparse.Namespace) -> None:
    from tepsipe.new_study.start import commands_in
    from tepsipe.new_study.study import FILES, new_study

    with progress(f"looking into {chosen.folder}") as tell:
        made = new_study(chosen.folder, chosen.name, chosen.output, tell)
    for study in (made, *made.others):
        for experiment, count in study.trials.items():
            show(f"{experiment}: {count} {'trial' if count == 1 else 'trials'}")
        if study.left:
            show(f"files that are not used: {len(study.left)}, see {FILES[2]}")
        show(f"written to {study.folder}: {', '.join(study.files)}")
        show(f"assumed, to be checked: {study.assumed}, see {FILES[2]}")
        if study.missing:
            show(f"next: fill in what {study.folder / FILES[2]} lists (items: {study.missing}), then")
        show("\n".join(f"  {line}" for line in commands_in(study.folder)))


def _plan(chosen: argparse.Namespace) -> None:
    from tepsipe.drawing.style import save_png
    from tepsipe.experiments.planning.figures import plot_plan
    from tepsipe.reporting import plan_command as command

    names = (name.replace("-", "_") for name, *_ in PLAN_OPTIONS)
    options = {name: getattr(chosen, name) for name in names if getattr(chosen, name) is not None}
    design = command.design_of(chosen.design, chosen.experiment, options)
    if chosen.optimise and not isinstance(design, command.DummyDesign):
        raise InputError("plan: expected no --optimise for a person, found it: plan the pulses one by one")
    if isinstance(design, command.WalkingDesign):
        if chosen.json:
            raise InputError(
                "--json: expected a plan of the dummy or of a standing person, found walking: leave it out"
            )
        show(command.walking_summary(design))
        return
    table, png = _outputs(chosen.output, (".csv", ".png"))
    with progress("planning"):
        text, plans = command.carried_out(design, chosen.optimise, table)
    save_png(plot_plan(plans), png)
    if chosen.json:
        import pandas as pd

        print_json({"plan": pd.read_csv(table).to_dict("records"), "written": [table, png]})
        return
    show(f"{text}\n\nwritten: {table}, {png}")


def _picture(file: Path, wanted: Path) -> Path:
    """Name of the picture of a file: its own PNG in an existing folder."""
    png = Path(f"{file.name}.png") if wanted == Path() else wanted
    if png.suffix.lower() != ".png" or (
        png.exists() and (_is_one_of(png, file) or png.read_bytes()[:8] != b"\x89PNG\r\n\x1a\n")
    ):
        raise InputError(
            f"{png}: expected a PNG to write to, found a name of another kind or a file that is no picture: "
            "choose another name after --plot"
        )
    _refuse_missing_folder(png, "--plot")
    return png


def _refuse_missing_folder(file: Path, option: str) -> None:
    if not file.parent.is_dir():
        raise InputError(
            f"{option}: expected a folder that exists, found {quoted(file.parent)}: make it first"
        )


def _is_one_of(path: Path, *others: Path | None) -> bool:
    """Test for another path of the same file, which need not exist."""
    return os.path.realpath(path) in {os.path.realpath(other) for other in others if other is not None}


def _run(chosen: argparse.Namespace) -> NoReturn:
    from tepsipe.new_study.start import arguments_of_run, refuse_other_version, start_of

    if not chosen.any_version:
        refuse_other_version(Path())
    command, environment = start_of("run", arguments_of_run(chosen.others))
    sys.stdout.flush()
    os.execve(command[0], command, environment)


def _check(chosen: argparse.Namespace) -> int:
    from tepsipe.io.file_format import ending_of

    plates = [Path(file) for file in chosen.files if ending_of(file) == ".c3d"]
    if plates:
        return _check_plates(plates, chosen)
    if chosen.mass is not None or chosen.json:
        raise InputError(
            f"{'--json' if chosen.mass is None else '--mass'}: expected C3D files to check, found none: "
            f"leave it out"
        )
    from tepsipe.new_study.start import own_files

    return _by_rules("check", own_files(chosen.files), "reading the recordings")


def _archive(chosen: argparse.Namespace) -> None:
    from tepsipe.new_study.start import own_files

    options = _handed_on(chosen, "output", "agent", "licence")
    options += ["--with-recordings"] if chosen.with_recordings else []
    _by_rules("archive", [*options, *own_files(chosen.files)], "packing")


def _handed_on(chosen: argparse.Namespace, *names: str) -> list[str]:
    """Options that were given, as arguments of a module of the rules."""
    given = {name: getattr(chosen, name.replace("-", "_")) for name in names}
    return [f"--{name}={value}" for name, value in given.items() if value is not None]


def _by_rules(module: str, arguments: Sequence[str], what: str) -> int:
    """Run a module of the rules, print what it prints, and raise the last sentence of one that refuses.

    Returns: 0, or 1 where the module has found a fault that stops nothing.
    """
    import subprocess
    import tempfile

    from tepsipe.new_study.start import FAR, start_of

    command, environment = start_of(module, arguments)
    options: dict[str, Any] = {"encoding": "utf-8", "env": environment, "stderr": subprocess.PIPE}
    stderr = ""
    with progress(what) as tell, tempfile.TemporaryFile("w+", encoding="utf-8") as output:
        with subprocess.Popen(command, stdout=output, **options) as done:
            try:
                for line in done.stderr or ():
                    if line.startswith(FAR):
                        tell(f", {line.removeprefix(FAR).strip()}")
                    else:
                        stderr += line
            except BaseException:  # an interrupted command leaves no process behind
                done.kill()
                raise
        output.seek(0)
        stdout = output.read()
    if stdout:
        show(stdout.removesuffix("\n"))
    if done.returncode:
        said = stderr.strip().split("\n")
        refused = [line.removeprefix("tepsipe: ") for line in said if line.startswith("tepsipe: ")]
        if refused and done.returncode == 1:
            print(*(f"tepsipe: {printable(sentence)}" for sentence in refused), sep="\n", file=sys.stderr)
            return 1
        *others, last = refused or said[-1:]
        for sentence in others:
            print(f"tepsipe: {printable(sentence)}", file=sys.stderr)
        raise InputError(last)
    return 0


def _check_plates(files: list[Path], chosen: argparse.Namespace) -> int:
    """Findings in C3D files; 1 if there are any."""
    from tepsipe.ingest.plate_doctor import examine_plates

    if len(files) < len(chosen.files):
        raise InputError(
            f"check: expected C3D files only, or none, found {listed(chosen.files)}: check the others by "
            f"themselves"
        )
    if chosen.mass is not None and not 1.0 < chosen.mass < 1000.0:
        raise InputError(f"--mass: expected a mass of 1 to 1000 kg, found {chosen.mass:g}: correct it")
    found = {}
    for file in files:
        with progress(f"examining {file.name}"):
            found[file] = examine_plates(file, chosen.mass)
    if chosen.json:
        content = [
            {"file": file, "findings": [vars(finding) for finding in findings]}
            for file, findings in found.items()
        ]
        print_json({"files": content})
    else:
        for file, findings in found.items():
            lines = [f"{finding.fault}: {finding.place}: {finding.text}" for finding in findings]
            show("\n".join(f"{file}: {line}" for line in lines or ["no fault of a force plate was found"]))
    return int(any(found.values()))


def _outputs(prefix: Path, endings: Sequence[str], *inputs: Path) -> list[Path]:
    """Names of the files to write; an input is refused, and figures are drawn without a screen."""
    import matplotlib

    matplotlib.use("Agg")
    if not prefix.name:
        raise InputError(f"--output: expected the beginning of file names, found {quoted(prefix)}: add one")
    files = [prefix.with_name(prefix.name + ending) for ending in endings]
    for file in files:
        if _is_one_of(file, *inputs):
            raise InputError(
                f"{file}: expected a file of its own to write to, found the input: choose another --output"
            )
    _refuse_missing_folder(prefix, "--output")
    return files


if __name__ == "__main__":
    sys.exit(main())
