"""The force on the belt, from the laboratory's transducers back through the analysis."""

import numpy as np
import pytest

from tepsipe.io.trial import Signal, Trial
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.treadmill.bristle_fit import fit_bristle_frame
from tepsipe.treadmill.compensation import compensated_loads
from tepsipe.treadmill.prepared import prepare_trial
from tepsipe.treadmill.registry import FittedModel
from tepsipe.treadmill.trial_recordings import (
    PlateOptions,
    Weight,
    plate_recordings,
    recordings_of_loads,
    zeroed_per_pulse,
)
from tepsipe.virtual_lab.belt import DriveTruth, velocity_command
from tepsipe.virtual_lab.force_plate import Loaded, PlateTruth, plate_electronics, voltages_of_belts
from tepsipe.virtual_lab.person import move_person
from tepsipe.virtual_lab.person_constants import (
    MUSCLES,
    MuscleTruth,
    NervesTruth,
    PersonTruth,
    Subject,
    TaskTruth,
)
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.weight_trial import WeightTruth, move_weight

RATE_HZ, EVERY = 2000.0, 8  # of the laboratory, and its steps per sample of the analysis
SECONDS, ONSETS_S = 13.0, np.array([2.5, 5.0, 7.5])
WINDOW = WindowOptions(2.0, 2.0, 0.3, 0.05, 5.0, 0.06)
LOWPASS = Lowpass(20.0, 4, True)
OPTIONS = PlateOptions("right", LOWPASS, LOWPASS, WINDOW, 0.3)
LOADS = {"Fy": 1, "Mx": 3}
UNITS = {"Fy": "N", "Mx": "Nm"}


class Laboratory:
    """Trials of the shipped treadmill without noise, on a frame of one mode, with friction without memory."""

    def __init__(self, truth, hz):
        self.truth = truth
        own = {"resonance_hz": hz, "second_share": [0.0, 0.0], "bristle_share": 0.0}
        own |= dict.fromkeys(("floor_m_per_s2", "belt_lag_wander", "noise_V", "drift_V_per_s"), 0.0)
        self.plate = PlateTruth(**truth["treadmill"]["plate"] | own)
        self.drive = DriveTruth(**truth["treadmill"]["drive"])
        self.electronics = plate_electronics(self.plate, generator(1, "plate"))

    def trial(self, name, move, peak, profile="sine"):
        """Trial of what ``move`` puts on the belt, and the motion behind it."""
        command = velocity_command(profile, peak, ONSETS_S, 0.1)
        rng = generator(1, name, str(peak))
        motion = move(command, [(self.plate, 1.0)])
        volts, matrix = self.electronics
        sample = np.arange(0, motion.time.size, EVERY)
        wrench = voltages_of_belts({"right": Loaded(self.plate, motion)}, volts, sample, rng) @ matrix.T
        wrench = wrench.reshape(sample.size, 2, 6)
        rate = RATE_HZ / EVERY
        signals = {
            "belt_velocity": Signal(motion.belt_velocity[sample], "m/s", ("time",), "measured"),
            "force": Signal(wrench[..., :3], "N", ("time", "belt", "axis"), "measured"),
            "moment": Signal(wrench[..., 3:], "Nm", ("time", "belt", "axis"), "measured"),
        }
        axes = {"time": np.arange(sample.size) / rate, "belt": np.array(["left", "right"])}
        return Trial(rate, axes, signals), motion

    def weight(self, kg):
        """Motion of the empty belt or a weight by command and plate."""
        weight = WeightTruth(kg, 0.2, 0.2, 0.2, 0.1, 0.25, 0.02, 9.81) if kg else None
        return lambda command, below: move_weight(weight, self.drive, command, SECONDS, RATE_HZ, below)

    def person(self, command, below):
        """Motion of the shipped person, relaxed."""
        standing = self.truth["standing"]
        subject = Subject(
            PersonTruth(**standing["person"]),
            {name: MuscleTruth(**standing["muscles"][name]) for name in MUSCLES},
            TaskTruth(**standing["tasks"]["relax"]),
            NervesTruth(**standing["nerves"]),
        )
        return move_person(subject, self.drive, command, SECONDS, RATE_HZ, generator(1, "p"), below)

    def models(self):
        """Model of the treadmill from the empty belt and two weights, in pulses of both directions."""
        trials = []
        for kg in (0.0, 20.0, 60.0):
            weight = Weight(mass_kg=kg, com_height_m=0.1, gravity_m_per_s2=9.81) if kg else None
            for peak, profile in ((0.3, "sine"), (0.5, "negative-sine")):
                trial, _ = self.trial(f"{kg:g} kg", self.weight(kg), peak, profile)
                found = plate_recordings(trial, f"{kg:g} kg {peak:g}", "sine", OPTIONS, weight)
                trials.append({load: zeroed_per_pulse(recording) for load, recording in found.items()})
        joint = fit_bristle_frame(trials, 30, np.random.default_rng(1))
        return {
            load: FittedModel("bristle-frame", joint.models[load], UNITS[load], LOWPASS, (), joint.deviations)
            for load in LOADS
        }


@pytest.mark.slow
@pytest.mark.parametrize("hz", [30.0, 50.0, 90.0])
def test_force_is_recovered_under_nothing_a_weight_and_a_person(hz, shipped_truth):
    """The analysis is told nothing of the load but how heavily it presses on the belt."""
    laboratory = Laboratory(shipped_truth, hz)
    models = laboratory.models()
    for name, move, kg in (
        ("empty", laboratory.weight(0.0), 0.0),
        ("weight", laboratory.weight(40.0), 40.0),
        ("person", laboratory.person, 64.0),
    ):
        trial, motion = laboratory.trial(name, move, 0.4)
        prepared = prepare_trial(trial, name, LOWPASS, WINDOW)
        measured = prepared.load_from_rest("right")
        recordings = recordings_of_loads(prepared, {load: measured[load] for load in LOADS}, kg)
        found = compensated_loads(models, recordings)
        for load, column in LOADS.items():
            missed = found[load] - LOWPASS(motion.reaction[::EVERY, column], prepared.rate_hz)
            for onset in recordings[load].onsets:
                before, pulse = slice(onset - 60, onset - 10), slice(onset - 10, onset + 60)
                error, whole = (x[pulse] - x[before].mean() for x in (missed, measured[load]))
                assert np.abs(error).max() < 0.05 * np.abs(whole).max(), (name, load)
