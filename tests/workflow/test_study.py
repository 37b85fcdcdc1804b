"""Results of a tiny study, run by the real Snakefile in a copy of the project; nothing is changed here."""

import csv
import hashlib
import json

import h5py
import numpy as np
import pytest
import yaml
from study_builders import PEOPLE, estimates, joint_in_windows, table, value
from typst_builders import evaluated, tables_of

from tepsipe.drawing.names import PARAMETER_SETS
from tepsipe.io.trial import read_trial
from tepsipe.mechanics.engines import engine_version, resolved_engine

pytestmark = pytest.mark.study
FIGURES = (
    "1_1",
    "1_3",
    "2_4",
    *(f"2_{k}" for k in range(9, 13)),
    "averaged_bins",
    "3_1",
    "3_3",
    *(f"4_{k}" for k in range(1, 15)),
    "5_1",
    "b_1",
    "b_2",
    "b_13",
)


def laboratory(study):
    return yaml.safe_load((study / "config/virtual_lab.yaml").read_text(encoding="utf-8"))


def test_the_study_writes_every_output_of_its_contract(study):
    results = study / "results"
    for name in (
        "report/thesis.pdf",
        "report/supplement.pdf",
        "provenance.json",
        "tables/answers.csv",
        "tables/estimates.csv",
        "tables/uncertainty.csv",
        "tables/table_4_1.csv",
        "tables/table_4_2.csv",
        "tables/table_4_3.csv",
        "tables/table_4_4.csv",
        "tables/forward.csv",
        "tables/noise.csv",
        "tables/specification.csv",
        "tables/recovery.csv",
        "tables/other_laws.csv",
        "tables/claims.csv",
        "tables/cells.csv",
        "tables/treadmill_models.csv",
        "tables/averaging.csv",
        *[f"figures/figure_{number}.svg" for number in FIGURES],
        *[
            f"figures/standing/{condition}_{figure}.png"
            for condition in PEOPLE
            for figure in ("4_13", "4_14")
        ],
    ):
        assert (results / name).stat().st_size > 200, name
    assert (results / "report/thesis.pdf").read_bytes().startswith(b"%PDF")
    columns = (
        "experiment condition pathway estimator quantity unit value standard_error ci_low ci_high "
        "sem_as_printed n_perturbations u_type_a u_type_b recommended flags"
    )
    assert list(estimates(study)[0]) == columns.split()


def test_provenance_record_and_report_name_the_engine_that_ran(study):
    engine = json.loads((study / "results/provenance.json").read_text())["engine"]
    name = resolved_engine("auto")
    others = [] if name == "equations" else ["corrected", "joint-likelihood", "thesis-without-handle"]
    assert engine == {"name": name, "version": engine_version(name), "by_equations": others}
    data = json.loads((study / "results/report/report.json").read_text())
    assert data["chapters"]["study"]["numbers"]["provenance"]["engine"] == engine
    (facts,) = evaluated(["facts"], "provenance_values.typ", data)
    (shown,) = (text for key, text in facts if key == "Engine of the simulations")
    words = {"pybullet": "PyBullet", "mujoco": "MuJoCo", "equations": "equations"}
    named = [PARAMETER_SETS[one] for one in others]
    assert shown.startswith(f"{words[name]} {engine['version']}") and all(one in shown for one in named)


def test_a_trial_file_describes_itself(study):
    with h5py.File(study / "results/trials/dummy/sine-0.5.h5") as trial:
        assert trial.attrs["experiment"] == "dummy"
        sources = json.loads(trial.attrs["sources"])
        raw = study / sources["log"]["file"]
        assert sources["log"]["sha256"] == hashlib.sha256(raw.read_bytes()).hexdigest()
        for name in ("marker_position", "force", "moment", "belt_velocity"):
            assert trial[name].attrs["units"]
            assert trial[name].dims[0].keys() == ["time"]
        assert trial["marker_position"].dims[1].keys() == ["marker"]
        assert np.isclose(np.diff(trial["time"][:]), 1.0 / 250.0).all()


