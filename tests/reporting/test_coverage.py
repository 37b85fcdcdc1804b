"""Coverage of intervals: rows of the study, dropped sources, drawn laboratories."""

import contextlib
import json
import os
from dataclasses import replace

import pandas as pd
import pytest
import scipy
import yaml
from typst_builders import evaluated, page_of, plain_words, typeset_words

from tepsipe.errors import InputError
from tepsipe.io.estimates import RECOVERIES, Contribution, Estimate
from tepsipe.reporting.chapters import coverage as chapter
from tepsipe.reporting.coverage import (
    COVERAGE_ROWS,
    DROPPED_ROWS,
    FLAG_ROWS,
    LABORATORIES,
    OUTCOME_ROWS,
    Laboratory,
    Outcome,
    coverage_rows,
    dropped_rows,
    flag_rows,
    interval_without,
    outcome_row,
    outcomes_of,
)
from tepsipe.reporting.figures import plot_coverage, plot_intervals
from tepsipe.reporting.recovery import recovery_of
from tepsipe.reporting.run import Run, report_content
from tepsipe.virtual_lab.drawn_laboratories import draw_laboratory, drawn_numbers
from workflow.settings.complete import settings_of
from workflow.support import laboratories
from workflow.support.checked_study import check_standing_cutoffs, merged_settings
from workflow.support.laboratories import Laboratories, constants_of, one_of_each_set, seed_of, set_of
from workflow.support.stopped import write_record

SETS = {"nominal": {}, "shifted-means": {"shift": 1.0}, "heavy-tails": {"student_freedom": 3}}
COVERAGE = {"laboratories": 6, "seed": 1, "also_evaluated": [], "sets": SETS}


# ---- rows --------------------------------------------------------------------------------------


def estimate(value, half=2.0, flags="", recommended=True, condition="sine", quantity="K", pathway="leg"):
    return Estimate(
        *("dummy", condition, pathway, "fit", quantity, "Nm/rad", value, half / 2.0),
        ci_low=value - half,
        ci_high=value + half,
        u_type_a=0.0,
        u_type_b=half / 2.0,
        recommended=recommended,
        flags=flags,
    )


def laboratory(number, name="nominal"):
    return Laboratory(number, name, 1)


def outcomes():
    """Nominal: two covered, one of them flagged, one missed; others: one missed but flagged, one lost."""
    lost = replace(estimate(10.0, flags="no-interval"), ci_low=None, ci_high=None)
    return [
        Outcome(laboratory(1), estimate(101.0), 100.0),
        Outcome(laboratory(1), estimate(98.5, flags="at-bound"), 100.0),
        Outcome(laboratory(3), estimate(110.0), 100.0),
        Outcome(laboratory(2, "shifted-means"), estimate(90.0, flags="at-bound"), 100.0),
        Outcome(laboratory(4, "heavy-tails"), lost, 100.0),
    ]


def test_rows_count_covered_flagged_and_withdrawn_estimates():
    rows = {row.mechanism: row for row in coverage_rows(outcomes(), list(SETS), {"dummy": {"leg": 0.1}})}
    assert list(rows) == ["nominal", "shifted-means", "heavy-tails", "shifted"]
    nominal = rows["nominal"]
    assert (nominal.n, nominal.n_covered, nominal.laboratories, nominal.window_s) == (3, 2, 2, 0.1)
    assert nominal.coverage == pytest.approx(2 / 3)
    assert nominal.bias_percent == pytest.approx((1.0 - 1.5 + 10.0) / 3)
    assert nominal.median_width_percent == pytest.approx(4.0)
    assert nominal.flagged_percent == nominal.false_alarm_percent == pytest.approx(100 / 3)
    assert nominal.held_percent == pytest.approx(200 / 3)
    shifted = rows["shifted"]
    assert (shifted.n, shifted.n_covered, shifted.withdrawn, shifted.held_percent) == (1, 0, 1, 100.0)
    assert (shifted.flagged_percent, shifted.false_alarm_percent) == (100.0, 0.0)
    assert (rows["heavy-tails"].n, rows["heavy-tails"].coverage) == (0, None)


def test_the_nominal_set_is_the_first_also_where_its_first_laboratory_failed():
    rows = coverage_rows(outcomes()[3:4] + outcomes()[2:3], list(SETS), {})
    assert [(row.mechanism, row.n) for row in rows] == [("nominal", 1), ("shifted-means", 1), ("shifted", 1)]


