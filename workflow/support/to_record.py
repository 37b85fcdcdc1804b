"""What is still to be recorded or measured for K of a standing person, by the recordings of a study.

docs/guideline.md explains each item in the same words. Faults of recordings are questions to be confirmed.
Simulated trials are not looked at.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from tepsipe.errors import listed
from tepsipe.io.estimates import FLAGS
from tepsipe.io.trial import Trial, recorded_faults
from tepsipe.treadmill.plate_check import calibration_difference, calibration_fault, calibration_of
from tepsipe.treadmill.recording import BeltRecording
from workflow.support.people import BELTS
from workflow.support.study import Study

QUIET_S = 60.0
PAGE = "docs/guideline.md"
ENOUGH_KG = 20.0  # of the lightest weight
LONGEST_S = 0.3  # of a pulse
MOST_BYTES = 500_000_000  # of signals that are kept


@dataclass
class Read:
    """What the recordings of a study show."""

    plates: dict[tuple[str, str], BeltRecording] = field(default_factory=dict)
    """Trials of a weight or the empty belt -> their fore-aft load (N)."""
    trials: dict[tuple[str, str], Trial] = field(default_factory=dict)
    """All trials but walks, with their signals as long as these are few; all with their attributes."""
    signals_bytes: int = 0
    """Size of the signals."""
    quiet_s: dict[str | None, float] = field(default_factory=dict)
    """Participant -> unperturbed time in all trials of standing (s)."""

    def add(self, name: tuple[str, str], trial: Trial) -> None:
        """Add a trial, whose signals need not be read again if there is room for them."""
        size = sum(signal.values.nbytes for signal in trial.signals.values())
        if self.signals_bytes + size <= MOST_BYTES:
            self.signals_bytes += size
        else:
            trial = replace(trial, axes={}, signals={})
        self.trials[name] = trial


def faults_of(read: Read) -> list[str]:
    """One question for each fault of a recording, and for each other calibration of a force plate."""
    asked = [
        f"{'/'.join(trial)}: {FLAGS[fault]} ({fault})"
        for trial, found in read.trials.items()
        for fault in recorded_faults(found)
    ]
    for belt in BELTS:
        known = {name: calibration_of(trial, belt) for name, trial in read.trials.items()}
        known = {name: matrix for name, matrix in known.items() if matrix is not None}
        # weights and the empty belt calibrate the others
        usual = min(known, key=lambda name: name[0] not in ("weight", "empty"), default=None)
        by_difference: dict[str, list[str]] = {}
        for name, matrix in known.items():
            if flag := calibration_fault(known[usual], matrix):
                difference = f"{calibration_difference(known[usual], matrix)} ({flag[0]})"
                by_difference.setdefault(difference, []).append("/".join(name))
        asked += [
            f"{listed(names, 4)}: the force plate of the {belt} belt has another calibration than in "
            f"{'/'.join(usual)}: {difference}"
            for difference, names in by_difference.items()
        ]
    return asked


def to_record(study: Study, read: Read) -> list[str]:
    """One sentence for each plate, person and number that a standing person still needs.

    read: from recordings that can all be used.
    """
    standing = [c for c in study.conditions("standing") if study.trials["standing", c].source == "recorded"]
    if not standing:
        return []
    said = []
    used = {study.treadmill.belt_of("standing", c) for c in standing}
    for belt in BELTS if "both" in used else sorted(used):
        trials = [(e, c) for e, c, _ in study.treadmill.plate_trials(belt)]
        if all(trial in read.plates for trial in trials):
            lacks = lacking_on_plate([read.plates[trial] for trial in trials])
            said += [f"{belt} plate: {', '.join(lacks)} ({PAGE})"] if lacks else []
    for who, quiet_s in read.quiet_s.items():
        if quiet_s < QUIET_S:
            said.append(
                f"{who or 'the person'}: a minute of quiet standing, found {quiet_s:.0f} s without pulses in "
                f"all trials ({PAGE})"
            )
    weights = [study.settings["weight"]["weight"], *study.settings["weight"]["further_weights"]]
    if any(e == "weight" for e, _ in read.plates):
        said += [
            f"weight of {weight['mass_kg']:g} kg: com_forward_of_markers_m to 1 mm ({PAGE})"
            for weight in weights
            if weight["com_forward_of_markers_m"] is None
        ]
    return said


def lacking_on_plate(recordings: list[BeltRecording]) -> list[str]:
    """Trials that the calibration of a plate lacks: the empty belt, a weight, pulses of both directions."""
    by_load: dict[float, set[bool]] = {}
    for recording in recordings:
        by_load.setdefault(recording.carried_kg, set()).update(directions_of(recording))
    lacks = [] if 0.0 in by_load else ["the empty belt"]
    lacks += [] if any(by_load) else [f"a weight ({ENOUGH_KG:g} kg is enough)"]
    for kg, directions in sorted(by_load.items()):
        if len(directions) == 1:
            load = f"under the weight of {kg:g} kg" if kg else "on the empty belt"
            lacks.append(f"pulses {'backward' if True in directions else 'forward'} {load}")
    return lacks


def directions_of(recording: BeltRecording) -> set[bool]:
    """Directions in which pulses move the belt farthest: true for forward."""
    found, rest = set(), float(np.median(recording.velocity))
    for onset in recording.onsets:
        path = np.cumsum(recording.velocity[onset : onset + round(LONGEST_S * recording.rate_hz)] - rest)
        found.add(bool(path[np.argmax(np.abs(path))] > 0.0))
    return found
