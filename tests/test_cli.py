"""The commands: what they print and write, and one sentence on the standard error where they cannot."""

import ast
import csv
import io
import json
import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from tepsipe import load_example
from tepsipe.arguments import unit_in
from tepsipe.cli import main, progress
from tepsipe.io.formats import contents_of

COLUMNS = ["--time", "time_s", "--angle", "angle_rad", "--torque", "torque_Nm"]


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    path = tmp_path_factory.mktemp("table") / "perturbed_joint.csv"
    load_example("dummy").to_frame().to_csv(path, index=False, float_format="%.7g")
    return str(path)


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def refused(capsys, *arguments):
    assert main(list(map(str, arguments))) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("tepsipe: ")
    return lines[0]


def rows(path):
    with open(path, newline="") as file:
        return {row["quantity"]: row for row in csv.DictReader(file)}


def test_no_command_prints_help(capsys):
    assert main([]) == 0
    assert "calibrate" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["fit", "calibrate", "info", "new-study", "plan"])
def test_every_command_has_help(command, capsys):
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0
    assert f"usage: tepsipe {command}" in capsys.readouterr().out


def test_fit_perturbation_by_perturbation(table, capsys, tmp_path):
    assert main(["fit", table, *COLUMNS, "--belt-velocity", "belt_velocity_m_per_s"]) == 0
    out = capsys.readouterr().out
    assert "mean over 14 perturbations" in out
    found = rows(tmp_path / "perturbed_joint_fit.csv")
    assert float(found["K"]["value"]) == pytest.approx(10.0, rel=0.03)
    assert float(found["I"]["value"]) == pytest.approx(0.02, rel=0.02)
    assert float(found["B"]["value"]) == pytest.approx(0.15, rel=0.05)
    assert float(found["K"]["low"]) < 10.0 < float(found["K"]["high"])
    assert (tmp_path / "perturbed_joint_fit.png").stat().st_size > 5000