def test_width_is_compared_with_the_errors_that_occur():
    # errors of 1 to 20 %: 95 % lie within 19.05 %, intervals of +-19.05 % have a ratio of 1
    own = [Outcome(laboratory(k), estimate(100.0 + k, half=19.05), 100.0) for k in range(1, 21)]
    (row,) = coverage_rows(own, list(SETS), {})
    assert row.width_ratio == pytest.approx(1.0)
    assert (row.n, row.n_covered, row.laboratories) == (20, 19, 20)


def test_recommended_estimates_come_first_and_others_that_are_named_count_as_such(tmp_path):
    rows = [estimate(1.0, recommended=False), estimate(2.0, pathway="foot"), estimate(3.0, quantity="VAF")]
    path = tmp_path / "recovery.csv"
    RECOVERIES.write(path, [recovery_of(rows[0], 1.5), recovery_of(rows[1], 2.5)])
    budget = Contribution("dummy", "sine", "leg", "fit", "K", "Nm/rad", "leg_mass_kg", "B", 0.5)
    also = [["dummy", "leg", "fit"]]
    found = outcomes_of(laboratory(1), rows, RECOVERIES.read(path), [budget], (), also)
    assert [(o.truth, o.estimate.recommended, dict(o.sources)) for o in found] == [
        (1.5, True, {"leg_mass_kg": 0.5}),
        (2.5, True, {}),
    ]
    plain = outcomes_of(laboratory(1), rows, RECOVERIES.read(path), [budget])
    assert [row.pathway for row in coverage_rows(plain, list(SETS), {})] == ["foot", "leg"]


def test_single_trials_of_a_person_do_not_count_beside_their_task():
    rows = [replace(estimate(1.0, condition=c), experiment="standing") for c in ("relax-1", "relax")]
    truths = [recovery_of(row, 1.0) for row in rows]
    found = outcomes_of(laboratory(1), rows, truths, [], ["relax"])
    assert [o.estimate.condition for o in found] == ["relax"]


# ---- without a source --------------------------------------------------------------------------


def test_interval_without_a_source_shrinks_with_its_variance():
    # u = 5 of 3 and 4, normal: without the 4, 3 remain
    e = replace(estimate(100.0, half=1.959964 * 5.0), standard_error=5.0, u_type_a=3.0, u_type_b=4.0)
    own = Outcome(laboratory(1), e, 100.0, {"leg_mass_kg": 4.0})
    assert interval_without(own, "leg_mass_kg") == pytest.approx((100 - 1.959964 * 3, 100 + 1.959964 * 3))
    assert interval_without(own, "another") == pytest.approx(own.interval)


def test_interval_without_a_source_has_the_degrees_of_freedom_that_remain():
    # Type A 3 with 13 degrees of freedom, Type B 4: nu_eff = 13 5^4 / 3^4; without Type B 13
    freedom = 13.0 * 5.0**4 / 3.0**4
    half = 5.0 * scipy.stats.t.ppf(0.975, freedom)
    e = replace(estimate(100.0, half=half), standard_error=5.0, u_type_a=3.0, u_type_b=4.0)
    own = Outcome(laboratory(1), e, 100.0, {"leg_mass_kg": 4.0})
    low, high = interval_without(own, "leg_mass_kg")
    assert 0.5 * (high - low) == pytest.approx(3.0 * 2.160369, rel=1e-5)


def test_dropped_rows_say_which_source_the_coverage_needs():
    sources = {"leg_mass_kg": 0.99, "leg_com_m": 0.1}
    own = [Outcome(laboratory(k), estimate(101.5), 100.0, sources) for k in (1, 3)]
    rows = {row.source: row for row in dropped_rows(own, list(SETS))}
    assert (rows["leg_mass_kg"].n_covered, rows["leg_mass_kg"].held_percent) == (0, 0.0)
    assert (rows["leg_com_m"].n_covered, rows["leg_com_m"].coverage) == (2, 1.0)
    assert rows["leg_mass_kg"].share_percent == pytest.approx(98.01)


def test_flags_are_counted_by_trial():
    rows = {(row.flag, row.mechanism): row for row in flag_rows(outcomes(), list(SETS))}
    # both estimates of laboratory 1 are of the same trial, and one has a flag
    nominal = rows["any", "nominal"]
    assert (nominal.trials, nominal.flagged, nominal.percent) == (2, 1, 50.0)
    assert (rows["at-bound", "shifted"].trials, rows["at-bound", "shifted"].flagged) == (2, 1)
    assert rows["any", "shifted"].percent == 100.0
    assert ("no-interval", "nominal") not in rows


