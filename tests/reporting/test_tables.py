"""Tables: estimates survive their file, cells stand beside what was reported, verdicts are earned."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.io.estimates import RECOVERIES, Estimate
from tepsipe.io.result import Result
from tepsipe.reporting.claims import CLAIM_VERDICTS, MEASURES, Findings, check_claims, findings_of_cells
from tepsipe.reporting.recovery import (
    AT_WORK,
    SMALL,
    compare_with_truth,
    in_order,
    recovery_of,
    true_parameters,
)
from tepsipe.reporting.thesis_tables import ROWS, lay_out_table, read_table, write_table
from tepsipe.statistics.least_squares import SEM_READINGS

UNITS = {"I": "Nms2/rad", "B": "Nms/rad", "K": "Nm/rad"}


def estimate(quantity, value, condition="sine-0.3", pathway="leg-thesis", **more):
    names = {"experiment": "dummy", "estimator": "windowed-least-squares-thesis"} | more
    return Estimate(
        condition=condition,
        pathway=pathway,
        quantity=quantity,
        unit=UNITS.get(quantity, "%"),
        value=value,
        **names,
    )


# ---- estimates ---------------------------------------------------------------------------------


# ---- the thesis's tables -----------------------------------------------------------------------

CONDITIONS = ["sine-0.1", "sine-0.5"]
QUANTITIES = ["I", "B", "K", "VAF_perturbation", "VAF_trial"]


def dummy_estimates(pathway, factor=1.0):
    return [
        estimate(
            quantity,
            factor * (10.0 * k + c),
            condition,
            pathway,
            standard_error=0.01 * (5 + c),
            sem_as_printed=0.5,
        )
        for c, condition in enumerate(CONDITIONS)
        for k, quantity in enumerate(QUANTITIES)
    ]


REPORTED = {"K": {"sine-0.1": 6.722}, "SEM_K": {"sine-0.5": 0.342}}


def test_table_has_the_rows_of_the_thesis_pathway_by_pathway():
    estimates = dummy_estimates("leg", 2.0) + dummy_estimates("leg-thesis")
    blocks = [("leg-thesis", None), ("leg", None)]
    sem = np.array([[1e-4, 4e-3, 0.2], [3e-4, 6e-3, 0.4]])[:, None] * np.array([50.0, 1.0, 1.1])[:, None]
    fits = {name: Result({"leg-thesis/sem": sem}, {}, {}) for name in CONDITIONS}
    rows = lay_out_table("table_4_2", estimates[::-1], REPORTED, CONDITIONS, blocks, fits)
    assert [row.quantity for row in rows] == 2 * ROWS["table_4_2"]
    each = len(ROWS["table_4_2"])
    assert [row.pathway for row in rows] == each * ["leg-thesis"] + each * ["leg"]
    stiffness = [row.values for row in rows if row.quantity == "K"]
    assert stiffness == [[20.0, 21.0], [40.0, 42.0]]
    # the SEM is the mean of those of the perturbations, by every reading of eq (3-2)
    sems = {(row.pathway, row.quantity): row.values for row in rows if row.quantity.startswith("SE")}
    assert sems["leg-thesis", "SEM_count_I"] == pytest.approx([2e-4, 2e-4])
    assert sems["leg-thesis", "SEM_count_K"] == pytest.approx([0.3, 0.3])
    assert sems["leg-thesis", "SEM_norm_K"] == pytest.approx([15.0, 15.0])
    assert sems["leg-thesis", "SEM_freedom_K"] == pytest.approx([0.33, 0.33])
    assert sems["leg", "SEM_count_K"] == [None, None]  # no fit
    assert sems["leg", "SE_K"] == [0.05, 0.06]
    units = {row.quantity: row.unit for row in rows}
    assert (units["K"], units["SEM_count_K"], units["VAF_trial"]) == ("Nm/rad", "Nm/rad", "%")
    assert units["SEM_norm_K"] == "as printed"


def test_cells_stand_beside_what_was_reported_for_their_condition():
    rows = lay_out_table(
        "table_4_2", dummy_estimates("leg-thesis"), REPORTED, CONDITIONS, [("leg-thesis", None)]
    )
    reported = {row.quantity: row.reported for row in rows}
    assert reported["K"] == [6.722, None]
    for reading in SEM_READINGS:
        assert reported[f"SEM_{reading}_K"] == [None, 0.342]
    assert reported["I"] == [None, None]


def test_order_of_the_columns_is_that_of_the_conditions_asked_for():
    rows = lay_out_table("table_4_2", dummy_estimates("leg"), REPORTED, CONDITIONS[::-1], [("leg", None)])
    stiffness = next(row for row in rows if row.quantity == "K")
    assert stiffness.values == [21.0, 20.0]
    assert stiffness.reported == [None, 6.722]


def test_pathway_that_is_both_printed_and_recommended_is_laid_out_once():
    blocks = [("leg", None), ("leg", None)]
    rows = lay_out_table("table_4_2", dummy_estimates("leg"), {}, CONDITIONS, blocks)
    assert len(rows) == len(ROWS["table_4_2"])


def test_estimators_of_one_pathway_are_told_apart():
    names = {"experiment": "wristalyzer", "condition": "0.16", "pathway": "admittance"}
    estimates = [
        estimate("K", 10.0, estimator="spectral-fit", **names),
        estimate("K", 11.0, estimator="spectral-fit-periods", **names),
    ]
    blocks = [("admittance", "spectral-fit-periods"), ("admittance", "spectral-fit")]
    rows = lay_out_table("table_4_1", estimates, {}, ["0.16"], blocks)
    cells = [(row.estimator, row.values) for row in rows if row.quantity == "K"]
    assert cells == [("spectral-fit-periods", [11.0]), ("spectral-fit", [10.0])]
    sems = {f"spectral-fit{kind}/sem": np.full((1, 3, 3), x) for kind, x in (("", 0.2), ("-periods", 0.3))}
    rows = lay_out_table("table_4_1", estimates, {}, ["0.16"], blocks, {"0.16": Result(sems, {}, {})})
    assert [row.values for row in rows if row.quantity == "SEM_count_K"] == [[0.3], [0.2]]


def test_estimate_that_is_missing_is_named():
    with pytest.raises(InputError) as caught:
        lay_out_table("table_4_2", dummy_estimates("leg"), {}, [*CONDITIONS, "sine-0.3"], [("leg", None)])
    assert_one_sentence(caught.value, "sine-0.3", "leg", " I ")


def test_table_comes_back_from_its_file(tmp_path):
    rows = lay_out_table(
        "table_4_2", dummy_estimates("leg-thesis"), REPORTED, CONDITIONS, [("leg-thesis", None)]
    )
    write_table(tmp_path / "table.csv", rows, CONDITIONS)
    conditions, read = read_table(tmp_path / "table.csv")
    assert conditions == CONDITIONS
    assert read == rows
    with open(tmp_path / "table.csv", newline="") as file:
        header = next(csv.reader(file))
    assert header[4:] == ["sine-0.1", "sine-0.1_reported", "sine-0.5", "sine-0.5_reported"]
    with open(tmp_path / "table.csv", "a") as file:
        file.write("leg,,I\n")
    with pytest.raises(InputError, match=r"table\.csv: expected a table of the thesis, found a damaged row"):
        read_table(tmp_path / "table.csv")


# ---- the thesis's statements -------------------------------------------------------------------


def findings(stiffness=(6.5, 6.4, 6.6), start_spread=1e-5, wristalyzer=(9.9, 10.0001)):
    """What a small run found: three conditions of the dummy, two of the Wristalyzer."""
    conditions = ["sine-0.1", "sine-0.2", "sine-0.5"]
    rows = []
    for condition, k in zip(conditions, stiffness, strict=True):
        rows += [estimate("K", k, condition), estimate("I", 0.054, condition)]
        rows += [estimate("B", 0.09, condition), estimate("K", 10.0, condition, "leg")]
        vaf = {"sine-0.1": 98.0, "sine-0.2": 99.0, "sine-0.5": 99.9}[condition]
        rows += [estimate("VAF_perturbation", vaf, condition), estimate("VAF_trial", vaf, condition)]
    for condition, k in zip(["0.08", "0.16"], wristalyzer, strict=True):
        names = {"experiment": "wristalyzer", "pathway": "admittance"}
        rows.append(estimate("K", k, condition, estimator="spectral-fit", **names))
        rows.append(estimate("K", 3.0, condition, estimator="spectral-fit-modulus", **names))
        vaf = {"0.08": 91.0, "0.16": 95.0}[condition]
        rows.append(estimate("VAF_trial", vaf, condition, estimator="spectral-fit", **names))
    spread = {"sine-0.1": 0.6, "sine-0.2": 0.3, "sine-0.5": 0.1}
    fits = {
        "dummy": {
            name: Result(
                {"leg-thesis/parameters": np.column_stack([[0.0, 0.0], [0.0, 0.0], [6.0 - s, 6.0 + s]])},
                {},
                {},
            )
            for name, s in spread.items()
        },
        "wristalyzer": {
            name: Result({}, {}, {"many_starts_stiffness_spread_Nm_per_rad": start_spread})
            for name in ("0.08", "0.16")
        },
    }
    return Findings(rows, fits, "leg-thesis")


BASES = {"joint": "a joint", "thesis": "numbers of the thesis"}


def row_of(measure, reported, tolerance, found, printed=None, nulls=None, **more):
    claim = {"claim": "c", "where": "w", "measure": measure, "unit": "1", "section": "s"}
    claim |= {"reported": reported, "tolerance": tolerance, "verdict": "fitted", "used": "joint"} | more
    (row,) = check_claims([claim], found, BASES, printed, nulls)
    return row


def verdict(*claim, **more):
    row = row_of(*claim, **more)
    return row.verdict, row.reproduced


def test_value_within_its_tolerance_has_the_class_of_its_claim():
    for own in ("fitted", "predicted", "pattern", "interpretation"):
        assert verdict("printed_stiffness_low", 6.471, 0.65, findings(), verdict=own)[0] == own
    assert verdict("printed_inertia", 0.061, 0.0092, findings())[0] == "fitted"


def test_tolerance_counts_to_both_sides_and_to_its_border():
    found = findings(stiffness=(6.0, 7.0, 6.5))
    assert verdict("printed_stiffness_low", 6.0, 0.5, found) == ("fitted", 6.5)
    assert verdict("printed_stiffness_low", 7.0, 0.5, found) == ("fitted", 6.5)
    assert verdict("printed_stiffness_low", 7.0, 0.49, found) == ("not reproduced", 6.5)


def test_value_outside_its_tolerance_without_evidence_is_not_reproduced():
    found = findings(stiffness=(9.0, 9.0, 9.0))
    assert verdict("printed_stiffness_low", 6.471, 0.65, found) == ("not reproduced", 9.0)


def test_value_outside_its_tolerance_is_explained_only_by_a_number_within_it():
    def found(modulus):
        names = {"experiment": "wristalyzer", "pathway": "admittance", "estimator": "spectral-fit-modulus"}
        plain = findings()
        own = [e for e in plain.estimates if e.estimator != "spectral-fit-modulus"]
        own += [estimate("K", k, str(n), **names) for n, k in enumerate(modulus)]
        return replace(plain, estimates=own)

    measure = "wristalyzer_stiffness_at_start"
    assert verdict(measure, 3, 0, found([10.0, 10.0, 10.0, 9.0])) == ("explained", 1.0)
    assert verdict(measure, 3, 0, found([10.0, 10.0, 9.0])) == ("not reproduced", 1.0)
    assert verdict(measure, 1, 0, found([9.0])) == ("fitted", 1.0)
    # what is known of a number outside, with the number that explains it
    reasons = [row_of(measure, 3, 0, found(k), outside="known").reason for k in ([10.0] * 3, [9.0])]
    assert reasons == ["known: 3", "known"]
    assert row_of(measure, 1, 0, found([9.0]), outside="known").reason == ""


def test_claim_on_recordings_is_not_fitted():
    claim = ("printed_stiffness_low", 6.471, 0.65)
    recorded = replace(findings(), recorded=True)
    assert verdict(*claim, recorded)[0] == "predicted"
    assert verdict(*claim, recorded, verdict="pattern")[0] == "pattern"


def printed_findings(stiffness=(6.722, 5.341), sem=0.3):
    """Thesis's own numbers: two conditions of Table 4-2 and one of Table 4-1."""
    cells = {("table_4_2", "K", f"sine-0.{n}"): k for n, k in zip((1, 5), stiffness, strict=True)}
    cells |= {("table_4_2", "SEM_K", f"sine-0.{n}"): sem for n in (1, 5)}
    cells |= {("table_4_1", "K", "0.16"): 9.967, ("table_4_1", "SEM_K", "0.16"): 12.26}
    cells |= {("table_4_1", "I", "0.16"): 0.015, ("table_4_1", "SEM_I", "0.16"): 0.019}
    cells |= {("table_4_4", "K", "none"): 10.0, ("table_4_4", "K", "tau"): 2.963}
    return findings_of_cells(cells, "leg-thesis")


