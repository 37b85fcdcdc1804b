"""Constants of the virtual force plate that meet section 4-1-2 of the thesis, fitted to its statements.

    .venv/bin/python benchmarks/plate_constants.py [--seed 1] [--starts 1]
    .venv/bin/python benchmarks/plate_constants.py --studies SHIPPED FITTED DAMPED

The second command prints what whole studies return, as a table (CSV) that the report of the study shows. Its
arguments are folders of results: with the shipped plate, with the fitted one (config/plate-of-4-1-2.yaml,
rounded), and with a plate of almost the same misfit whose second mode is more damped (`DAMPED`).

One pulse of each profile and amplitude moves the weight of 20 kg, and the empty belt, in the laboratory
without noise. With the measured force F, the acceleration a of the weight, the acceleration a_b of the belt,
all filtered at 20 Hz, and the mass m of the weight, in the 0.3 s of the pulse:

    mass                  sum(a_b F) / sum(a_b a)
    belt-induced force    F - m a(t + e) = F - m a - m e a'

The markers lead the forces by e: the latency of the motion capture, drawn once for a laboratory, and the
phase of the trigger in a sample of the log, drawn for every trial (0.5 ms either way). The standard deviation
of the mass adds the floor's vibration, the lag of the belt that varies between pulses, and the noise of the
markers.

The fit minimises a sum of squares over

    (mass - printed) / printed SD                        four masses
    log2(SD / printed SD)                                four standard deviations
    max(0, 2 - mean / SD) of a difference of peaks       amplitude less the next lower one, eight times;
                                                         minimum jerk less sine at 0.5 m/s
    shortfall of the belt speed at the peak, of the correlation at 10 Hz, of the growth with amplitude
    (fall of the mass, mean of the profiles - printed) / 0.1 kg
    PRIOR log2(constant / shipped)                       constants stay where no statement moves them

The mean and the SD of a difference are those over drawn e. A statement is thus fitted to many laboratories,
and not to the draws of one.
"""

import argparse
import os
import sys
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402
import scipy  # noqa: E402
import yaml  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tepsipe.signals.differentiation import degree_at, derivative  # noqa: E402
from tepsipe.signals.filters import Lowpass  # noqa: E402
from tepsipe.virtual_lab.belt import BeltMotion, DriveTruth, velocity_command  # noqa: E402
from tepsipe.virtual_lab.force_plate import (  # noqa: E402
    Loaded,
    PlateTruth,
    lines_of_action,
    voltages_of_belts,
)
from tepsipe.virtual_lab.weight_trial import WeightTruth, move_weight  # noqa: E402

TRUTH = yaml.safe_load((ROOT / "config/virtual_lab.yaml").read_text(encoding="utf-8"))
SHIPPED = PlateTruth(**TRUTH["treadmill"]["plate"])
WEIGHT, DRIVE = WeightTruth(**TRUTH["weight"]), DriveTruth(**TRUTH["treadmill"]["drive"])
CAPTURE = TRUTH["treadmill"]["capture"]
FINE, COARSE = Lowpass(20.0, 4, True), Lowpass(10.0, 4, True)
RATE_HZ, GRID_HZ, CAMERA_HZ = 1000.0, 2000.0, 250.0
ONSET_S, SEGMENT_S, DURATION_S, REST_S = 0.3, 0.3, 0.8, 40.0
REACTION_S = 0.002  # of the belt after the delay of the drive
AMPLITUDES = (0.1, 0.2, 0.3, 0.4, 0.5)
CONDITIONS = tuple((profile, amplitude) for profile in ("sine", "minjerk") for amplitude in AMPLITUDES)
# mass and standard deviation (kg), section 4-1-2
PRINTED = {
    ("sine", 0.1): (20.0, 0.5),
    ("sine", 0.5): (19.5, 0.2),
    ("minjerk", 0.1): (19.7, 0.9),
    ("minjerk", 0.5): (19.4, 0.2),
}
QUIET = {"noise_V": 0.0, "drift_V_per_s": 0.0, "floor_m_per_s2": 0.0, "belt_lag_wander": 0.0}
TRIGGER_S, DRAWS, PRIOR = 0.0005, 400, 0.5
# speed at the peak relative to the peak speed, correlation at 10 Hz, growth: what is wanted, and its scale
FALL_KG = 0.1
WANTED = {"speed": (0.95, 0.03), "alike": (0.92, 0.02), "growth": (4.5, 0.3)}