def test_exactly_one_estimate_of_a_quantity_is_recommended_and_its_parts_add_up(study):
    rows, budgets = estimates(study), table(study, "uncertainty")
    quoted = {}
    for row in rows:
        if row["recommended"] == "true":
            assert row["quantity"] in ("I", "B", "K", "mass") or row["quantity"].startswith("reflex_")
            quoted.setdefault((row["experiment"], row["condition"], row["quantity"]), []).append(row)
    assert all(len(own) == 1 for own in quoted.values())
    wanted = {
        (row["experiment"], row["condition"], row["quantity"])
        for row in rows
        # I of a standing person is not estimated by every estimator
        if row["quantity"] in ("I", "B", "K", "mass") and row["experiment"] != "standing"
    }
    assert wanted <= set(quoted)
    for key in (("dummy", "sine-0.5", "K"), ("weight", "sine-0.4", "mass")):
        (row,) = quoted[key]
        columns = ("experiment", "condition", "pathway", "estimator", "quantity")
        parts = [p for p in budgets if all(p[c] == row[c] for c in columns)]
        assert {p["type"] for p in parts} == {"A", "B"} and len(parts) > 3
        total = sum(float(p["u"]) ** 2 for p in parts) ** 0.5
        assert total == pytest.approx(float(row["standard_error"]), rel=1e-6)
        assert total == pytest.approx(np.hypot(float(row["u_type_a"]), float(row["u_type_b"])), rel=1e-6)
        assert float(row["ci_high"]) - float(row["value"]) == pytest.approx(1.96 * total, rel=0.02)
    told = json.loads((study / "results/report/report.json").read_text(encoding="utf-8"))["chapters"][
        "budgets"
    ]["numbers"]
    assert {"dummy", "foot", "weight"} <= set(told)
    largest = {q["quantity"]: q for q in told["dummy"]["quantities"]}["K"]
    assert largest["largest"] == "mass of the leg" and not largest["repeating"]


def test_the_recommended_pathway_recovers_the_truth_and_the_printed_one_its_prediction(study):
    """The rubber softens: windows hold the joint at work, output error that of small bending."""
    rows, dummy = estimates(study), laboratory(study)["dummy"]
    small, leg = dummy["rubber"], dummy["subject"]
    for condition in ("sine-0.5", "minjerk-0.5"):
        of = {"experiment": "dummy", "condition": condition}
        true = joint_in_windows(study / "results", condition)
        assert true["I"] == pytest.approx(leg["joint_inertia_kgm2"], rel=0.05)
        assert small["damping_Nms_per_rad"] < true["B"]
        assert true["K"] < 0.95 * small["stiffness_Nm_per_rad"]
        found = {q: value(rows, **of, pathway="leg", quantity=q) for q in "IBK"}
        assert found["K"] == pytest.approx(true["K"], rel=0.01)
        assert found["B"] == pytest.approx(true["B"], rel=0.1)
        assert found["I"] == pytest.approx(true["I"], rel=0.05)
        found = {q: value(rows, **of, pathway="leg-output-error", quantity=q) for q in "BK"}
        assert found["K"] == pytest.approx(small["stiffness_Nm_per_rad"], rel=0.02)
        assert found["B"] == pytest.approx(small["damping_Nms_per_rad"], rel=0.1)
        # the signs of eq (3-8) as printed, and markers as sampled one after the other
        printed = {q: value(rows, **of, pathway="leg-thesis", quantity=q) for q in "IBK"}
        weight = leg["leg_mass_kg"] * leg["gravity_m_per_s2"] * leg["leg_com_m"]
        assert printed["K"] == pytest.approx(true["K"] - 2.0 * weight, rel=0.02)
        assert printed["I"] == pytest.approx(true["I"] + 2.0 * leg["leg_inertia_kgm2"], rel=0.01)
        assert abs(printed["B"]) < 0.2 * true["B"]
        assert value(rows, **of, pathway="leg-thesis-aligned", quantity="B") == pytest.approx(
            true["B"], rel=0.1
        )
        assert value(rows, **of, pathway="leg-thesis", quantity="VAF_perturbation") > 99.8