def test_measures_of_the_printed_numbers_are_the_margins_of_the_thesis():
    own = printed_findings()
    row = row_of("printed_stiffness_ratio", 0.76, 0.05, findings(), own)
    assert row.margin == pytest.approx(5.341 / 6.722)
    # where it prints no number, its margin is given or empty
    assert row_of("weight_growth", 5.0, "below", findings(), own).margin is None
    assert row_of("weight_growth", 5.0, "below", findings(), own, margin=2.0).margin == 2.0
    assert own.noisy("as-tabulated", "K", "tau") == 2.963
    assert own.noisy("recommended-regression", "K", "none") == 10.0


def test_implied_claim_is_measured_on_the_numbers_of_the_thesis():
    """The statement fails by the SEMs of the thesis, and another table turns it."""
    claim = ("wristalyzer_relative_sem", 1.0, "above", findings())
    ratio = (12.26 / 9.967) / (0.019 / 0.015)
    found = verdict(*claim, printed_findings(), verdict="implied", used="thesis")
    assert found == ("contradicted by itself", pytest.approx(ratio)) and ratio < 1.0
    low = {"verdict": "implied", "used": "thesis"}
    assert verdict("printed_sem", 0.1, "below", findings(), printed_findings(), **low)[0] == "implied"
    assert (
        verdict("printed_sem", 0.1, "below", findings(), printed_findings(sem=0.9), **low)[0]
        == "contradicted by itself"
    )