def test_fit_until_the_joint_is_at_rest_narrows_the_interval(table, capsys, tmp_path):
    belt = ["--belt-velocity", "belt_velocity_m_per_s"]
    widths = []
    for until in ([], ["--until", "rest"]):
        assert main(["fit", table, *COLUMNS, *belt, *until, "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        widths.append(found["quantities"]["K"]["high"] - found["quantities"]["K"]["low"])
        assert ["--until rest gives about K" in finding for finding in found["findings"]] == [True] * (
            not until
        )
    assert widths[1] < widths[0] / 2.2
    assert main(["fit", table, *COLUMNS, *belt, "--baseline", "each", "--json"]) == 0
    own = json.loads(capsys.readouterr().out)["quantities"]["K"]
    assert own["low"] < 10.0 < own["high"] and own["high"] - own["low"] != widths[0]
    line = refused(capsys, "fit", table, *COLUMNS, "--until", "rest")
    assert "--until: expected stop without perturbations, found rest: give --belt-velocity" in line
    refused(capsys, "fit", table, *COLUMNS, *belt, "--until", "rest", "--model", "cascade")


def test_fit_of_a_whole_record_in_other_units(table, capsys, tmp_path):
    values = np.loadtxt(table, delimiter=",", skiprows=1)
    values[:, 1] = np.degrees(values[:, 1])
    values[:, 2] *= -1e3
    np.savetxt("other.tsv", values[:, :3], delimiter="\t", header="t\ttheta\tM", comments="", fmt="%.7g")
    options = ["--angle-unit", "deg", "--torque-unit", "Nmm", "--torque-sign", "-1", "--output", "there"]
    assert main(["fit", "other.tsv", "--time", "t", "--angle", "theta", "--torque", "M", *options]) == 0
    assert float(rows("there.csv")["K"]["value"]) == pytest.approx(10.0, rel=0.03)
    assert main(["fit", table, *COLUMNS, "--output", "same"]) == 0
    same, there = (float(rows(f"{name}.csv")["K"]["value"]) for name in ("same", "there"))
    assert there == pytest.approx(same, rel=1e-4)


def test_unit_of_the_belt_velocity_is_that_of_its_name_or_an_option(table, capsys):
    values = np.loadtxt(table, delimiter=",", skiprows=1, usecols=range(4))
    values[:, 3] *= 1e3
    for name, options in (("belt_mm_s", []), ("belt", ["--belt-velocity-unit", "mm/s"])):
        header = f"time_s,angle_rad,torque_Nm,{name}"
        np.savetxt("fast.csv", values, delimiter=",", header=header, comments="", fmt="%.7g")
        assert main(["fit", "fast.csv", *COLUMNS, "--belt-velocity", name, *options]) == 0
        assert "mean over 14 perturbations" in capsys.readouterr().out
    line = refused(capsys, "fit", "fast.csv", *COLUMNS, "--belt-velocity", "belt")
    assert line.endswith("which looks like mm/s: give --belt-velocity-unit mm/s")


def test_notes_go_to_the_standard_error_and_strict_returns_3(table, capsys):
    arguments = ["fit", table, *COLUMNS, "--belt-velocity", "belt_velocity_m_per_s"]
    assert main([*arguments, "--strict"]) == 0
    assert capsys.readouterr().err == ""
    assert main([*arguments, "--torque-sign", "-1"]) == 0
    captured = capsys.readouterr()
    assert captured.err.startswith("tepsipe: note: Below 0: ")
    assert "reversed" in captured.err
    assert "Below 0" not in captured.out
    assert main([*arguments, "--torque-sign", "-1", "--strict"]) == 3


def test_unit_of_a_column_is_that_of_its_name(table, capsys):
    values = np.loadtxt(table, delimiter=",", skiprows=1)
    values[:, 0] *= 1e3
    values[:, 1] = np.degrees(values[:, 1])
    head = "time_ms,angle_deg,M"
    np.savetxt("named.csv", values[:, :3], delimiter=",", header=head, comments="", fmt="%.9g")
    named = ["fit", "named.csv", "--time", "time_ms", "--angle", "angle_deg", "--torque", "M"]
    assert main([*named, "--output", "converted"]) == 0
    assert "note: The angle was converted from deg to rad" in capsys.readouterr().err
    assert float(rows("converted.csv")["K"]["value"]) == pytest.approx(10.0, rel=0.03)
    assert main([*named, "--angle-unit", "rad", "--output", "other"]) == 0
    assert "its column is called 'angle_deg': check --angle-unit" in capsys.readouterr().err


@pytest.mark.slow
def test_fit_of_the_parallel_cascade(capsys):
    rng = np.random.default_rng(2)
    time = np.arange(0.0, 30.0, 0.004)
    angle = 0.02 * np.convolve(rng.standard_normal(time.size), np.hanning(60) / 5.5, mode="same")
    torque = 1.2 * np.gradient(angle, time) + 70.0 * angle + 0.01 * rng.standard_normal(time.size)
    np.savetxt(
        "joint.csv", np.column_stack([time, angle, torque]), delimiter=",", header="t,a,m", comments=""
    )
    arguments = ["fit", "joint.csv", "--time", "t", "--angle", "a", "--torque", "m", "--model", "cascade"]
    assert main(arguments) == 0
    assert float(rows("joint_fit.csv")["K"]["value"]) == pytest.approx(70.0, rel=0.05)
    assert "held-out torque" in capsys.readouterr().out


def test_calibrate_writes_models_scores_and_figure(capsys, tmp_path):
    for seed in (1, 2):
        rng = np.random.default_rng(seed)
        time = np.arange(0.0, 60.0, 0.01)
        velocity = 1.2 + 0.02 * np.convolve(rng.standard_normal(time.size), np.hanning(20), mode="same")
        moment = 6.0 * np.gradient(velocity, time) + 0.1 * rng.standard_normal(time.size)
        np.savetxt(
            f"run{seed}.txt",
            np.column_stack([time, moment, velocity]),
            delimiter="\t",
            header="Time (s)\tMoment (Nm)\tVelocity (m/s)",
            comments="",
        )
    assert main(["calibrate", "run1.txt", "run2.txt", "--output", "belt"]) == 0
    out = capsys.readouterr().out
    assert "The tests were not used to choose it." in out
    assert "ripple-tracking follows the measured load" in out
    models = json.loads((tmp_path / "belt.json").read_text())["models"]
    assert {model["name"] for model in models} >= {"fir"}
    low, high = models[0]["calibrated"]["values"]["velocity"]
    assert low < 1.2 < high
    with open("belt.csv", newline="") as file:
        assert all(float(row["r2"]) > 0.9 for row in csv.DictReader(file))
    assert contents_of("belt.json").kind == "treadmill models"
    said = refused(capsys, "calibrate", "run1.txt", "run1.txt")
    assert "two separate recordings" in said
    # a test at twice the speed lies outside the range of the calibration
    time, moment, velocity = np.loadtxt("run2.txt", skiprows=1).T
    header = "Time (s)\tMoment (Nm)\tVelocity (m/s)"
    fast = np.column_stack([time, moment, 2.0 * velocity])
    np.savetxt("fast.txt", fast, delimiter="\t", header=header, comments="")
    assert main(["calibrate", "run1.txt", "fast.txt", "--output", "belt", "--strict"]) == 3
    printed = capsys.readouterr()
    assert printed.err.count("tepsipe: note: ") == 1
    assert "fast.txt" in printed.err
    assert "Note:" not in printed.out


def test_refusals_are_one_sentence(table, capsys, tmp_path):
    assert "no file" in refused(capsys, "fit", "missing.csv", *COLUMNS)
    said = refused(capsys, "fit", table, "--time", "time_s", "--angle", "angle", "--torque", "torque_Nm")
    assert "'angle_rad'" in said
    assert "--angle" in said
    said = refused(capsys, "fit", table, *COLUMNS, "--angle-unit", "deg", "--output", "nowhere/fit")
    assert "nowhere" in said
    (tmp_path / "own.csv").write_bytes(open(table, "rb").read())
    said = refused(capsys, "fit", "own.csv", *COLUMNS, "--output", "own")
    assert "the input" in said
    (tmp_path / "short.csv").write_text("t,a,m\n0,0,0\n1,1,1\n")
    assert "short.csv: time" in refused(
        capsys, "fit", "short.csv", "--time", "t", "--angle", "a", "--torque", "m"
    )
    assert "expected three columns" in refused(capsys, "calibrate", table, table)
    (tmp_path / "numbers.csv").write_text("1,2,3\n4,5,6\n")
    assert "header" in refused(capsys, "info", "numbers.csv")
    (tmp_path / "a.docx").write_text("x")
    assert ".c3d" in refused(capsys, "info", "a.docx")
    assert refused(capsys, "info", "none.c3d").count("none.c3d") == 1


def test_info_shows_channels_rates_units_and_gaps(table, capsys, dummy_files):
    assert main(["info", table]) == 0
    out = capsys.readouterr().out
    assert "250" in out
    assert "angle_rad" in out
    c3d = contents_of(dummy_files["markers"])
    assert c3d.channels[0].rate_hz == 250.0
    assert c3d.channels[0].unit == "mm"
    log = {c.name: c for c in contents_of(dummy_files["log"]).channels}
    assert log["belt_velocity_m_per_s"].unit == "m/s"
    assert log["belt_velocity_m_per_s"].rate_hz == 1000.0


def test_info_counts_gaps_and_names_columns_of_text(tmp_path):
    (tmp_path / "t.csv").write_text("time [ms],x (mm),note\n0,1,a\n10,,b\n20,3,c\n30,4,d\n")
    contents = contents_of(tmp_path / "t.csv")
    x = {c.name: c for c in contents.channels}["x (mm)"]
    assert (x.missing, x.unit, x.rate_hz, x.high) == (1, "mm", 100.0, 4.0)
    assert contents.facts["columns of text"] == "note"


@pytest.mark.parametrize(
    ("name", "unit"),
    [("Torque (Nm)", "Nm"), ("angle [deg]", "deg"), ("v_m_per_s", "m/s"), ("trial", ""), ("a(b)c", "")],
)
def test_unit_in_the_name_of_a_column(name, unit):
    assert unit_in(name) == unit


@pytest.mark.parametrize(
    ("name", "kind", "channel", "rate_hz"),
    [
        ("c3d/Gait.c3d", "C3D", "RSHO", 100.0),
        ("c3d/HC002D06.c3d", "C3D", "HEDO", 100.0),
        ("human-ankle/ankle_trial1.csv.gz", "text table", "ankle_torque_Nm", 1000.0),
        ("quiet-standing/BDS00001.txt.gz", "text table", "Fz[N]", 100.0),
    ],
)
def test_info_reads_recordings_made_by_others(name, kind, channel, rate_hz, real_data):
    contents = contents_of(real_data(name))
    assert contents.kind == kind
    assert {c.name: c for c in contents.channels}[channel].rate_hz == pytest.approx(rate_hz)


def test_plan_writes_what_it_prints(capsys, tmp_path):
    (tmp_path / "own.toml").write_text("[protocol]\nnumber = 5\ninterval_s = 2\n")
    options = ("--design", "own.toml", "--number", "3", "--pathway", "leg", "--amplitude", "0.1")
    assert main(["plan", *options]) == 0
    out = capsys.readouterr().out
    found = rows(tmp_path / "plan.csv")
    assert found["K"]["unit"] == "Nm/rad" and float(found["K"]["predicted_u"]) > 0.01
    assert f"K +-20 % (95 %): {found['K']['n_for_20_percent']}" in out
    assert "3 perturbations (sine) in 12 s, leg" in out
    assert (tmp_path / "plan.png").read_bytes()[:4] == b"\x89PNG"


SHORT = "[protocol]\nnumber = 2\ninterval_s = 1.5\nrest_before_s = 1.5\nrest_after_s = 1.5\n"


@pytest.mark.parametrize(
    ("design", "arguments", "words"),
    [
        ("[leg]\nmass_kg = -1", [], "own.toml: Leg: mass_kg: expected a number above 0"),
        ("[limits]\njerk_m_per_s3 = 100", [], "expected --optimise with limits"),
        ("returning = true", [], "expected --optimise"),
        (
            "[limits]\njerk_m_per_s3 = 0",
            ["--optimise"],
            "expected a number above 0 for 'jerk_m_per_s3', found 0",
        ),
        ("[tolerances]\nleg_mas_kg = 0.1", [], "own.toml: tolerances, uncertainty: expected a known source"),
        ("[tolerances]\nleg_mass_kg = -0.1", [], "a standard uncertainty of at least 0 for leg_mass_kg"),
        (SHORT, ["--output", "nowhere/plan"], "folder that exists"),
        (
            "protocl = {number = 2}",
            [],
            "found 'protocl': did you mean 'protocol'?",
        ),
        (
            "[rig]\nmarker_noise = 1",
            [],
            "own.toml: rig: expected a known key, found 'marker_noise'",
        ),
        (
            "[rig]\nmarker_noise_m = '1'",
            [],
            "own.toml: rig: expected a value of type number for 'marker_noise_m', found '1'",
        ),
        ("[rig]\nmarker_noise_m = -1", [], "own.toml: rig: expected a number above 0 for 'marker_noise_m'"),
        ("[rig]\nleg_markers = []", [], "own.toml: rig: expected a known key, found 'leg_markers'"),
        (
            "[rig.drive]\nbandwidth_hz = true",
            [],
            "rig.drive: expected a value of type number or null for 'bandwidth_hz', found True",
        ),
        ("[rig]\ndrive = 14", [], "own.toml: rig: expected a value of type object for 'drive', found 14"),
        ("[joint]\nrest_angle_rad = 0.1", [], "own.toml: joint: expected a known key"),
        (
            "[protocol]\nnumber = 2.5",
            [],
            "own.toml: protocol: expected a value of type integer for 'number', found 2.5",
        ),
        (
            "[protocol]\nzero_lag = 1",
            [],
            "own.toml: protocol: expected a value of type boolean for 'zero_lag', found 1",
        ),
        ("[protocol]\nprofile = 'saw'", [], "own.toml: pulse: expected a profile of 'sine'"),
        ("[rig.drive]\nbandwith_hz = 14", [], "rig.drive: unknown key 'bandwith_hz': did you mean"),
        (
            "[protocol]\namplitude_m_per_s = 10\nduration_s = 1\ninterval_s = 5\nnumber = 3",
            ["--stiffness", "2"],
            "protocol: expected a leg that stays upright",
        ),
        ("returning = 1", [], "own.toml: returning: expected true or false, found 1"),
        ("protocol = 5", ["--number", "3"], "own.toml: protocol: expected keys and values, found 5"),
        (
            "experiment = 'sitting'",
            [],
            "own.toml: experiment: expected one of 'dummy', 'standing'",
        ),
        ("number = 1\nnumber = 2", [], "own.toml: expected a design as TOML"),
        (
            "",
            ["--pathway", "sea"],
            "expected one of 'joint-likelihood', 'joint-likelihood-linear', 'leg', 'foot'",
        ),
        ("", ["--design", "none.toml"], "none.toml: expected a design file, found no file"),
        ("", ["--experiment", "standing", "--pathway", "leg"], "no --pathway with the experiment standing"),
        ("", ["--needed", "needed.csv"], "no --needed with the experiment dummy"),
    ],
)
def test_plans_that_cannot_be_are_refused(design, arguments, words, capsys, tmp_path):
    (tmp_path / "own.toml").write_text(design)
    assert words in refused(capsys, "plan", "--design", "own.toml", *arguments)


@pytest.mark.parametrize("content", ['{"rig": {}, "rig": {}}', "[1]", "{", "[" * 100_000])
def test_a_design_that_is_no_json_is_refused(content, capsys, tmp_path):
    (tmp_path / "own.json").write_text(content)
    assert "own.json: expected " in refused(capsys, "plan", "--design", "own.json")


# ---- what a terminal shows -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fitt"], "expected a command, found 'fitt': did you mean 'fit'?"),
        (["fit", "a.csv", "--model", "cascad"], "--model, found 'cascad': did you mean 'cascade'?"),
        (["info", "a.csv", "--plto"], "found '--plto': did you mean '--plot'?"),
        (["info", "a.csv", "b.csv"], "expected no further argument, found 'b.csv'"),
    ],
)
def test_wrong_names_are_answered_with_the_nearest(arguments, words, capsys):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert words in said
    assert len(said.splitlines()) == 1
    assert "argument :" not in said


