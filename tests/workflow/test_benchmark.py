"""Benchmark with a hidden truth: sealed problems, baselines, scores, and answers that are refused."""

import contextlib
import hashlib
import json
import math
import shutil
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe import InputError, cli
from tepsipe.cli import main
from tepsipe.experiments.benchmark import baselines
from tepsipe.experiments.benchmark.baselines import METHODS, answer_all
from tepsipe.experiments.benchmark.problems import ANSWERS, QUANTITIES, WINDOW_ROWS, AnswerRow, read_problems
from tepsipe.identification.fits import fit_parallel_cascade
from tepsipe.identification.notes import of_choice
from tepsipe.new_study import start
from tepsipe.reporting.benchmark import (
    ALL,
    FAULTS,
    NOMINAL,
    SCORES,
    interval_score,
    notes_of,
    read_answers,
    read_truth,
    scores_of,
)
from tepsipe.signals.perturbations import find_perturbations
from workflow import benchmark

# the seed spoils no problem with the number 1
SEED = 13


def truth_as_answers(truth):
    """The truth as rows of answers, with all spoiled problems flagged: its score is perfect."""
    return [
        AnswerRow(name, quantity, x, x, x, hidden.fault != NOMINAL)
        for name, hidden in truth.items()
        for quantity, x in hidden.values.items()
    ]


def made(folder, seed=SEED):
    """A benchmark of one problem of each kind: its folder and its truth."""
    places = folder / "problems", folder / "truth.json"
    constants = benchmark.read_constants(benchmark.ROOT / "config/virtual_lab.yaml")
    benchmark.make_benchmark(*places, seed, 1, constants)
    return places


@pytest.fixture(scope="module")
def problems(tmp_path_factory):
    return made(tmp_path_factory.mktemp("benchmark"))


@pytest.fixture(scope="module")
def answers(problems):
    return answer_all(read_problems(problems[0]), METHODS)


