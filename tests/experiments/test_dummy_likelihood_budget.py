"""Sources that move markers: one step from the maximum gives what another fit of moved markers gives."""

from dataclasses import replace

import numpy as np
import pytest
from builders import Joint

from tepsipe.experiments.dummy.leg_pathways import analyse_dummy, trial_markers
from tepsipe.experiments.dummy.options import Pathway
from tepsipe.identification.budgets import markers as moves
from tepsipe.identification.budgets.leg import LIKELIHOOD_SOURCES
from tepsipe.identification.estimators import Record
from tepsipe.identification.likelihood.likelihood import maximise_likelihood
from tepsipe.mechanics.impedance_model import SMALL
from tepsipe.mechanics.segment_kinematics import joint_motion
from tepsipe.statistics.uncertainty import SCATTER, Source
from tests.experiments.test_dummy_budget import KNOWN
from tests.experiments.test_dummy_leg_pathways import trial_of_swing

# larger than shipped: beyond the noise of a fit, and still linear
U = {"marker_sampling_s": 1e-4, "levelled_rad": 3e-3, "leg_bending_rad_per_m_per_s2": 1e-6}
SOURCES = {name: Source(name, u) for name, u in U.items()}
OPTIONS = replace(KNOWN, sources=SOURCES)
LINEAR = {"likelihood": Pathway("leg", "aligned", "joint-likelihood-linear")}


@pytest.fixture(scope="module")
def trial():
    return trial_of_swing(Joint(rest=0.005), noise_m=1e-5)


@pytest.fixture(scope="module")
def found(trial):
    return analyse_dummy(trial, OPTIONS, LINEAR)


@pytest.fixture(scope="module")
def record(trial, found):
    return Record(
        motion=joint_motion(trial.time, np.zeros_like(trial.time)),
        markers=trial_markers(trial, OPTIONS, "aligned"),
        belt_log=trial.values("belt_velocity"),
        at_rest=trial.time < 1.5,
        perturbations=found.regressions["likelihood"].perturbations,
    )


@pytest.mark.parametrize("name", U)
def test_a_step_from_the_maximum_is_what_another_fit_finds(record, found, name, monkeypatch):
    monkeypatch.setattr("tepsipe.identification.likelihood.channels.levelled", lambda markers, _: markers)
    regression, time = found.regressions["likelihood"], record.motion.time
    (row,) = found.budgets["likelihood"].contributions[name]
    level = record.markers.positions
    moved = {
        "marker_sampling_s": lambda u: moves._later(level, time, u * record.markers.places),
        "levelled_rad": lambda u: moves._turned(level, u),
        "leg_bending_rad_per_m_per_s2": lambda u: moves._bent(
            record.markers, u, regression.fit.model.motion.y_dd
        ),
    }[name](U[name])

    def refit(positions):
        other = replace(record.markers, positions=positions)
        fit = maximise_likelihood(time, other, record.belt_log, OPTIONS.leg, record.at_rest, softening=False)
        return np.array([fit.value(key) for key in ("J", "B", "K")])

    change = refit(moved) - refit(level)
    assert row == pytest.approx(change, rel=0.1, abs=1e-6)
    assert abs(row[2]) > 1e-4


def test_sources_that_move_markers_act_in_proportion_and_levelling_on_the_likelihood_alone(trial, found):
    again = analyse_dummy(
        trial,
        replace(
            OPTIONS,
            sources={
                name: replace(s, standard_uncertainty=2.0 * s.standard_uncertainty)
                for name, s in SOURCES.items()
            },
        ),
        LINEAR | {"leg": Pathway("leg", "aligned", "windowed-least-squares")},
    )
    one, two = found.budgets["likelihood"], again.budgets["likelihood"]
    assert set(one.contributions) == set(U)
    assert set(again.budgets["leg"].contributions) == set(U) - set(LIKELIHOOD_SOURCES)
    for name in U:
        assert two.of_source(name) == pytest.approx(2.0 * one.of_source(name), rel=0.1, abs=1e-9)
    assert {*LIKELIHOOD_SOURCES} < set(U)


def test_instants_of_all_markers_alike_are_a_delay_and_nothing_else(record, found):
    regression = found.regressions["likelihood"]
    markers = replace(record.markers, places=np.ones_like(record.markers.places))
    working, _ = moves.marker_contributions(regression, replace(record, markers=markers), SOURCES)
    (alike,), (apart,) = (
        working["marker_sampling_s"],
        found.budgets["likelihood"].contributions["marker_sampling_s"],
    )
    assert abs(alike[1]) < 0.2 * abs(apart[1])


def test_a_softening_joint_has_contributions_for_small_movements_too(trial):
    both = analyse_dummy(trial, OPTIONS, {"likelihood": Pathway("leg", "aligned", "joint-likelihood")})
    assert set(both.budgets["likelihood"].contributions) == set(U)
    small = [both.quantities["likelihood"][name].parts for name in SMALL]
    assert all(set(parts) == {SCATTER, *U} for parts in small)
    assert all(np.isfinite(list(parts.values())).all() for parts in small)