def test_results_are_printed_as_json(table, capsys):
    assert main(["fit", table, *COLUMNS, "--belt-velocity", "belt_velocity_m_per_s", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["quantities"]["K"]["value"] == pytest.approx(10.0, rel=0.03)
    assert found["perturbations"] == 14
    assert main(["info", table, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [channel["unit"] for channel in found["channels"]] == ["s", "rad", "Nm", "m/s"]
    assert main(["plan", "--number", "3", "--pathway", "leg", "--json"]) == 0
    assert [row["quantity"] for row in json.loads(capsys.readouterr().out)["plan"]] == ["I", "B", "K"]


@pytest.mark.parametrize("command", ["check", "run"])
def test_without_the_packages_of_studies_it_says_what_to_install(command, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config.yaml").touch()
    monkeypatch.setattr("tepsipe.new_study.start.find_spec", lambda name: None)
    assert "pip install 'tepsipe[study]'" in refused(capsys, command)


@pytest.mark.parametrize("status", [1, 2])
def test_check_prints_each_sentence_on_a_line(status, capsys, tmp_path, monkeypatch):
    monkeypatch.setattr("tepsipe.new_study.start.find_spec", lambda name: name)
    (tmp_path / "workflow").mkdir()
    said = f"print('tepsipe: a: no\\ntepsipe: b: no', file=sys.stderr); sys.exit({status})"
    (tmp_path / "workflow/check.py").write_text(f"import sys; {said}")
    monkeypatch.chdir(tmp_path)
    assert main(["check"]) == status
    assert capsys.readouterr().err == "tepsipe: a: no\ntepsipe: b: no\n"


def test_check_that_ends_with_an_error_of_python_is_no_fault_of_the_recordings(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr("tepsipe.new_study.start.find_spec", lambda name: name)
    (tmp_path / "workflow").mkdir()
    (tmp_path / "workflow/check.py").write_text("raise ValueError('broken')")
    monkeypatch.chdir(tmp_path)
    assert main(["check"]) == 2
    assert "ValueError: broken" in capsys.readouterr().err


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_what_takes_longer_than_two_seconds_is_seen_on_a_terminal(monkeypatch):
    shown = Terminal()
    monkeypatch.setattr("sys.stderr", shown)
    with progress("waiting") as tell:
        assert shown.getvalue() == ""
        tell(", file 1 of 2")
        deadline = time.monotonic() + 10.0
        while not shown.getvalue() and time.monotonic() < deadline:
            time.sleep(0.05)
    assert shown.getvalue().startswith("\rwaiting, file 1 of 2: 2 s")
    assert shown.getvalue().endswith("\r\x1b[K")  # the line is gone again
    monkeypatch.setattr("sys.stderr", io.StringIO())
    before = threading.active_count()
    with progress("waiting"):
        assert threading.active_count() == before


def test_commands_and_options_are_completed(monkeypatch, root):
    pytest.importorskip("argcomplete")
    environment = os.environ | {
        "_ARGCOMPLETE": "1",
        "COMP_LINE": "tepsipe fit --tor",
        "COMP_POINT": "17",
        "_ARGCOMPLETE_STDOUT_FILENAME": "completions",
        "_ARGCOMPLETE_IFS": "\n",
        "PYTHONPATH": os.pathsep.join([str(root), os.environ.get("PYTHONPATH", "")]),
    }
    subprocess.run([sys.executable, "-m", "tepsipe.cli"], env=environment, check=True)
    with open("completions") as file:
        assert {word.strip() for word in file.read().split("\n")} == {
            "--torque",
            "--torque-unit",
            "--torque-sign",
        }


CONTROLS = "\x1b[31m\u202e\x07\x9b"  # colour, direction, bell, and an escape of one byte


def test_characters_of_a_file_that_control_a_terminal_are_shown_as_their_escapes(capsys):
    name = f"force{CONTROLS}_N.csv"
    with open(name, "w", encoding="utf-8") as file:
        file.write(f"time_s,force{CONTROLS}_N\n0.00,1.0\n0.01,2.0\n0.02,1.0\n")
    for options in ([], ["--json"]):
        assert main(["info", name, *options]) == 0
        said = capsys.readouterr()
        assert all(c.isprintable() or c == "\n" for c in said.out + said.err)
        assert "u202e" in said.out
        if "--json" in options:
            assert json.loads(said.out)["channels"][1]["name"] == f"force{CONTROLS}_N"


def test_commands_print_what_files_contain_by_one_function(root):
    """Otherwise a name in a file could reach the terminal as it is."""
    tree = ast.parse((root / "tepsipe/cli.py").read_text(encoding="utf-8"))
    bare = {
        function.name
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef)
        for node in ast.walk(function)
        if isinstance(node, ast.Call)
        and getattr(node.func, "id", "") == "print"
        and not any(keyword.arg == "file" for keyword in node.keywords)
    }
    assert bare == {"show", "print_json"}