@pytest.fixture
def truth():
    """A truth of two problems, one of them spoiled, without recordings."""
    hidden = {
        "passive-01": {"kind": "passive", "fault": "", "truth": {"I": 0.01, "B": 0.1, "K": 10.0}},
        "passive-02": {"kind": "passive", "fault": "late torque", "truth": {"I": 0.02, "B": 0.2, "K": 8.0}},
        "standing-01": {"kind": "standing", "fault": "", "truth": {"B": 10.0, "K": 400.0}},
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "truth.json"
        path.write_text(json.dumps({"problems": hidden}))
        return read_truth(path)


def files_of(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


# ---- problems ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_one_seed_gives_the_same_bytes_and_another_seed_others(problems, tmp_path):
    again = made(tmp_path)
    assert files_of(again[0]) == files_of(problems[0])
    assert again[1].read_bytes() == problems[1].read_bytes()
    other = benchmark.Secret(SEED + 1)
    assert other.number("passive-01", "constants") != benchmark.Secret(SEED).number("passive-01", "constants")


@pytest.mark.slow
def test_a_folder_has_every_recording_and_the_hash_of_the_truth_but_nothing_of_its_content(problems):
    folder, truth = problems
    found = files_of(folder)
    content = json.loads(truth.read_text())
    named = {str(path) for path in found}
    assert {f"arrays/{problem}.csv" for problem in content["problems"]} <= named
    page = (benchmark.ROOT / "docs/benchmark.md").read_text(encoding="utf-8")
    assert [
        name for name in named if "/" not in name and name != "README.md" and f"`{name}`" not in page
    ] == []
    (standing,) = (problem for problem in content["problems"] if problem.startswith("standing-01-"))
    assert {f"instruments/{standing}/{name}" for name in ("log.mat", "markers.c3d", "emg.edf")} <= named
    digest = hashlib.sha256(truth.read_bytes()).hexdigest()
    assert found[Path("truth.sha256")].decode() == f"{digest}  truth.json\n"
    hidden = [content["salt"], *(repr(x) for p in content["problems"].values() for x in p["truth"].values())]
    assert len(hidden[0]) == 64 and content["seed"] == str(SEED)
    text = b"".join(data for path, data in found.items() if path.suffix in (".json", ".md", ".csv"))
    assert [secret for secret in hidden if secret.encode() in text] == []


@pytest.mark.slow
def test_windows_begin_with_the_pulses_and_an_ankle_has_none(problems):
    rows = WINDOW_ROWS.read(problems[0] / "windows.csv")
    for problem in read_problems(problems[0]):
        own = [(row.start_s, row.end_s) for row in rows if row.problem == problem.name]
        if problem.kind == "ankle":
            assert own == []
            continue
        time = problem.signals["time"]
        pulses = find_perturbations(time, problem.signals["belt"])
        bounds = [(pulse.start, pulse.stop - 1) for pulse in pulses]
        starts, ends = ([time[at] for at in ats] for ats in zip(*bounds, strict=True))
        ends = ends if problem.kind != "standing" else [start + 0.08 for start in starts]
        assert own == pytest.approx(np.column_stack([starts, ends]))


@pytest.mark.slow
def test_a_folder_whose_making_was_stopped_is_named(problems, tmp_path):
    folder = tmp_path / "stopped"
    shutil.copytree(problems[0], folder)
    (folder / "truth.sha256").unlink()
    with pytest.raises(InputError) as refused:
        benchmark.refuse_places(folder, tmp_path / "truth.json")
    assert_one_sentence(refused.value, "stopped", "found those of a command that was stopped: delete the")


def test_the_page_explains_every_key_of_the_facts():
    page = (benchmark.ROOT / "docs/benchmark.md").read_text(encoding="utf-8")
    keys, legend = set(), page[page.index("## Keys of facts.json") :]
    for known in benchmark.facts(
        benchmark.read_constants(benchmark.ROOT / "config/virtual_lab.yaml")
    ).values():
        for key, value in known.items():
            keys |= {key, *(value if isinstance(value, dict) and key != "layout_m" else ())}
    assert {key for key in keys if f"`{key}`" not in legend[: legend.index("## Spoiled")]} == set()
    for kind, noise in benchmark.TORQUE_NOISE_NM.items():
        assert f"`{kind}`" in page and f"| {noise} |" in page


def test_faults_are_drawn_problem_by_problem():
    secret = benchmark.Secret(1)
    faults = [benchmark.fault_of(secret, f"passive-{k}") for k in range(2000)]
    share = np.mean([bool(fault.name) for fault in faults])
    assert share == pytest.approx(benchmark.SPOILED, abs=0.04)
    counts = [sum(fault.name == name for fault in faults) for name in FAULTS]
    assert min(counts) > 0.8 * max(counts)
    for fault in faults:
        low, high = benchmark.DRAWN["faults"].get(fault.name, (0.0, 0.0))
        assert low <= fault.size <= high


def test_generators_of_different_purposes_and_seeds_share_nothing():
    purposes = [("a", "constants"), ("a", "instruments"), ("b", "constants"), ("a", "fault")]
    numbers = {benchmark.Secret(seed).number(*purpose) for seed in range(50) for purpose in purposes}
    assert len(numbers) == 200
    assert sum(number < 2**248 for number in numbers) < 10
    first, second = (benchmark.Secret(5).samples(*purpose).standard_normal(4000) for purpose in purposes[:2])
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.06


@pytest.mark.parametrize(
    ("name", "size"), [("late torque", 0.01), ("filtered torque", 8.0), ("soft plate", 15.0)]
)
def test_a_fault_of_the_torque_keeps_its_mean_and_delays_or_rings(name, size):
    step = np.r_[np.zeros(500), np.ones(1500)]
    found = benchmark.spoiled(step, 500.0, benchmark.Fault(name, size))
    assert found[:500] == pytest.approx(0.0, abs=1e-12)
    assert found[-1] == pytest.approx(1.0, abs=0.01)
    half = np.flatnonzero(found > 0.5)[0] - 500
    if name == "late torque":
        assert half == round(size * 500.0)
    else:
        assert half > 2
    assert (found.max() > 1.5) == (name == "soft plate")
    nothing = benchmark.spoiled(step, 500.0, benchmark.Fault("camera noise", 0.001))
    assert np.array_equal(nothing, step)


# ---- baselines -----------------------------------------------------------------------------------


@pytest.mark.slow
def test_baselines_answer_the_kinds_that_they_are_made_for(answers, problems, tmp_path):
    truth = read_truth(problems[1])
    assert [hidden.fault for hidden in truth.values()] == [NOMINAL] * 4
    named = {hidden.kind: name for name, hidden in truth.items()}
    legs = {"passive", "softening"}
    expected = {
        "thesis": {*legs, "standing"},
        "least-squares-by-hand": {*legs, "standing", "ankle"},
        "output-error": legs,
        "ensemble": {"ankle"},
        "parallel-cascade-1997": {"ankle"},
        "joint-likelihood": legs,
        "tepsipe": {*legs, "standing", "ankle"},
    }
    largest = {"output-error": 10.0, "joint-likelihood": 10.0, "tepsipe": 20.0, "parallel-cascade-1997": 25.0}
    for method, kinds in expected.items():
        rows = answers[method]
        assert {row.problem for row in rows} == {named[kind] for kind in kinds}, method
        for row in rows:
            error = 100.0 * (row.value / truth[row.problem].values[row.quantity] - 1.0)
            if row.quantity == "K" and method in largest:
                assert abs(error) < largest[method], (method, row)
            assert row.low is None or row.low <= row.value <= row.high
    # no method without intervals states any, and the answers can be written and read again
    assert all(row.low is None for row in answers["parallel-cascade-1997"])
    ANSWERS.write(tmp_path / "tepsipe.csv", answers["tepsipe"])
    assert len(read_answers(tmp_path / "tepsipe.csv", truth)) == 11


@pytest.mark.slow
def test_baselines_give_the_same_answers_again(answers, problems):
    ankle = [problem for problem in read_problems(problems[0]) if problem.kind == "ankle"]
    again = answer_all(ankle, METHODS)
    for method, rows in answers.items():
        assert again[method] == [row for row in rows if row.problem == ankle[0].name], method


@pytest.mark.slow
def test_an_assumed_reflex_flags_nothing_but_other_notes_do(problems, monkeypatch):
    (ankle,) = (problem for problem in read_problems(problems[0]) if problem.kind == "ankle")
    time, angle, torque = (ankle.signals[name] for name in ("time", "angle", "torque"))
    fit = fit_parallel_cascade(time, angle, torque, uncertainty=ankle.facts["uncertainty"])
    assumed = of_choice(fit.details.assumptions[0])
    for notes, flagged in (((), False), ((assumed,), False), ((assumed, "Below 0: I"), True)):
        noted = replace(fit, notes=notes)
        monkeypatch.setattr(baselines, "fit_parallel_cascade", lambda *_, own=noted, **__: own)
        found = METHODS["tepsipe"](ankle)
        assert [answer.flagged for answer in found.values()] == 3 * [flagged]


@pytest.mark.slow
def test_a_method_that_refuses_a_recording_withdraws_its_answers(problems):
    def refusing(problem):
        raise InputError(f"{problem.name}: expected a better recording")

    rows = answer_all(read_problems(problems[0]), {"refusing": refusing})["refusing"]
    assert len(rows) == 11
    assert all(row.flagged and row.value is None for row in rows)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "change", "words"),
    [
        ("problems.csv", (",passive", ",pasive"), "expected the kinds 'passive'"),
        (
            "facts.json",
            ('"standing":', '"standin":'),
            "expected JSON with the facts of every kind, found a damaged",
        ),
        ("facts.json", ("{", "["), "expected JSON with the facts of every kind, found a damaged"),
    ],
)
def test_a_folder_that_was_edited_is_refused(file, change, words, problems, tmp_path):
    for name in ("problems.csv", "facts.json"):
        (tmp_path / name).write_text((problems[0] / name).read_text())
    edited = tmp_path / file
    edited.write_text(edited.read_text().replace(*change, 1))
    with pytest.raises(InputError) as refused:
        list(read_problems(tmp_path))
    assert_one_sentence(refused.value, file, words)


