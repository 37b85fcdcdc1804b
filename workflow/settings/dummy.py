"""Settings of the ankle dummy on the treadmill (thesis sections 2-1-2 and 3-1-2), and of its simulations."""

from typing import Any, Literal

from pydantic import model_validator

from tepsipe.errors import InputError, quoted
from tepsipe.experiments.dummy.options import FootPathway, Pathway, SpecificationOptions
from tepsipe.identification.estimators import ESTIMATORS, JOINT_LIKELIHOOD, OUTPUT_ERROR
from tepsipe.quantities import Draws, Gravity, Inertia, Length, PartMass, Stiffness, Time
from workflow.settings.plate_treadmill import MarkerLabels, PlacedMarkers, TreadmillIngest, Window
from workflow.settings.section import (
    Section,
    UnfitError,
    different,
    made_from,
    meanings,
    named,
    number,
    one_of,
    refuse_unknown,
    setting,
)

# what pathways with an estimator need, beside its meaning in the registry
ABOUT_ESTIMATORS = {
    OUTPUT_ERROR: "the foot has the markers `foot.belt_fixed_labels` "
    "([decision 40](../docs/decisions/0040-output-error.md)); its intervals "
    "require perturbations further apart than 2 J / B, the time for which the leg rings; requires "
    "`torque: leg`, which is used for its VAF; not for `as_printed` or `recommended`",
    JOINT_LIKELIHOOD: "*I*, *B*, *K* are those of the linear "
    "joint nearest to it in the windows, `I_small`, `B_small`, `K_small` those of small movements "
    "([decision 49](../docs/decisions/0049-joint-likelihood.md)); requires `torque: leg`, which is used "
    "for its VAF; not for `as_printed` or `recommended`",
}


class DummyFiles(Section):
    """Files of a recording."""

    marker_labels: MarkerLabels = setting(
        "markers in the C3D file, in the order of sequential sampling", thesis="Figure 2-6"
    )


class Geometry(Section):
    """Masses and lengths, and places of the markers."""

    leg_mass_kg: PartMass = setting("mass of the leg", thesis="Table 2-2")
    leg_com_m: Length = setting(
        "distance from the ankle to the centre of mass of the leg: half of 0.897 m", thesis="Table 2-2"
    )
    leg_inertia_kgm2: Inertia = setting(
        "moment of inertia of the leg about its centre of mass", thesis="Table 2-2"
    )
    foot_mass_kg: PartMass = setting("mass of the foot", thesis="Table 2-2")
    foot_height_m: Length = setting(
        "height of the ankle above the belt; the centre of mass of the foot is below the ankle, at half this "
        "height",
        thesis="Table 2-2",
    )
    gravity_m_per_s2: Gravity = setting("gravity")
    leg_markers: PlacedMarkers = setting("markers of the leg, at least two")


class DummyAnalysis(Window):
    """Search for perturbations and rest, and bootstrap."""

    bootstrap_draws: Draws = setting("bootstrap samples over perturbations")


class Checks(Section):
    """Checks of every trial."""

    joint_inertia_Nms2_per_rad: Inertia | None = setting(
        "inertia of the joint beyond that of the leg, with which I is compared "
        "([checks](../docs/checks.md)); null if it is not known"
    )
    joint_inertia_uncertainty_Nms2_per_rad: Inertia = setting("its standard uncertainty")


class LegPathway(made_from(Pathway, without=("estimator",))):
    """One way from raw signals to parameters, by the motion of the leg only."""

    estimator: str = setting("estimator of the parameters", values=meanings(ESTIMATORS, ABOUT_ESTIMATORS))


class Foot(Section):
    """Torque from the foot and the force plate."""

    ankle_label: str = setting("marker on the ankle", thesis="Figure 2-6")
    belt_fixed_labels: different(str) = setting(
        "belt-fixed markers: their mean determines the delay of the markers relative to the logged belt "
        "velocity, and is the motion of the foot for output error and joint likelihood"
    )
    pathways: named(made_from(FootPathway)) = setting("name: a pathway of the foot", thesis="3-1-2, 3-1-3")