# a plate of almost the same misfit
DAMPED = {
    "second_hz": 26.0,
    "second_share.0": 0.45,
    "second_damping": 0.08,
    "mount_share": 0.161,
    "belt_lag_s": 0.0035,
    "belt_lag_wander": 0.23,
    "friction_N": 30.0,
    "friction_coefficient": 0.15,
    "friction_speed_m_per_s": 0.079,
    "friction_Ns_per_m": 59.0,
    "floor_m_per_s2": 0.007,
}

HEAD = """# Constants of the virtual force plate, fitted to section 4-1-2

*Found*: by the search; *fitted*: rounded, `config/plate-of-4-1-2.yaml`; *damped*: a plate of almost
the same misfit whose second mode is more damped. Statements are those of the nominal laboratory,
and shares are of {draws} laboratories with drawn clocks. Results of whole studies with these
plates: `plate_constants.csv`. Reasons:
[decision 72](../docs/decisions/0072-plate-of-section-4-1-2.md).
"""


@dataclass(frozen=True)
class Constant:
    """A constant of the plate that the fit may move (unit of the key)."""

    start: float
    """Where the search starts."""
    low: float
    high: float
    """Plausible range."""
    reason: str
    """Reason for the range."""


FORCE_SHARE = "second_share.0"
CONSTANTS = {
    "second_hz": Constant(30.0, 25.0, 90.0, "frames of force treadmills (Kram et al. 1998)"),
    FORCE_SHARE: Constant(0.3, 0.05, 0.5, "assumed"),
    "second_damping": Constant(0.1, 0.05, 0.2, "bolted steel to rubber mounts (assumed)"),
    "mount_share": Constant(0.13, 0.03, 0.25, "assumed"),
    "belt_lag_s": Constant(0.005, 0.002, 0.015, "assumed"),
    "belt_lag_wander": Constant(0.2, 0.05, 0.4, "assumed"),
    "friction_N": Constant(20.0, 5.0, 40.0, "pull that keeps an empty belt moving (assumed)"),
    "friction_coefficient": Constant(0.12, 0.04, 0.15, "belts on lubricated decks (assumed)"),
    "friction_speed_m_per_s": Constant(0.1, 0.03, 0.2, "assumed"),
    "friction_Ns_per_m": Constant(40.0, 5.0, 120.0, "assumed"),
    "floor_m_per_s2": Constant(0.01, 0.002, 0.02, "floors of laboratories (Gordon 1991)"),
}


@dataclass(frozen=True)
class Pulse:
    """One pulse with the weight, over its segment at `RATE_HZ`, filtered at 20 Hz."""

    mass_kg: float
    sd_kg: float | None
    """Estimate of the mass, and its standard deviation between pulses where the thesis prints one."""
    induced: np.ndarray
    """Belt-induced force F - m a (N)."""
    jerk_force: np.ndarray
    """m a' (N/s)."""
    speed: np.ndarray
    """Speed of the belt (m/s)."""
    alike: float
    """Correlation of the belt-induced forces with and without the weight, at 10 Hz."""


def changed(values: dict[str, float]) -> PlateTruth:
    """Plate with other constants, by their keys."""
    values = dict(values)
    if FORCE_SHARE in values:
        values["second_share"] = [values.pop(FORCE_SHARE), SHIPPED.second_share[1]]
    return replace(SHIPPED, **values)


def fitted_plate() -> PlateTruth:
    """Plate of config/plate-of-4-1-2.yaml: the fitted one, rounded."""
    own = yaml.safe_load((ROOT / "config/plate-of-4-1-2.yaml").read_text(encoding="utf-8"))
    return replace(SHIPPED, **own["treadmill"]["plate"])


def value_of(plate: PlateTruth, key: str) -> float:
    """Constant of a plate by its key (unit of the key)."""
    return plate.second_share[0] if key == FORCE_SHARE else getattr(plate, key)


@cache
def motions() -> dict[tuple[str, float, bool], BeltMotion]:
    """(profile, amplitude, loaded) -> motion of belt and frame.

    Friction, and the share of the second mode, change the motion of a frame of 150 kg by micrometres, so all
    plates share these motions.
    """
    below = [(replace(SHIPPED, **QUIET), 1.0)]
    return {
        (profile, amplitude, loaded): move_weight(
            WEIGHT if loaded else None,
            DRIVE,
            velocity_command(profile, amplitude, np.array([ONSET_S]), 0.1),
            DURATION_S,
            GRID_HZ,
            below,
        )
        for profile, amplitude in CONDITIONS
        for loaded in (True, False)
    }