# ---- scores --------------------------------------------------------------------------------------


def test_interval_score_is_the_width_and_40_times_the_miss():
    assert interval_score(1.0, 3.0, 2.0) == 2.0
    assert interval_score(1.0, 3.0, 3.5) == pytest.approx(2.0 + 40.0 * 0.5)
    assert interval_score(1.0, 3.0, 0.9) == pytest.approx(2.0 + 40.0 * 0.1)


def test_the_interval_that_an_honest_author_believes_has_the_best_expected_score():
    x = np.random.default_rng(1).standard_normal(20000)
    expected = {
        half: np.mean([interval_score(-half, half, value) for value in x]) for half in (1.5, 1.96, 2.5)
    }
    assert min(expected, key=expected.get) == 1.96


def scored(truth, rows, tmp_path):
    ANSWERS.write(tmp_path / "own.csv", rows)
    return {
        (row.kind, row.quantity): row
        for row in scores_of("own", read_answers(tmp_path / "own.csv", truth), truth)
    }


def test_the_truth_itself_has_a_perfect_score(truth, tmp_path):
    rows = scored(truth, truth_as_answers(truth), tmp_path)
    assert list(rows)[:5] == [
        (ALL, ALL),
        ("passive", ALL),
        ("passive", "I"),
        ("passive", "B"),
        ("passive", "K"),
    ]
    overall = rows[ALL, ALL]
    assert (overall.n, overall.answered, overall.spoiled) == (5, 5, 3)
    assert (overall.bias_percent, overall.rms_percent, overall.interval_score_percent) == (0.0, 0.0, 0.0)
    assert (overall.coverage, overall.flagged_percent, overall.false_alarm_percent) == (1.0, 100.0, 0.0)