class Simulation(Section):
    """Forward simulation, also of the noise study."""

    engine: one_of(
        {
            "pybullet": "PyBullet",
            "mujoco": "MuJoCo",
            "equations": "Runge-Kutta method of this project, always available",
            "auto": "the first of these that is installed ([decision 42](../docs/decisions/0042-engines.md))",
        }
    ) = setting(
        "engine of the noise study, and of the forward simulation with the parameters that the thesis "
        "compares; `equations` moves the dummy with all others",
        thesis="2-1-3: SimMechanics",
    )
    step_s: number(above=0, most=1) = setting(
        "step of the simulation: an integer fraction of the sampling interval", thesis="2-1-3: 0.004"
    )
    figure_4_7_condition: str = setting(
        "condition of Figures 4-7 and 4-9; the last of the sheet if the study does not contain it",
        thesis="Figures 4-7, 4-9",
    )
    figure_4_8_condition: str = setting("the same for Figure 4-8", thesis="Figure 4-8")


class Specification(made_from(SpecificationOptions)):
    """One trial by all combinations of choices."""

    condition: str = setting(
        "condition of the specification curve; the last of the sheet if the study does not contain it",
        thesis="Appendix A",
    )


class ThesisDummy(Section):
    """Inverse problem: the dummy that returns the printed tables."""

    searched_s: Time = setting(
        "[inverse problem](../docs/decisions/0046-dummy-of-the-thesis.md): perturbations that begin later "
        "are left out of the search for the constants"
    )
    draws: int = setting("trials with other noise that are averaged, for each condition", least=2)


class Dummy(Section):
    """The ankle dummy on the instrumented treadmill."""

    files: DummyFiles
    ingest: TreadmillIngest
    geometry: Geometry
    analysis: DummyAnalysis
    checks: Checks
    pathways: named(LegPathway) = setting("name: a pathway of the leg", thesis="Appendix A")
    foot: Foot
    simulation: Simulation
    specification: Specification
    thesis_dummy: ThesisDummy
    as_printed: str = setting(
        "one of `pathways`: used in Tables 4-2 and 4-3, in the claims, and for the simulated TEP-SIPE "
        "parameters"
    )
    recommended: str = setting(
        "one of `pathways`: the recommended windowed fit, which is compared with the joint likelihood "
        "([checks](../docs/checks.md)), second block of the tables, simulated as `corrected`"
    )
    quoted: str = setting(
        "one of `pathways`, whose *I*, *B*, *K* are to be quoted: `recommended` is `true` in "
        "`tables/estimates.csv`; if its model does not fit the trial ([checks](../docs/checks.md)) and "
        "those of `recommended` pass, these"
    )
    example_condition: str = setting(
        "condition of the example figures; the last of the sheet if the study does not contain it",
        thesis="Figure 3-3",
    )

    @model_validator(mode="after")
    def _names(self) -> Any:
        for key in ("as_printed", "recommended", "quoted"):
            refuse_unknown(key, getattr(self, key), "dummy.pathways", self.pathways)
        labels = [marker.label for marker in self.geometry.leg_markers]
        twice = sorted({label for label in labels if labels.count(label) > 1})
        if twice:
            expected, found = "to place every marker once", f"{quoted(twice[0])} twice"
            raise UnfitError(expected, "correct one of the two", "geometry.leg_markers", found)
        known = self.files.marker_labels
        for key, named_labels in (
            ("geometry.leg_markers", labels),
            ("foot.belt_fixed_labels", self.foot.belt_fixed_labels),
        ):
            for label in sorted(set(named_labels) - set(known)):
                expected = "to name markers of dummy.files.marker_labels"
                raise UnfitError(expected, "correct one of the two", key, quoted(label))
        return self

    @model_validator(mode="after")
    def _estimators(self) -> Any:
        windowed = [key for key, estimator in ESTIMATORS.items() if estimator.fits_torque]
        for name, pathway in self.pathways.items():
            refuse_unknown(
                f"pathways.{name}.estimator", pathway.estimator, "the estimators", list(ESTIMATORS)
            )
        for name, pathway in self.foot.pathways.items():
            refuse_unknown(f"foot.pathways.{name}.estimator", pathway.estimator, "the estimators", windowed)
        for name, pathway in self.pathways.items():
            if "torque" in ESTIMATORS[pathway.estimator].needs:
                continue
            if pathway.torque != "leg":
                raise InputError(
                    f"expected the torque leg in dummy.pathways.{name}, because the estimator "
                    f"{pathway.estimator} uses a torque for its VAF only, found {quoted(pathway.torque)}: "
                    "correct one of the two"
                )
            for key in ("as_printed", "recommended"):
                if getattr(self, key) == name:
                    raise UnfitError(
                        "to name a pathway with windowed least squares, because tables and figures show "
                        "every perturbation",
                        "name another",
                        key,
                        quoted(name),
                    )
        return self