@pytest.mark.parametrize(
    ("nulls", "given", "value", "found"),
    [
        (printed_findings((6.5, 6.5)), {}, 1.0, "not reproduced"),  # a constant does not fall
        (printed_findings((6.5, 5.0)), {}, 5.0 / 6.5, "implied"),
        (printed_findings((6.5, 5.0)), {"null_value": 1.0}, 1.0, "not reproduced"),
        (None, {}, None, "not computed"),
    ],
)
def test_null_model_of_a_claim_is_judged_by_the_same_tolerance(nulls, given, value, found):
    row = row_of("printed_stiffness_ratio", 0.76, 0.05, findings((6.5, 6.0, 5.0)), None, nulls, **given)
    assert row.verdict == "fitted"
    assert (row.null_value, row.null_verdict) == (None if value is None else pytest.approx(value), found)
    assert row.used == "a joint" + (
        "; cannot discriminate: the null model is within" if found == "implied" else ""
    )


def test_threshold_of_our_own_is_named_in_the_basis():
    row = row_of("printed_stiffness_ratio", 0.9, "below", findings((6.5, 6.0, 5.0)), own_threshold=True)
    assert row.used == "a joint; our threshold, the thesis prints none"


def test_claim_names_the_statements_that_it_tests():
    claim = {"claim": "c", "where": "w", "measure": "printed_damping", "unit": "1", "section": "s"}
    claim |= {"reported": 0.0, "tolerance": 1, "verdict": "fitted", "used": "joint"}
    assertions = [
        {"measures": ["printed_damping"]},
        {"unchecked": "no"},
        {"measures": ["printed_damping", "x"]},
    ]
    (row,) = check_claims([claim], findings(), BASES, assertions=assertions)
    assert row.statements == "1;3"
    with pytest.raises(InputError, match="used: expected one of joint, thesis, found 'rubber'"):
        check_claims([claim | {"used": "rubber"}], findings(), BASES)