def logged_force(plate: PlateTruth, motion: BeltMotion) -> np.ndarray:
    """Change of the fore-aft force (N) at `RATE_HZ`, by ideal amplifiers."""
    sample = np.arange(0, motion.time.size, round(GRID_HZ / RATE_HZ))
    loaded = {"right": Loaded(plate, motion)}
    transducers = voltages_of_belts(loaded, np.eye(14), sample, np.random.default_rng(1))[:, 7:]
    force = (transducers @ lines_of_action(plate).T)[:, 1]
    return force - force[0]


def segment(x: np.ndarray, lowpass: Lowpass = FINE) -> np.ndarray:
    """Filtered signal in the segment of the pulse."""
    first = round((ONSET_S + DRIVE.delay_s + REACTION_S) * RATE_HZ)
    return lowpass(x, RATE_HZ)[first : first + round(SEGMENT_S * RATE_HZ)]


@cache
def floor_force() -> np.ndarray:
    """Force at `RATE_HZ` of a belt at rest, filtered, per vibration of the floor (N per m/s²)."""
    still = np.zeros(round(REST_S * GRID_HZ) + 1)
    motion = BeltMotion(np.arange(still.size) / GRID_HZ, *[still] * 6, np.zeros((still.size, 6)))
    plate = replace(SHIPPED, **QUIET | {"floor_m_per_s2": 1.0})
    margin = round(RATE_HZ)
    return scipy.signal.detrend(FINE(logged_force(plate, motion), RATE_HZ)[margin:-margin])


@cache
def marker_acceleration() -> np.ndarray:
    """Noise of the weight's acceleration from four markers (m/s²), at `CAMERA_HZ`."""
    white = np.random.default_rng(1).standard_normal(round(3.0 * REST_S * CAMERA_HZ))
    noise = CAPTURE["noise_m"] / 2.0 * white
    time, degree = np.arange(noise.size) / CAMERA_HZ, degree_at(CAMERA_HZ)
    return derivative(time, derivative(time, FINE(noise, CAMERA_HZ), degree), degree)