def test_scores_by_hand(truth, tmp_path):
    rows = scored(
        truth,
        [
            AnswerRow("passive-01", "I", 0.011, 0.0095, 0.0125, False),  # 10 % too high, covered, 30 % wide
            AnswerRow("passive-01", "K", 8.0, 7.0, 9.0, True),  # 20 % too low, misses by 10 % of K
            AnswerRow("passive-02", "B", 0.3, 0.1, 0.5, False),  # spoiled, covered
            AnswerRow("passive-02", "K", 4.0, None, None, False),  # spoiled, no interval
            AnswerRow("standing-01", "K", None, None, None, True),  # withdrawn
        ],
        tmp_path,
    )
    passive = rows["passive", ALL]
    assert (passive.n, passive.answered, passive.spoiled) == (3, 2, 2)
    assert passive.bias_percent == pytest.approx(-5.0)
    assert passive.rms_percent == pytest.approx(math.sqrt((10.0**2 + 20.0**2) / 2.0))
    assert passive.median_percent == pytest.approx(15.0)
    assert passive.coverage == 0.5
    assert passive.interval_score_percent == pytest.approx((30.0 + 20.0 + 40.0 * 10.0) / 2.0)
    assert (passive.flagged_percent, passive.held_percent, passive.false_alarm_percent) == (0.0, 50.0, 50.0)
    standing = rows["standing", "K"]
    assert (standing.answered, standing.rms_percent, standing.coverage) == (0, None, None)
    assert standing.false_alarm_percent == 100.0
    assert rows["standing", "B"].false_alarm_percent is None


def test_answers_that_are_missing_or_contradict_themselves_are_noted(truth, tmp_path):
    rows = {(row.problem, row.quantity): row for row in truth_as_answers(truth)}
    path = tmp_path / "own.csv"

    def notes(left_out=(), **changed):
        own = [replace(row, **changed.get(key[1], {})) for key, row in rows.items() if key not in left_out]
        ANSWERS.write(path, own)
        return notes_of("own.csv", read_answers(path, truth), truth)

    assert notes() == ()
    assert notes([("standing-01", "K")]) == ()  # a method may answer some quantities only
    (forgotten,) = notes([("passive-02", "I"), ("passive-02", "K"), ("standing-01", "K")])
    assert forgotten.startswith("own.csv: no answer in 1 of 3 problems: passive-02 (I, K). A row without")
    empty = dict.fromkeys(("value", "low", "high"))
    rows["passive-01", "K"] = replace(rows["passive-01", "K"], **empty)
    assert notes()[0].startswith("own.csv: no answer in 1 of 3 problems: passive-01 (K). ")
    rows["passive-01", "K"] = replace(rows["passive-01", "K"], flagged=True)
    assert notes() == ()
    (outside,) = notes(B={"value": 1.0, "low": 2.0, "high": 3.0})
    assert outside.startswith(
        "own.csv: value outside its own interval in 3 of 8 answers: B of passive-01, B of passive-02, B of "
        "standing-01. Check"
    )