def test_tolerance_holds_at_its_border_in_spite_of_rounding():
    assert verdict("wristalyzer_best_factor", 0.12, 0.04, findings())[0] == "fitted"
    assert verdict("wristalyzer_best_factor", 0.12, 0.0399, findings())[0] == "not reproduced"


def test_claim_of_less_than_something_asks_for_less():
    ratio = 0.1 / 0.6
    found = verdict("printed_spread_ratio", 1.0, "below", findings())
    assert found == ("fitted", pytest.approx(ratio))
    assert verdict("printed_spread_ratio", 0.1, "below", findings())[0] == "not reproduced"


def test_claims_are_measured_on_the_printed_pathway_and_estimator():
    found = findings()
    assert found.by_condition("dummy", "K") == {"sine-0.1": 6.5, "sine-0.2": 6.4, "sine-0.5": 6.6}
    assert found.by_condition("dummy", "K", "leg")["sine-0.1"] == 10.0
    assert found.by_condition("wristalyzer", "K") == {"0.08": 9.9, "0.16": 10.0001}
    assert verdict("wristalyzer_best_factor", 0.16, 0.01, found) == ("fitted", 0.16)
    assert verdict("printed_stiffness_ratio", 1.0, 0.1, found)[1] == pytest.approx(6.6 / 6.5)