# ---- report ------------------------------------------------------------------------------------


def tables(tmp_path, own, laboratories):
    written = {
        "coverage": (COVERAGE_ROWS, coverage_rows(own, list(SETS), {})),
        "dropped": (DROPPED_ROWS, dropped_rows(own, list(SETS))),
        "flags": (FLAG_ROWS, flag_rows(own, list(SETS))),
        "outcomes": (OUTCOME_ROWS, map(outcome_row, own)),
        "laboratories": (LABORATORIES, laboratories),
    }
    for name, (table, rows) in written.items():
        table.write(tmp_path / f"{name}.csv", rows)
    text = {"condition": str, "flags": str, "failed": str}
    return {name: pd.read_csv(tmp_path / f"{name}.csv", dtype=text) for name in written}


def run_of(tmp_path, own, laboratories):
    found = tables(tmp_path, own, laboratories)
    plot_coverage(found["coverage"], "nominal")
    plot_intervals(found["outcomes"], "nominal")
    study = {"title": "T", "recordings_source": None, "experiments": {"dummy": ["sine"]}, "made": {}}
    study |= {"sets": SETS, "drawn": {"weight.mass_kg": {"rectangular": 0.05}}, "seed": 1}
    return Run(found, study=study | {"code": {"commit": None, "modified": None}})


def content(run):
    """Content of report.json, and the tables as text."""
    texts = {name: own.replace({True: "true", False: "false"}) for name, own in run.tables.items()}
    return report_content(run, {"coverage": chapter}), {
        n: own.to_csv(index=False) for n, own in texts.items()
    }


SHOWN = ("sentences.map(plain)", "nominal.map(estimate)", "failed.map(row => row.failed)", "count")


def said(tmp_path, own, laboratories):
    """Sentences of the report, rows of nominal estimates, failures, and number of laboratories."""
    found = evaluated(SHOWN, "coverage.typ", *content(run_of(tmp_path, own, laboratories)))
    return [" ".join(sentence.split()) for sentence in found[0]], *found[1:]


def many(covered, count, flags="", name="nominal"):
    """Estimates of as many laboratories, so many of them covered, with errors of up to 2 %."""
    values = [100.0 + 1.9 * (k / count) if k < covered else 110.0 for k in range(count)]
    return [Outcome(laboratory(k + 1, name), estimate(v, flags=flags), 100.0) for k, v in enumerate(values)]


def test_sentences_say_what_contrary_numbers_show(tmp_path):
    good, *_ = said(tmp_path, many(96, 100), [laboratory(1)])
    assert "coverage of 1 of 1 recommended estimates is compatible with 95 %" in good[0]
    assert not any("below 95 %" in sentence for sentence in good)
    assert any("at most 0.0 % of each recommended estimate" in sentence for sentence in good)
    bad, *_ = said(tmp_path, many(70, 100, "at-bound"), [laboratory(1)])
    assert "coverage of 0 of 1" in bad[0]
    assert "below 95 %: dummy, leg, fit: K 70.0 % (" in bad[1]
    assert any("Flagged more often than 5 %" in sentence for sentence in bad)
    assert "compatible with 5 % in every experiment" in good[-1]
    assert bad[-1] == "More than 5 % of the trials of nominal laboratories are flagged: dummy (100 %)."
    wide = [Outcome(laboratory(k), estimate(100.0 + 0.01 * k, half=9.0), 100.0) for k in range(1, 101)]
    sentences, *_ = said(tmp_path, wide, [laboratory(1)])
    assert any("wider than needed" in s for s in sentences) and any(
        "Intervals wider than 1.3" in s for s in sentences
    )


def test_what_belongs_to_one_way_is_told_together_in_words(tmp_path):
    data, texts = content(run_of(tmp_path, [], [laboratory(1)]))
    several = [("K", "free-reflex-gls-50"), ("B", "free-reflex-gls-50"), ("I", "free-reflex-gls")]
    names = {name: chapter.estimator(name) for _, name in several}
    data["chapters"]["coverage"]["numbers"]["words"] = names | {"ankle-compensated": "ankle, compensated"}
    same = {"experiment": "standing", "pathway": "ankle-compensated"}
    rows = json.dumps([same | {"quantity": quantity, "estimator": name} for quantity, name in several])
    asked = f'listing(json(bytes({json.dumps(rows)})), row => "1 %")'
    assert evaluated([asked], "coverage.typ", data, texts) == [
        "standing person, ankle, compensated, free reflex torque (GLS), 50 ms: K 1 %, B 1 %; "
        "standing person, ankle, compensated, free reflex torque (GLS): I 1 %."
    ]