def spread(noise: np.ndarray, instrument: np.ndarray) -> float:
    """Standard deviation of sum(instrument noise) over many segments."""
    windows = np.lib.stride_tricks.sliding_window_view(noise, instrument.size)[:: instrument.size // 2]
    return float((windows @ instrument).std())


def pulse(plate: PlateTruth, condition: tuple[str, float]) -> Pulse:
    """One pulse on a plate."""
    quiet, motion = replace(plate, **QUIET), motions()[*condition, True]
    every = slice(None, None, round(GRID_HZ / RATE_HZ))
    force, acceleration = logged_force(quiet, motion), motion.acceleration[every]
    belt, own = segment(motion.belt_acceleration[every]), segment(acceleration)
    jerk = segment(np.gradient(acceleration, 1.0 / RATE_HZ))
    per_kg = float(belt @ own)
    sd = None
    if condition in PRINTED:
        step = 0.05
        lagging = logged_force(replace(quiet, belt_lag_s=(1.0 + step) * plate.belt_lag_s), motion)
        thinned = belt[:: round(RATE_HZ / CAMERA_HZ)]
        parts = (
            belt @ segment(lagging - force) / step * plate.belt_lag_wander,
            spread(floor_force(), belt) * plate.floor_m_per_s2,
            WEIGHT.mass_kg * spread(marker_acceleration(), thinned) * RATE_HZ / CAMERA_HZ,
        )
        sd = float(np.linalg.norm(parts)) / per_kg
    empty = segment(logged_force(quiet, motions()[*condition, False]), COARSE)
    late = acceleration + CAPTURE["latency_s"] * np.gradient(acceleration, 1.0 / RATE_HZ)
    coarse = segment(force - WEIGHT.mass_kg * late, COARSE)
    return Pulse(
        float(belt @ segment(force)) / per_kg,
        sd,
        segment(force) - WEIGHT.mass_kg * own,
        WEIGHT.mass_kg * jerk,
        np.abs(segment(motion.belt_velocity[every])),
        float(empty @ coarse / np.sqrt((empty @ empty) * (coarse @ coarse))),
    )


@dataclass(frozen=True)
class Statements:
    """The statements of section 4-1-2 on one plate; draws of the timing along the first axis."""

    masses_kg: np.ndarray
    sds_kg: np.ndarray
    """In the order of `PRINTED`."""
    peaks_N: dict[tuple[str, float], np.ndarray]
    speed: np.ndarray
    """Speed of the belt at the peak of the force, relative to its peak: lowest of all conditions."""
    alike: float
    """Lowest correlation at 10 Hz."""

    @property
    def differences(self) -> np.ndarray:
        """Eight steps from an amplitude to the next, and minimum jerk less sine at 0.5 m/s (N)."""
        peaks = self.peaks_N
        steps = [
            peaks[profile, more] - peaks[profile, less]
            for profile in ("sine", "minjerk")
            for less, more in pairwise(AMPLITUDES)
        ]
        return np.array([*steps, peaks["minjerk", 0.5] - peaks["sine", 0.5]])

    @property
    def growth(self) -> float:
        """Largest median ratio of the force at 0.5 m/s to that at 0.1 m/s."""
        ratios = [np.median(self.peaks_N[p, 0.5] / self.peaks_N[p, 0.1]) for p in ("sine", "minjerk")]
        return float(max(ratios))


def statements(plate: PlateTruth) -> Statements:
    """The statements on one plate, in laboratories whose clocks are drawn."""
    pulses = {condition: pulse(plate, condition) for condition in CONDITIONS}
    rng = np.random.default_rng(TRUTH["seed"])
    half = TRUTH["drawn"]["treadmill.capture.latency_s"]["rectangular"]
    latency = CAPTURE["latency_s"] + rng.uniform(-half, half, DRAWS)
    peaks, speeds = {}, []
    for condition, own in pulses.items():
        lead = latency + rng.uniform(-TRIGGER_S, TRIGGER_S, DRAWS)
        force = np.abs(own.induced - lead[:, None] * own.jerk_force)
        peaks[condition] = force.max(axis=1)
        speeds.append(own.speed[force.argmax(axis=1)] / own.speed.max())
    return Statements(
        np.array([pulses[condition].mass_kg for condition in PRINTED]),
        np.array([pulses[condition].sd_kg for condition in PRINTED]),
        peaks,
        np.min(speeds, axis=0),
        min(own.alike for own in pulses.values()),
    )


def residuals(logarithms: np.ndarray) -> np.ndarray:
    """Residuals of the fit at the logarithms of the constants, see the head of the module."""
    plate = changed(dict(zip(CONSTANTS, np.exp(logarithms).tolist(), strict=True)))
    found, printed = statements(plate), np.array(list(PRINTED.values()))
    differences = found.differences
    shipped = np.log([value_of(SHIPPED, key) for key in CONSTANTS])
    fall, printed_fall = (np.mean(x[1::2] - x[::2]) for x in (found.masses_kg, printed[:, 0]))
    values = {"speed": np.median(found.speed), "alike": found.alike, "growth": -found.growth}
    wanted = [
        max(0.0, ((-1.0 if name == "growth" else 1.0) * limit - values[name]) / scale)
        for name, (limit, scale) in WANTED.items()
    ]
    return np.concatenate(
        [
            (found.masses_kg - printed[:, 0]) / printed[:, 1],
            np.log2(found.sds_kg / printed[:, 1]),
            np.maximum(0.0, 2.0 - differences.mean(axis=1) / differences.std(axis=1)),
            wanted,
            [(fall - printed_fall) / FALL_KG],
            PRIOR * (logarithms - shipped) / np.log(2.0),
        ]
    )


def fitted(seed: int, starts: int) -> tuple[dict[str, float], float]:
    """Constants with the smallest sum of squares of several starts (units of the keys), and that sum."""
    rng = np.random.default_rng(seed)
    low, high = (np.log([getattr(c, end) for c in CONSTANTS.values()]) for end in ("low", "high"))
    best = None
    for k in range(starts):
        start = np.log([c.start for c in CONSTANTS.values()]) + (k > 0) * 0.2 * rng.standard_normal(low.size)
        start = np.clip(start, low + 0.01, high - 0.01)
        fit = scipy.optimize.least_squares(residuals, start, bounds=(low, high), diff_step=0.02, max_nfev=12)
        print(f"start {k}: {2.0 * fit.cost:.3g}", file=sys.stderr, flush=True)
        best = fit if best is None or fit.cost < best.cost else best
    return dict(zip(CONSTANTS, np.exp(best.x).tolist(), strict=True)), 2.0 * float(best.cost)


def squared(plate: PlateTruth) -> float:
    """Sum of squares of a plate."""
    return float(np.sum(residuals(np.log([value_of(plate, key) for key in CONSTANTS])) ** 2))


def told(found: Statements) -> dict[str, str]:
    """Statement -> value on one plate, in words."""
    printed = np.array(list(PRINTED.values()))
    differences = found.differences
    rises, most = (differences[:8] > 0.0).all(axis=0), differences[8] > 0.0
    within = np.abs(found.masses_kg - printed[:, 0]) <= printed[:, 1]
    alike = np.abs(np.log2(found.sds_kg / printed[:, 1])) <= 1.0
    listed = lambda x, digits: ", ".join(f"{value:.{digits}f}" for value in x)  # noqa: E731
    peaks = {p: [found.peaks_N[p, a].mean() for a in AMPLITUDES] for p in ("sine", "minjerk")}
    return {
        "masses S1, S5, M1, M5 (kg)": f"{listed(found.masses_kg, 2)}: {within.sum()} of 4",
        "fall of the mass (kg)": f"{np.mean(found.masses_kg[1::2] - found.masses_kg[::2]):.2f}",
        "their SDs (kg)": f"{listed(found.sds_kg, 2)}: {alike.sum()} of 4",
        "mean ΔF, sine (N)": listed(peaks["sine"], 0),
        "mean ΔF, minimum jerk (N)": listed(peaks["minjerk"], 0),
        "laboratories in which ΔF rises with amplitude": f"{100.0 * rises.mean():.0f} %",
        "in which it is largest for M5": f"{100.0 * most.mean():.0f} %",
        "both": f"{100.0 * (rises & most).mean():.0f} %",
        "in which it peaks above 0.9 of the peak speed": f"{100.0 * (found.speed > 0.9).mean():.0f} %",
        "lowest correlation with the empty belt at 10 Hz": f"{found.alike:.3f}",
        "ΔF at 0.5 over 0.1 m/s": f"{found.growth:.2f}",
    }


# ---- whole studies -------------------------------------------------------------------------------

# claim, up to its first hyphen between words -> measure in words
CLAIMS = {
    "Estimated mass of the weight, sinusoidal perturbations of 0.1 m/s": "mass, sine of 0.1 m/s",
    "Estimated mass of the weight, sinusoidal perturbations of 0.5 m/s": "mass, sine of 0.5 m/s",
    "Estimated mass of the weight, minimum-jerk perturbations of 0.1 m/s": "mass, minimum jerk of 0.1 m/s",
    "Estimated mass of the weight, minimum-jerk perturbations of 0.5 m/s": "mass, minimum jerk of 0.5 m/s",
    "Standard deviation of the mass, sinusoidal perturbations of 0.1 m/s": "SD of the mass, sine of 0.1 m/s",
    "Standard deviation of the mass, minimum-jerk perturbations of 0.1 m/s": "SD, minimum jerk of 0.1 m/s",
    "Standard deviation of the mass, sinusoidal perturbations of 0.5 m/s": "SD, sine of 0.5 m/s",
    "Standard deviation of the mass, minimum-jerk perturbations of 0.5 m/s": "SD, minimum jerk of 0.5 m/s",
    "The mean of the estimated mass falls with amplitude": "change of the mass with amplitude",
    "The belt-induced force increases with amplitude": "force, lowest ratio to the next lower amplitude",
    "The belt-induced force is largest for minimum jerk of 0.5 m/s": "force of M5 relative to S5",
    "Filtered at 10 Hz, both belt-induced forces are similar in shape": "lowest correlation at 10 Hz",
}
WITHIN = ("implied", "fitted", "predicted", "pattern", "interpretation")
FRAMES = ("bristle-frame", "linear-frame")
CLEAR = ("0.3", "0.4", "0.5", "0.5-8s")  # amplitudes of clear movements (m/s)


def study_rows(results: Path) -> dict[str, list[str]]:
    """Measure -> unit, number of the thesis, and value in one study."""
    names = ("claims", "cells", "treadmill_models", "recovery")
    claims, cells, scores, recovery = (pd.read_csv(results / f"tables/{name}.csv") for name in names)
    rows = {}
    for claim in claims.itertuples():
        name = CLAIMS.get(claim.claim.split(" - ")[0])
        if name:
            sign = {"above": "> ", "below": "< "}.get(claim.tolerance, "")
            unit = "" if claim.unit == "1" else claim.unit
            rows[name] = [unit, f"{sign}{claim.reported:g}", f"{claim.reproduced:.4g}"]
    own = cells[cells.table.isin(["table_4_2", "table_4_3"]) & cells.row.isin(["I", "B", "K"])]
    within = f"{own.verdict.isin(WITHIN).sum()} of {len(own)}"
    rows["I, B and K of Tables 4-2 and 4-3 within their tolerance"] = ["", "", within]
    usual = scores[(scores.cutoff_hz == 20.0) & (scores.train == "empty+weight") & scores.model.isin(FRAMES)]
    for load, word in (("Fy", "force"), ("Mx", "pitch moment")):
        best = usual[usual.load == load].groupby("test").r2.max()
        rows[f"R² of the {word}, best frame, lowest over the loads"] = ["", "", f"{best.min():.4f}"]
    foot = recovery[(recovery.pathway == "foot-compensated") & (recovery.quantity == "K")]
    clear = foot[foot.condition.str.split("-", n=1).str[1].isin(CLEAR)]
    largest = f"{100.0 * clear.relative_error.abs().max():.0f}"
    rows["largest error of K from the foot (compensated), 0.3 m/s and above"] = ["%", "", largest]
    rejected = f"{foot['flags'].fillna('').str.contains('treadmill-').sum()} of {len(foot)}"
    rows["K from the foot rejected by the check of the treadmill model, all amplitudes"] = ["", "", rejected]
    person = recovery[(recovery.experiment == "standing") & recovery.recommended & (recovery.quantity == "K")]
    largest = f"{100.0 * person.relative_error.abs().max():.0f}"
    rows["largest error of K of the standing person over the tasks"] = ["%", "", largest]
    return rows


ORDERED = "laboratories (drawn clocks) in which the force rises with amplitude and is largest for M5"
MISFIT = "misfit to the statements (sum of squares of the fit)"


def kept_plates() -> dict[str, PlateTruth]:
    """Plates of the kept studies."""
    return {"shipped": SHIPPED, "fitted": fitted_plate(), "damped": changed(DAMPED)}


def ordered_percent(plate: PlateTruth) -> float:
    """Share of the drawn clocks with which all differences of forces have the sign of the thesis (%)."""
    return 100.0 * float((statements(plate).differences > 0.0).all(axis=0).mean())


def compared(results: dict[str, Path]) -> str:
    """Table of the measures of several studies, as text: a column for each plate."""
    studies = {plate: study_rows(folder) for plate, folder in results.items()}
    plates = kept_plates().values()
    rows = [
        [MISFIT, "", "", *(f"{squared(plate):.3g}" for plate in plates)],
        [ORDERED, "%", "", *(f"{ordered_percent(plate):.0f}" for plate in plates)],
    ]
    rows += [
        [name, *studies["shipped"][name][:2], *(own[name][-1] for own in studies.values())]
        for name in studies["shipped"]
    ]
    return pd.DataFrame(rows, columns=["measure", "unit", "thesis", *studies]).to_csv(index=False)


def main() -> None:
    """Print constants and statements of the shipped and other plates, or compare whole studies."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1, help="of the starts (1)")
    parser.add_argument("--starts", type=int, default=1, help="of the search (1)")
    parser.add_argument("--studies", type=Path, nargs=3, help="results with shipped, fitted and damped plate")
    arguments = parser.parse_args()
    if arguments.studies:
        plates = ("shipped", "fitted", "damped")
        print(compared(dict(zip(plates, arguments.studies, strict=True))), end="")
        return
    values, misfit = fitted(arguments.seed, arguments.starts)
    plates = {
        "shipped": SHIPPED,
        "found": changed(values),
        "fitted": fitted_plate(),
        "damped": changed(DAMPED),
    }
    squares = {name: squared(plate) for name, plate in plates.items()}
    print(HEAD.format(draws=DRAWS))
    print(f"Search from {arguments.starts} start(s), seed {arguments.seed}: sum of squares {misfit:.3g}.\n")
    print("| Constant | Shipped | Found | Fitted | Damped | Range | Reason for the range |")
    print("|---|---|---|---|---|---|---|")
    for key, own in CONSTANTS.items():
        row = " | ".join(f"{value_of(plate, key):.3g}" for plate in plates.values())
        print(f"| `{key}` | {row} | {own.low:g} to {own.high:g} | {own.reason} |")
    print("\n| Statement | Shipped | Found | Fitted | Damped |\n|---|---|---|---|---|")
    print("| sum of squares | " + " | ".join(f"{x:.3g}" for x in squares.values()) + " |")
    found = [told(statements(plate)) for plate in plates.values()]
    for name in found[0]:
        print(f"| {name} | " + " | ".join(own[name] for own in found) + " |")


if __name__ == "__main__":
    main()