@pytest.mark.parametrize("measure", MEASURES)
def test_claim_whose_experiment_was_not_run_is_not_computed(measure, tmp_path):
    nothing = Findings([], {}, "leg-thesis")
    assert verdict(measure, 1.0, 0.1, nothing) == ("not computed", None)


def test_unknown_measure_is_refused():
    with pytest.raises(InputError) as caught:
        verdict("printed_mass", 1.0, 0.1, findings())
    assert_one_sentence(caught.value, "'printed_mass'", "printed_inertia")


def test_claims_are_written_with_their_columns(tmp_path):
    row = row_of("printed_stiffness_low", 6.471, 0.65, findings(), printed_findings())
    CLAIM_VERDICTS.write(tmp_path / "claims.csv", [row])
    with open(tmp_path / "claims.csv", newline="", encoding="utf-8") as file:
        (read,) = csv.DictReader(file)
    columns = ["claim", "where", "unit", "reported", "reproduced", "tolerance", "verdict", "section"]
    assert list(read)[:10] == [*columns, "null_value", "null_verdict"]
    assert (read["reported"], read["tolerance"], read["reproduced"]) == ("6.471", "0.65", "6.45")
    assert (read["verdict"], read["margin"], read["used"]) == ("fitted", "6.722", "a joint")


# ---- estimates beside the truth ----------------------------------------------------------------


def test_relative_error_and_coverage_by_hand():
    row = recovery_of(estimate("K", 11.0, ci_low=9.5, ci_high=12.5), 10.0)
    assert row.relative_error == pytest.approx(0.1)
    assert row.covered is True
    assert recovery_of(estimate("K", 9.0), -10.0).relative_error == pytest.approx(-1.9)
    assert (row.recommended, row.flags) == (False, "")
    quoted = recovery_of(replace(estimate("K", 9.0), recommended=True, flags="sway;weak"), 10.0)
    assert (quoted.recommended, quoted.flags) == (True, "sway;weak")


@pytest.mark.parametrize(
    ("low", "high", "covered"),
    [(10.0, 12.0, True), (8.0, 10.0, True), (10.1, 12.0, False), (8.0, 9.9, False), (None, 12.0, None)],
)
def test_interval_covers_the_truth_up_to_its_ends(low, high, covered):
    assert recovery_of(estimate("K", 11.0, ci_low=low, ci_high=high), 10.0).covered is covered


def test_error_relative_to_nothing_is_not_a_number_but_nothing(tmp_path):
    row = recovery_of(estimate("I", 0.001, ci_low=-0.002, ci_high=0.004), 0.0)
    assert row.relative_error is None
    assert row.covered is True
    RECOVERIES.write(tmp_path / "recovery.csv", [row, recovery_of(estimate("K", 9.0), 10.0)])
    with open(tmp_path / "recovery.csv", newline="") as file:
        first, second = csv.DictReader(file)
    assert (first["truth"], first["relative_error"], first["covered"]) == ("0", "", "true")
    assert (second["relative_error"], second["covered"]) == ("-0.1", "")