def test_report_tells_few_laboratories_and_failed_ones(tmp_path):
    failed = Laboratory(2, "shifted-means", 1, "markers.c3d: expected 8 markers, found 7: export it again")
    sentences, _, failures, count = said(tmp_path, many(2, 2), [laboratory(1), failed])
    assert count == 2 and failures == [failed.failed]
    text = " ".join(sentences)
    assert "more laboratories are needed" in text and "1 of the laboratories failed" in text
    words = plain_words(page_of(*content(run_of(tmp_path, many(2, 2), [failed])), '#include "coverage.typ"'))
    assert "0 of 1 laboratories" in words and "2shifted-meansmarkers.c3d: expected 8 markers" in words
    nothing, nominal, *_ = said(tmp_path, [], [failed])
    assert nothing[0].startswith("No recommended estimate") and nominal == []


def test_sentences_on_sources_and_shifted_laboratories(tmp_path):
    run = run_of(tmp_path, many(96, 100) + many(50, 60, "", "shifted-means"), [laboratory(1)])
    below = run_of(tmp_path, many(85, 100), [laboratory(1)])
    source = {"mechanism": "nominal", "source": "leg_mass_kg", "share_percent": 50.0, "held_percent": 80.0}
    row = run.tables["coverage"].iloc[0].to_dict() | source
    dropped = pd.DataFrame([{name: row[name] for name in run.tables["dropped"]}])
    needed = replace(run, tables=run.tables | {"dropped": dropped})
    enough = replace(run, tables=run.tables | {"dropped": dropped.assign(held_percent=99.0)})
    assert chapter.needing_a_source(needed) and not chapter.no_source_needed(needed)
    assert chapter.no_source_needed(enough) and not chapter.needing_a_source(enough)
    # 85 % are covered with all sources: a source without effect is not needed, one that costs 5 % is
    for held, listed in ((85.0, False), (81.0, False), (80.0, True)):
        tables = below.tables | {"dropped": dropped.assign(held_percent=held)}
        assert bool(chapter.needing_a_source(replace(below, tables=tables))) == listed
    assert chapter.seldom_held(run) and not chapter.held_when_shifted(run)
    without = "K 80.0 % instead of 96.0 % without the mass of the leg"
    for own, told in ((needed, without), (enough, "at least 99 % of each")):
        (sentences,) = evaluated(SHOWN[:1], "coverage.typ", *content(own))
        text = " ".join(" ".join(sentences).split())
        assert (
            told in text and "Fewer than 90 % are covered or flagged in shifted laboratories: dummy" in text
        )


def test_report_is_typeset(tmp_path):
    run = run_of(tmp_path, many(96, 100) + many(50, 60, "", "shifted-means"), [laboratory(1)])
    words = typeset_words('#include "coverage.typ"', *content(run), cells=" ")
    assert "dummy leg, fit K 60 83 71 to 92" in words
    assert "K of the dummy by leg, fit 83 / 83 –" in words and "rectangular, half width 0.05" in words


# ---- laboratories ------------------------------------------------------------------------------


def test_sets_take_turns_and_do_not_depend_on_the_number_of_laboratories():
    names = [set_of(COVERAGE, k) for k in range(1, 9)]
    assert names == ["nominal", "shifted-means", "nominal", "heavy-tails"] * 2
    assert [set_of(COVERAGE, k) for k in one_of_each_set(COVERAGE)] == list(SETS)
    assert set_of(COVERAGE | {"sets": {"nominal": {}}}, 2) == "nominal"
    seeds = [seed_of(COVERAGE, k) for k in range(1, 200)]
    assert len(set(seeds)) == len(seeds)
    assert seed_of(COVERAGE | {"laboratories": 200}, 5) == seeds[4]