HEAD = "problem,quantity,value,low,high,flagged\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "expected the columns problem,quantity,value,low,high,flagged, found an empty file"),
        ("problem,K\npassive-01,3\n", "expected the columns problem,quantity,value,low,high,flagged, found"),
        (HEAD, "expected at least one answer, found none"),
        (HEAD + "passive-01,K,,,,false\n", "expected at least one answer, found none"),
        (HEAD + '"' + "x" * 200_000 + '",K,1,,,false\n', "expected answers as CSV"),
        (HEAD + "passive-01,K,1,,false\n", "line 2: expected 6 cells, found 5"),
        (HEAD + "pasive-01,K,1,,,false\n", "line 2: expected a problem of this benchmark, found 'pasive-01'"),
        (HEAD + "standing-01,I,1,,,false\n", "line 2: expected 'B', 'K' for standing-01, found 'I'"),
        (HEAD + 2 * "standing-01,K,1,,,false\n", "line 3: expected one answer to K of standing-01"),
        *(
            (
                HEAD + f"standing-01,K,{cell},,,false\n",
                f"line 2: expected a number of at most 1e+12 or nothing for value, found '{cell}'",
            )
            for cell in ("nan", "1e13", "-1e308", "1_000")
        ),
        (
            HEAD + "standing-01,K,1,0,,false\n",
            "both ends of its interval or with none, found 'value', 'low': complete",
        ),
        (
            HEAD + "standing-01,K,,0,1,false\n",
            "both ends of its interval or with none, found 'low', 'high': complete",
        ),
        (HEAD + "standing-01,K,1,2,0,false\n", "line 2: expected low up to high, found 2 and 0"),
        (HEAD + "standing-01,K,1,0,2,no\n", "line 2: expected true or false for flagged, found 'no'"),
    ],
)
def test_bad_answers_are_refused_in_one_sentence(text, words, truth, tmp_path):
    path = tmp_path / "own.csv"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        read_answers(path, truth)
    assert_one_sentence(refused.value, "own.csv", words)


def test_answers_of_a_spreadsheet_are_read(truth, tmp_path):
    path = tmp_path / "own.csv"
    path.write_bytes(
        ("\ufeff" + HEAD + "standing-01, K ,400,390,410,True\n\n").replace("\n", "\r\n").encode()
    )
    (outcome,) = read_answers(path, truth)
    assert (outcome.estimate.value, outcome.interval, outcome.truth) == (400.0, (390.0, 410.0), 400.0)
    assert outcome.flagged


def test_answers_to_another_round_are_refused(truth, tmp_path):
    path = tmp_path / "own.csv"
    truth = {f"{name}-0a1f": hidden for name, hidden in truth.items()}
    for problem, words in (
        (
            "standing-01-12ab",
            "expected a problem of the round 0a1f, found 'standing-01-12ab' of another: name the",
        ),
        ("standing-02-0a1f", "expected a problem of this benchmark, found 'standing-02-0a1f': did you mean"),
    ):
        path.write_text(HEAD + f"{problem},K,1,,,false\n")
        with pytest.raises(InputError) as refused:
            read_answers(path, truth)
        assert_one_sentence(refused.value, "own.csv, line 2", words)


@pytest.mark.parametrize("text", ["[]", "{}", '{"problems": {"a": {"kind": "passive"}}}', "no JSON"])
def test_a_truth_that_is_none_is_refused(text, tmp_path):
    path = tmp_path / "truth.json"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        read_truth(path)
    assert_one_sentence(
        refused.value, "truth.json", "found another file: name the organiser's file last, after"
    )


@pytest.mark.parametrize("x", ["NaN", "Infinity", "0", "-10", "1e308"])
def test_a_truth_by_which_no_error_can_be_divided_is_refused(x, tmp_path):
    path = tmp_path / "truth.json"
    hidden = '{"kind": "standing", "fault": "", "truth": {"B": 10, "K": %s}}'
    path.write_text('{"problems": {"standing-01": %s}}' % (hidden % x))
    with pytest.raises(InputError) as refused:
        read_truth(path)
    assert_one_sentence(refused.value, "truth.json", "expected a true K of 'standing-01' above 0 and at most")