def test_truth_is_the_joint_for_small_movements(shipped_truth):
    truth = true_parameters(shipped_truth)
    rubber = shipped_truth["dummy"]["rubber"]
    small = {
        "I": shipped_truth["dummy"]["subject"]["joint_inertia_kgm2"],
        "B": rubber["damping_Nms_per_rad"],
        "K": rubber["stiffness_Nm_per_rad"],
    }
    # what an estimator says of small movements is compared with the same joint, whatever the windows held
    assert truth["dummy"] == small | {f"{quantity}_small": small[quantity] for quantity in "IBK"}
    # the same rubber and its damping, in a rig that adds inertia
    rig = shipped_truth["wristalyzer"]["manipulator"]
    assert truth["wristalyzer"] == {
        "I": rig["inertia_kgm2"],
        "B": rubber["damping_Nms_per_rad"],
        "K": rubber["stiffness_Nm_per_rad"],
    }


def test_truth_of_some_experiments_is_theirs_alone(shipped_truth):
    whole = true_parameters(shipped_truth)
    both = {section: shipped_truth[section] for section in ("wristalyzer", "dummy")}
    assert true_parameters(both) == {key: whole[key] for key in (*both, "wristalyzer/pooled")}
    for section in ("dummy", "weight"):
        assert true_parameters({section: shipped_truth[section]}) == {section: whole[section]}
    person = {key: shipped_truth["standing"][key] for key in ("tasks", "muscles")}
    assert true_parameters({"standing": person}) == {
        name: whole[name] for name in ("standing/relax", "standing/stiff")
    }
    assert true_parameters({}) == {}


def test_only_known_parameters_are_compared(shipped_truth):
    estimates = [estimate("K", 9.0), estimate("VAF_trial", 99.0), estimate("I", 0.054)]
    known = true_parameters(shipped_truth)["dummy"]
    rows = compare_with_truth(estimates, known)
    assert [(row.quantity, row.value, row.truth, row.truth_of) for row in rows] == [
        ("K", 9.0, shipped_truth["dummy"]["rubber"]["stiffness_Nm_per_rad"], SMALL),
        ("I", 0.054, 0.007, SMALL),
    ]
    rows = compare_with_truth(estimates, known, {estimates[0].pathway: {"K": 8.0}, "another": {"I": 1.0}})
    assert [(row.truth, row.truth_of) for row in rows] == [(8.0, AT_WORK), (0.007, SMALL)]


def test_a_standing_person_has_a_truth_for_each_task_and_one_latency_per_muscle(shipped_truth):
    of_person = {"condition": "relax-neg-0.5", "experiment": "standing"}
    estimates = [
        estimate("K", 400.0, pathway="ankle", **of_person),
        estimate("latency_TA", 0.05, pathway="emg", **of_person),
        estimate("K_over_mgh", 0.7, pathway="ankle", **of_person),
    ]
    rows = compare_with_truth(estimates, true_parameters(shipped_truth)["standing/relax"])
    standing = shipped_truth["standing"]
    relax = standing["tasks"]["relax"]
    assert [(row.value, row.truth) for row in rows] == [
        (400.0, relax["stiffness_Nm_per_rad"][0] + relax["short_range_Nm_per_rad"]),
        (0.05, standing["muscles"]["TA"]["latency_s"]),
    ]
    # windows are those of an estimator, whatever the pathway
    (row,) = compare_with_truth(estimates[:1], {}, {estimates[0].estimator: {"K": 390.0}})
    assert (row.truth, row.truth_of) == (390.0, AT_WORK)


def test_comparisons_are_joined_in_the_order_of_the_estimates_with_their_flags(shipped_truth):
    estimates = [estimate("K", 9.0), estimate("VAF_trial", 99.0), estimate("I", 0.054)]
    rows = compare_with_truth(estimates, true_parameters(shipped_truth)["dummy"])
    later = [replace(estimates[0], flags="foot-leg-delay"), *estimates[1:]]
    assert in_order(rows[::-1], later) == [replace(rows[0], flags="foot-leg-delay"), rows[1]]


# ---- results of an analysis --------------------------------------------------------------------