def test_a_set_changes_distributions_and_constants():
    constants = {
        "seed": 1,
        "weight": {"mass_kg": 20.0, "sides_m": [1.0, 2.0]},
        "drawn": {
            "weight.mass_kg": {"rectangular": 0.3},
            "weight.sides_m": {"normal": 0.1, "relative": True},
        },
    }
    kept = json.dumps(constants)
    shifted, heavy = (constants_of(constants, COVERAGE, k)["drawn"] for k in (2, 4))
    assert shifted["weight.mass_kg"] == {"rectangular": 0.3, "shift": 1.0}
    assert heavy["weight.mass_kg"]["student"] == pytest.approx([0.3 / 3**0.5, 3])
    assert heavy["weight.sides_m"] == {"student": [0.1, 3], "relative": True}
    stronger = {"a": {}, "b": {"factors": {"weight.sides_m": 2.0}, "constants": {"weight.mass_kg": 5.0}}}
    found = constants_of(constants, COVERAGE | {"sets": stronger}, 2)
    assert found["weight"] == {"mass_kg": 5.0, "sides_m": [2.0, 4.0]}
    assert found["seed"] == seed_of(COVERAGE, 2)
    own = {"weight.mass_kg": {"one_of": [1.0, 2.0]}}
    one_set = COVERAGE | {
        "sets": {"a": {}, "b": {"drawn": own}},
        "drawn": {"weight.mass_kg": {"normal": 9.0}},
    }
    assert constants_of(constants, one_set, 2)["drawn"] == constants["drawn"] | own
    assert constants_of(constants, one_set, 1)["drawn"]["weight.mass_kg"] == {"normal": 9.0}
    assert json.dumps(constants) == kept
    with pytest.raises(InputError, match=r"coverage\.sets\.b to name constants .*found 'weight\.mass'"):
        constants_of(constants, COVERAGE | {"sets": {"a": {}, "b": {"factors": {"weight.mass": 2.0}}}}, 2)


def test_every_set_draws_the_further_constants_unchanged_and_the_rate_is_known():
    config = merged_settings(["config/config.yaml", "config/coverage/config.yaml"])
    laboratories, rate = Laboratories(config), "treadmill.capture.rate_hz"
    further = config["coverage"]["drawn"]
    noises, rates = [], set()
    for number in range(1, 9):
        files = laboratories.files(number, draw_laboratory)
        constants = json.loads(files["config/virtual_lab.yaml"])
        assert {path: constants["drawn"][path] for path in further} == further
        # no other number depends on them
        without = {path: entry for path, entry in constants["drawn"].items() if path not in further}
        numbers = {number.path: number.value for number in drawn_numbers(constants)}
        others = {n.path: n.value for n in drawn_numbers(constants | {"drawn": without})}
        assert others == {path: value for path, value in numbers.items() if path not in further}
        own = json.loads(files["config/config.yaml"])
        assert own["plate_treadmill"]["resample_rate_hz"] == numbers[rate]
        # cameras of 100 Hz would be refused with the cutoff of the shipped study
        check_standing_cutoffs(settings_of(own), "own")
        rates.add(numbers[rate])
        assert 1e-5 <= numbers["treadmill.capture.noise_m"] <= 5e-4
        noises.append(numbers["treadmill.capture.noise_m"])
    assert len(set(noises)) == 8 and 100.0 in rates


def test_shift_moves_a_drawn_number_by_standard_deviations():

    def drawn(**entry):
        made = {"seed": 7, "x": [0.0] * 40, "drawn": {"x": {"normal": 1.0, **entry}}}
        return draw_laboratory(made)["x"]

    moves = [b - a for a, b in zip(drawn(), drawn(shift=2.0), strict=True)]
    assert sorted({round(move, 9) for move in moves}) == [-2.0, 2.0]
    assert 8 < moves.count(max(moves)) < 32


def test_a_laboratory_is_a_study_of_its_own(root, monkeypatch):
    monkeypatch.chdir(root)
    config = yaml.safe_load((root / "config/config.yaml").read_text(encoding="utf-8"))
    made = Laboratories(config | {"coverage": COVERAGE})
    files = made.files(3, draw_laboratory)
    own = json.loads(files["config/config.yaml"])
    assert own["coverage"] is None and own["study"]["seed"] == made.about(3)["seed"]
    assert own["study"]["virtual_lab"] == "config/virtual_lab.yaml" in files
    assert own["study"]["trial_sheet"] == "config/trials.tsv" in files
    assert config["study"]["reported"] is not None and own["study"]["reported"] is None
    assert made.all("x") == [f"<results>/laboratories/{k}/x" for k in range(1, 7)]