# ---- commands ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_commands_answer_and_score(problems, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    rows = truth_as_answers(read_truth(problems[1]))
    ANSWERS.write("perfect.csv", rows)
    ANSWERS.write(
        "other.csv", [AnswerRow(r.problem, r.quantity, 1.1 * r.value, None, None, True) for r in rows]
    )
    assert main(["benchmark", "score", "perfect.csv", "other.csv", str(problems[1])]) == 0
    out = capsys.readouterr().out
    assert "| all | perfect | 11 of 11 | 0.0 | 0.0 | 0.0 | 100 (40 to 100) | 0.0 |" in out
    assert "| all | other | 11 of 11 | 10.0 | 10.0 | 10.0 | – | – | – | – | 100 |" in out
    kinds = [line.split()[1] for line in out.splitlines() if line.startswith("| ")]
    assert kinds == ["Kind", *(k for kind in ("all", *QUANTITIES) for k in (kind, kind))]
    assert hashlib.sha256(problems[1].read_bytes()).hexdigest() in out
    assert {row.method for row in SCORES.read("scores.csv")} == {"perfect", "other"}
    assert Path("scores.png").read_bytes()[:4] == b"\x89PNG"
    assert main(["benchmark", "score", "--json", "perfect.csv", str(problems[1])]) == 0
    assert json.loads(capsys.readouterr().out)["scores"][0]["coverage"] == 1.0


@pytest.mark.slow
def test_the_command_writes_a_table_per_baseline(problems, tmp_path, monkeypatch, capsys):
    # methods that take no time
    for name in [*METHODS]:
        monkeypatch.delitem(METHODS, name) if name != "ensemble" else None
    assert main(["benchmark", "baselines", str(problems[0]), "--output", str(tmp_path / "answers")]) == 0
    assert "ensemble.csv" in capsys.readouterr().out
    (ankle,) = {row.problem for row in ANSWERS.read(tmp_path / "answers/ensemble.csv")}
    assert ankle.startswith("ankle-01-")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["full"], "full: expected a new or empty folder for the problems, found content"),
        (["new", "--truth", "new/truth.json"], "--truth: expected a file outside the folder"),
        (["new", "--truth", "full/truth.json"], "--truth: expected a new file in a folder that exists"),
        (["new", "--truth", "none/truth.json"], "--truth: expected a new file in a folder that exists"),
        (["new", "--per-kind", "0"], "expected 1 to 99 problems of each kind"),
        (["new", "--seed", "-1"], "expected 1 to 99 problems of each kind and a seed of 0 or more"),
    ],
)
def test_problems_are_made_in_no_other_place_or_number(options, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full/truth.json").write_text("")
    assert benchmark.main(options) == 2
    captured = capsys.readouterr()
    assert words in captured.err and captured.err.count("\n") == 1
    assert captured.out == ""
    assert not (tmp_path / "new").exists()


def test_make_without_a_seed_takes_a_secret_one(tmp_path, monkeypatch, capsys):
    seeds = []
    monkeypatch.setattr(benchmark, "make_benchmark", lambda *given: seeds.append(given[2]) or "digest")
    for k in range(2):
        assert benchmark.main([str(tmp_path / f"new-{k}")]) == 0
    assert seeds[0] != seeds[1] and min(seeds) > 2**96
    assert "can be found by trying" not in capsys.readouterr().out
    assert benchmark.main([str(tmp_path / "practice"), "--seed", "7"]) == 0
    assert seeds[2] == 7
    assert "can be found by trying" in capsys.readouterr().out


@pytest.mark.slow
def test_the_command_hands_over_to_the_rules(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["benchmark", "make", "own", "--seed", "1", "--per-kind", "0"]) == 2
    captured = capsys.readouterr()
    assert "expected 1 to 99 problems of each kind" in captured.err
    assert captured.out == ""


def test_how_far_the_rules_are_is_shown_and_is_no_message(monkeypatch, capsys):
    said = "at work: leg, 1 of 2\ntepsipe: refused"
    code = f"import sys; print('made'); print({said!r}, file=sys.stderr)"
    told = []
    monkeypatch.setattr(cli, "progress", lambda what: contextlib.nullcontext(told.append))
    for code_, ends in ((code, 0), (f"{code}; sys.exit(2)", 2)):
        monkeypatch.setattr(start, "start_of", lambda *_, own=code_: ([sys.executable, "-c", own], None))
        assert main(["benchmark", "make", "own"]) == ends
        captured = capsys.readouterr()
        assert captured.out == "made\n"
        assert captured.err == ("tepsipe: refused\n" if ends else "")
    assert told == 2 * [", leg, 1 of 2"]