# name: torque, estimate, what is filtered, noise
PROCESSINGS = {
    "as-printed": (
        "foot, thesis equation (`foot-thesis`)",
        "windowed least squares, mean over perturbations",
        "noisy signals: torque, or angle with its rates",
        "by the SNR; noise on the angle propagates to its rates",
    ),
    "as-tabulated": (
        "as above",
        "as above",
        "torque and angle always, the rates never",
        "power 1 over the SNR, in (N·m)² or rad², independent of the signal; rates without noise",
    ),
    "recommended-regression": ("leg, consistent (`leg`)", "as above", "all signals", "as `as-printed`"),
    "recommended": (
        "as above",
        "instrumental-variable (IV) estimate over all perturbations: belt acceleration, velocity and "
        "position as instruments",
        "all signals, including the belt",
        "as `as-printed`",
    ),
    "joint-sensor": (
        "sensor of the simulated joint, equation (2-1)",
        "windowed least squares, mean over perturbations",
        "as `as-printed`",
        "as `as-printed`",
    ),
}
Processings = different(Literal[tuple(PROCESSINGS)])


class NoiseJoint(Section):
    """The simulated joint."""

    inertia_Nms2_per_rad: Inertia = setting("I of the simulated joint", thesis="Table 4-4")
    damping_Nms_per_rad: number(above=0, most=1000) = setting("B", thesis="Table 4-4")
    stiffness_Nm_per_rad: different(Stiffness) = setting(
        "K, larger than m g r of the leg. The first is swept over all SNRs, the others are simulated at "
        "`table_snr_db` only; Table 4-4 is computed for each",
        thesis="Table 4-4, Figure 4-12",
    )


class Noise(Section):
    """TEP-SIPE on simulated data with measurement noise (thesis sections 2-1-3 and 3-1-3)."""

    joint: NoiseJoint
    snr_db: different(number(least=-100, most=200)) = setting(
        "signal power over noise power", thesis="2-1-3, no numbers"
    )
    table_snr_db: number(least=-100, most=200) = setting(
        "SNR of Table 4-4 and Figure 4-12; one of `snr_db`", thesis="Figure 4-12"
    )
    draws: int = setting("number of draws of the noise in every cell (trial, target, SNR)", least=2)
    predicted_draws: int = setting(
        "number of draws for which the angle is also predicted, and perturbations are detected", least=1
    )
    estimators: Processings = setting("processings at every SNR, see below", thesis="3-1-3")
    table_estimators: Processings = setting(
        "the same for Table 4-4 and Figure 4-12, at `table_snr_db`", thesis="3-1-3"
    )

    @model_validator(mode="after")
    def _table_among_all(self) -> Any:
        if self.table_snr_db not in self.snr_db:
            expected = f"to be one of noise.snr_db ([{', '.join(f'{snr:g}' for snr in self.snr_db)}])"
            raise UnfitError(expected, "correct one of the two", "table_snr_db", f"{self.table_snr_db:g}")
        return self