@pytest.fixture
def checked(checked_study_of):
    """Check the shipped coverage study with other values of some keys."""
    return checked_study_of("coverage")


@pytest.mark.slow
def test_shipped_coverage_study_is_valid_and_evaluates_what_it_estimates(checked):
    study = checked()
    assert study.config["coverage"]["laboratories"] == 20
    estimators = study.settings["standing"]["estimators"]
    for experiment, pathway, estimator in study.config["coverage"]["also_evaluated"]:
        assert (experiment, pathway) == ("standing", study.settings["standing"]["recommended"]["pathway"])
        assert 0.04 <= estimators[estimator]["window_s"] <= 0.08
    assert set(study.experiments) == {"wristalyzer", "dummy", "weight", "empty", "standing"}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"study/virtual_lab": None}, "study.virtual_lab is null"),
        ({"coverage/sets": {"a": {}, "b": {"factors": {"weight.mas_kg": 2}}}}, "weight.mas_kg"),
        ({"coverage/sets": {"a": {"constants": {"weight.mass_kg": -1.0}}}}, "weight.mass_kg"),
        ({"coverage/sets": {"nominal": {}, "shifted": {}}}, "coverage.sets"),
        ({"coverage/laboratories": 0}, "coverage.laboratories"),
    ],
)
def test_coverage_study_that_cannot_run_is_refused_in_one_sentence(changes, words, checked):
    with pytest.raises(InputError) as refusal:
        checked(changes)
    assert words in str(refusal.value) and "\n" not in str(refusal.value)


def stopped(monkeypatch, tmp_path, words, **found):
    """Run a laboratory whose Snakemake ends with 1, and leaves these words behind."""

    def ends(folder, log):
        log.write_text(words, encoding="utf-8")
        if found:
            with contextlib.chdir(folder):
                write_record(**found)
        return 1

    monkeypatch.setattr(laboratories, "_snakemake", ends)
    return laboratories.run({"config/config.yaml": "a: 1\n"}, tmp_path)


def test_what_stops_a_laboratory_for_good_is_told_apart_from_what_may_pass(monkeypatch, tmp_path):
    sentence = "tepsipe: fit_dummy/sine: expected 8 markers, found 7: export it again"
    about = {"about": "fit_dummy/sine", "log": "x.log", "said": sentence}
    said = stopped(monkeypatch, tmp_path / "a", "", **about, lasting=True)
    assert said == sentence.removeprefix("tepsipe: ")
    with pytest.raises(OSError, match="expected 8 markers"):
        stopped(monkeypatch, tmp_path / "b", "", **about, lasting=False)
    refused = "Building DAG\ntepsipe: config.yaml: expected a mass, found -1: correct it\n"
    assert stopped(monkeypatch, tmp_path / "c", refused) == refused.splitlines()[1].removeprefix("tepsipe: ")
    with pytest.raises(OSError, match="found status 1: look there"):
        stopped(monkeypatch, tmp_path / "d", "Segmentation fault")


def test_configuration_of_a_laboratory_keeps_its_date_unless_it_changes(monkeypatch, tmp_path):
    monkeypatch.setattr(laboratories, "_snakemake", lambda folder, log: 0)
    path = tmp_path / "config/config.yaml"
    assert laboratories.run({"config/config.yaml": "a: 1\n"}, tmp_path) == ""
    os.utime(path, (1, 1))
    laboratories.run({"config/config.yaml": "a: 1\n"}, tmp_path)
    assert path.stat().st_mtime == 1
    laboratories.run({"config/config.yaml": "a: 2\n"}, tmp_path)
    assert path.stat().st_mtime > 1
    (tmp_path / "results").mkdir()
    laboratories.forget(tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["config"]


def test_laboratories_do_without_what_is_left_out_and_unknown_names_are_refused():
    config = merged_settings(["config/config.yaml", "config/coverage/config.yaml"])
    own = Laboratories(config).own_config
    assert "long" in config["standing"]["estimators"]
    assert set(own["standing"]["estimators"]) == set(config["standing"]["estimators"]) - {
        path.rpartition(".")[2] for path in config["coverage"]["left_out"] if path.startswith("standing.e")
    }
    config["coverage"]["left_out"] = ["standing.estimators.longer"]
    with pytest.raises(InputError, match=r"expected coverage\.left_out .* 'standing\.estimators\.longer'"):
        _ = Laboratories(config).own_config