def test_truth_of_a_drawn_constant_is_what_was_drawn(study):
    rows = {row["key"]: row for row in table(study, "laboratory")}
    drawn = rows["weight.mass_kg"]
    assert (drawn["kind"], drawn["nominal"], drawn["distribution"]) == ("drawn", "20", "rectangular")
    assert 19.95 < float(drawn["value"]) < 20.05
    assert drawn["value"] != drawn["nominal"]
    masses = [row for row in table(study, "recovery") if row["quantity"] == "mass"]
    assert {row["truth"] for row in masses} == {drawn["value"]}
    assert rows["treadmill.plate.bristle_share"]["value"] == "0"
    assert rows["treadmill.plate.second_share"]["value"] == "0 0"
    asked = ["mechanisms(on: false)", "mechanisms()", "drawn-constants()"]
    data = json.loads((study / "results/report/report.json").read_text(encoding="utf-8"))
    off, on, drawn = evaluated(asked, "laboratory_values.typ", data, tables_of(study / "results"))
    assert "treadmill.plate.bristle_share" in {row["key"] for row in off}
    assert "treadmill.plate.mount_share" in {row["key"] for row in on}
    assert [row["key"] for row in drawn] == ["weight.mass_kg"]


def test_the_treadmill_taken_out_of_the_force_leaves_the_joint(study):
    """Friction of the belt passes for a damping, unless a model of the treadmill takes it out."""
    rows = estimates(study)
    recovered = [row for row in table(study, "recovery") if row["experiment"] == "dummy"]
    for condition in ("sine-0.5", "minjerk-0.5"):
        error = {
            (row["pathway"], row["quantity"]): float(row["value"]) - float(row["truth"])
            for row in recovered
            if row["condition"] == condition
        }
        assert abs(error["foot", "B"]) > 1.0
        assert abs(error["foot-compensated", "B"]) < 0.1 * abs(error["foot", "B"])
        assert abs(error["foot-compensated", "K"]) < 0.1 * joint_in_windows(study / "results", condition)["K"]
    mass = value(rows, experiment="weight", condition="minjerk-0.4", quantity="mass")
    assert mass == pytest.approx(20.0, abs=0.8)


def test_another_law_of_the_joint_is_simulated_and_analysed_like_the_rubber(study):
    rows = table(study, "other_laws")
    assert {(row["law"], row["condition"]) for row in rows} == {("relaxation", "sine-0.5")}
    assert [(row["pathway"], row["quantity"]) for row in rows] == [
        (pathway, quantity) for pathway in ("leg", "leg-joint-likelihood") for quantity in "IBK"
    ]
    truth = joint_in_windows(study / "results", "sine-0.5", "other_laws/relaxation")
    shared = joint_in_windows(study / "results", "sine-0.5")
    for row in rows:
        assert float(row["truth"]) == pytest.approx(truth[row["quantity"]], rel=1e-6)
        error = (float(row["value"]) - float(row["truth"])) / float(row["truth"])
        assert float(row["relative_error"]) == pytest.approx(error, rel=1e-6)
    assert abs(truth["K"] / shared["K"] - 1.0) > 0.05
    # the same noise on another motion of the same belt
    ours, theirs = (
        read_trial(study / f"results/trials/{name}/sine-0.5.h5").values("belt_velocity")
        for name in ("dummy", "other_laws/relaxation")
    )
    assert 0.0 < np.abs(ours - theirs).max() < 0.02


