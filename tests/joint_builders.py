"""Fits and estimates of a human joint as its report reads them, with the numbers that a test wants."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from typst_builders import typeset_words

from tepsipe.reporting.chapters import position_manipulator
from tepsipe.reporting.run import Run, report_content

CHOICES = {
    "ingest": {"resample_rate_hz": 250.0},
    "analysis": {
        "lowpass_cutoff_hz": 30.0,
        "cut_s": 1.0,
        "block_s": 1.0,
        "training_fraction": 0.5,
        "parallel_cascade": {
            "intrinsic_lag_s": 0.04,
            "reflex_length_s": 0.6,
            "relaxation_times_s": [0.05, 0.2],
        },
    },
}
RECORDING = [
    "rate_hz",
    "recorded_s",
    "used_s",
    "fitted_s",
    "held_out_s",
    "mean_angle_rad",
    "sd_angle_rad",
    "lowest_angle_rad",
    "highest_angle_rad",
    "rms_velocity_rad_per_s",
    "peak_velocity_rad_per_s",
    "velocity_95_hz",
    "half_power_hz",
    "mean_torque_Nm",
    "sd_torque_Nm",
    "lowest_torque_Nm",
    "highest_torque_Nm",
    "cutoff_hz",
    "above_cutoff_percent",
    "block_s",
]
ALONE, CASCADE, MUSCLE = "regression", "parallel-cascade", "parallel-cascade-muscle"


@dataclass
class Fit:
    """Facts and arrays of a fit, as the report reads them (units in the keys)."""

    facts: dict
    arrays: dict = field(default_factory=dict)


def fit_of(
    direction=1,
    short_range=False,
    relaxing=False,
    pole_per_s=0.0,
    assumed=True,
    lasting_s=0.5,
    delays_s=(0.032, 0.044),
    p=0.5,
    white=0.0,
    memory_s=0.2,
    slow=80.0,
    coherent=1.0,
):
    frequency = np.linspace(0.5, 20.0, 40)
    recording = dict.fromkeys(RECORDING, 1.0)
    residual = {"rms_Nm": 0.4, "torque_rms_Nm": 1.0, "below_1_hz_percent": slow, "offset_percent": 3.0}
    residual |= {"memory_s": memory_s, "white_p": white}
    return Fit(
        {
            "training_s": 29.0,
            "reflex": {
                "direction": direction,
                "stiffening": False,
                "short_range": short_range,
                "relaxing": relaxing,
                "pole_per_s": pole_per_s,
                "gain_slope": False,
                "unloading": False,
                "delay_s": 0.04 * abs(direction),
                "delay_range_s": list(delays_s) if direction else [0.0, 0.0],
                "duration_s": lasting_s - 0.04 if direction else float("nan"),
                "slow_horizon_s": 0.25,
                "assumed": ["reflex_delay"] if assumed and direction else [],
            },
            "diagnostics": {
                "recording": recording,
                "residual": residual,
                "stiffness_equal_p": p,
                "level_equal_p": p,
            },
        },
        {
            "reflex/models_terms": np.array([[0.0] * 6, [1.0] * 6]),
            "reflex/models_coefficients": np.array([22.0, 45.0]),
            "reflex/models_vaf_cross_validated": np.array([80.0, 90.0]),
            "reflex/models_vaf_held_out": np.array([79.0, 89.0]),
            "diagnostics/frequency": frequency,
            "diagnostics/coherence": np.where(np.arange(40) < 40 * coherent, 0.9, 0.01),
            "diagnostics/coherence_level": np.full(40, 0.2),
            **{
                f"diagnostics/part_{name}": np.array(values)
                for name, values in {
                    "stiffness": [50.0, 51.0, 52.0],
                    "stiffness_half_width": [3.0, 3.0, 3.0],
                    "level": [1.0, 1.1, 1.2],
                    "level_half_width": [0.1, 0.1, 0.1],
                }.items()
            },
        },
    )


def rows_of(condition, direction=1, alone=80.0, cascade=90.0, gain=(8.0, 12.0), flags=""):
    known = [
        (ALONE, "K", "Nm/rad", 100.0, 90.0, 110.0),
        (CASCADE, "K", "Nm/rad", 50.04, 45.0, 55.0),
        (CASCADE, "K_working", "Nm/rad", 60.0, 55.0, 65.0),
        (CASCADE, "K_short_range", "Nm/rad", 80.0, 70.0, 90.0),
        (CASCADE, "reflex_gain", "Nms/rad", 10.0 * abs(direction), *gain),
        (CASCADE, "reflex_share", "%", 5.0, np.nan, np.nan),
    ]
    if direction:
        known.append((MUSCLE, "reflex_frequency", "Hz", 1.4, 1.3, 1.5))
    for estimator, vaf in ((ALONE, alone), (CASCADE, cascade)):
        for name in ("training", "held_out", "held_out_any_offset"):
            known.append((estimator, f"VAF_{name}", "%", vaf, np.nan, np.nan))
    known.append((CASCADE, "VAF_held_out_with_slow_torque", "%", cascade + 1.0, np.nan, np.nan))
    columns = ["estimator", "quantity", "unit", "value", "ci_low", "ci_high"]
    found = pd.DataFrame(known, columns=columns)
    found["recommended"] = (found.estimator == CASCADE) & (found.quantity == "K")
    return found.assign(experiment="position_manipulator", condition=condition, flags=flags)


def run_of(fits, rows, joint=None):
    """A run of some trials, with names of the joint and of its movements."""
    settings = {"position_manipulator": CHOICES | {"joint": joint or {}}}
    study = {"title": "t", "recordings_source": None, "experiments": {}, "made": {}, "reported": None}
    return Run(
        {"estimates": rows.assign(pathway="impedance")}, {"position_manipulator": fits}, settings, study
    )


def content_of(run):
    """Content of report.json, and tables, of a run."""
    content = report_content(run, {"position_manipulator": position_manipulator})
    return content, {"estimates": run.tables["estimates"].to_csv(index=False)}


def joint_words(source, run, cells=""):
    """Words of a source, typeset with the content of a run."""
    return typeset_words("#show ref: none\n" + source, *content_of(run), cells)