def test_a_standing_persons_ankles_and_latencies_are_recovered(study):
    rows = [row for row in table(study, "recovery") if row["experiment"] == "standing"]
    for task in ("relax", "stiff"):
        (own,) = [
            row
            for row in rows
            if (row["condition"], row["pathway"], row["estimator"], row["quantity"])
            == (task, "ankle-compensated", "free-reflex-gls", "K")
        ]
        # she violates assumptions of the analysis
        assert abs(float(own["relative_error"])) < 0.2
        assert own["covered"] == "true"
        # her ankles soften: the truth is that of these windows, between large and small rotations
        stand = laboratory(study)["standing"]["tasks"][task]
        large, more = stand["stiffness_Nm_per_rad"][0], stand["short_range_Nm_per_rad"]
        assert own["truth_of"] == "the fitted windows"
        assert large + 0.02 * more < float(own["truth"]) < large + 0.8 * more
    # seven responses of one trial only, where the study has about 35 of four
    late = [
        float(row["value"]) - float(row["truth"]) for row in rows if row["quantity"].startswith("latency")
    ]
    assert len(late) > 8
    assert np.median(np.abs(late)) < 0.005
    stiffness = {
        row["condition"]: float(row["value"])
        for row in estimates(study)
        if (row["pathway"], row["estimator"], row["quantity"])
        == ("ankle-compensated", "free-reflex-gls", "K")
    }
    assert stiffness["stiff"] > 1.3 * stiffness["relax"]
    assert stiffness["stiff-relax"] == pytest.approx(stiffness["stiff"] - stiffness["relax"])


def test_simulations_tell_parameters_that_fit_a_torque_from_those_that_move_the_leg(study):
    for condition in ("sine-0.5", "minjerk-0.5"):
        pulses, trial = (
            {
                (row["parameter_set"], row["quantity"]): float(row[column])
                for row in table(study, "forward")
                if row["condition"] == condition
            }
            for column in ("vaf_perturbation", "vaf_trial")
        )
        for scores in (pulses, trial):
            assert scores["tep", "theta"] < scores["wristalyzer", "theta"]
            assert scores["tep", "tau"] > 70.0
            assert max(scores[name, "tau"] for name in ("wristalyzer", "corrected")) < 50.0
            assert scores["tep", "tau_consistent"] < -1000.0
        # in the windows the joint of the working amplitude moves the leg; the free swing that follows needs
        # that of small bending
        assert pulses["corrected", "tau_consistent"] > 70.0
        assert pulses["corrected", "theta"] > 70.0
        assert trial["corrected", "theta"] < 0.0


def test_recommended_estimator_stands_noise_that_the_treadmills_signals_may_have(study):
    of = {"estimator": "recommended", "quantity": "K", "snr_db": "20"}
    rows = [row for row in table(study, "noise") if all(row[key] == cell for key, cell in of.items())]
    assert {(row["condition"], row["noise_on"]) for row in rows} == {
        (condition, noise_on)
        for condition in ("sine-0.5", "minjerk-0.5")
        for noise_on in ("tau", "theta", "both")
    }
    for row in rows:
        assert float(row["mean"]) == pytest.approx(10.0, rel=0.02)
        assert row["n_draws"] == "10"


def test_models_of_the_treadmill_are_judged_on_trials_that_they_have_not_seen(study):
    with open(study / "results/tables/treadmill_models.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    columns = "model train test cutoff_hz r2 rms_before rms_after order r2_limit load unit converged"
    assert list(rows[0]) == columns.split()
    of = {"train": "empty+weight", "test": "weight", "cutoff_hz": "20", "load": "Fy"}
    frames = {row["model"]: row for row in rows if all(row[key] == cell for key, cell in of.items())}
    assert list(frames) == ["loaded-frame", "bristle-frame", "linear-frame"]
    assert all(float(frame["r2"]) > 0.98 for frame in frames.values())
    # of a treadmill without memory the second makes no worse a model than the first
    assert float(frames["bristle-frame"]["rms_after"]) < 1.1 * float(frames["loaded-frame"]["rms_after"])
    of |= {"train": "empty"}
    others = [float(row["r2"]) for row in rows if all(row[key] == cell for key, cell in of.items())]
    assert len(others) == 6
    assert max(others) < 0.8
