"""Checks of a person's electromyograms: exchanged channels, and a trigger that is early or late.

A muscle answers its own stretch. With x the band-passed electromyogram of a response without its artefact, t
the time from the onset of the belt, R the span of `REFLEX_S` and Q that of `QUIET_S`, the answer is

    a = mean_R |x| / mean_Q |x| - 1

Answers count as clear if their mean is above `CLEAR` and above 0 by more than chance. A channel is exchanged
if its muscle answers clearly when it is shortened, and

    - less when it is stretched, or
    - is never stretched, while an antagonist, which these pulses stretch, answers less than half of `CLEAR`.

The trigger is wrong if muscles answer clearly before `EARLIEST_S`, in which no reflex can be, or if the first
onset of all muscles is after `LATEST_S`, when only voluntary or balance responses begin.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import scipy

from tepsipe.experiments.standing.epochs import StandingEpochs
from tepsipe.experiments.standing.thesis.latency import MuscleLatency, first_stretch
from tepsipe.identification.consistency import CHANCE, welch
from tepsipe.signals.epochs import without_artefact
from tepsipe.statistics.uncertainty import scatter

# span of a reflex before the belt turns, and span before the onset (s)
REFLEX_S, QUIET_S = (0.025, 0.075), (-0.15, -0.02)
# span in which no reflex can be, its end, and the latest first onset (s)
BEFORE_REFLEX_S, EARLIEST_S, LATEST_S = (0.002, 0.018), 0.02, 0.07
# least mean over greatest speed of pulses that stretch a muscle, or shorten it, and do not do both in turn
ONE_WAY = 0.2
# least clear answer, relative to the activity before the onset, and fewest answers
CLEAR, FEWEST = 0.5, 5
# probability of a clear answer by chance: a size of `CLEAR` is required in addition
BY_CHANCE = 1e-3


def emg_faults(
    trials: Sequence[StandingEpochs],
    lengthened_by: Mapping[str, dict[str, float]],
    latencies: Sequence[MuscleLatency],
    detector: str,
) -> tuple[str, ...]:
    """Faults of the electromyograms of a task, names in `tepsipe.flags.FLAGS`.

    lengthened_by: muscle -> joint -> lengthening per angle.
    latencies: of the muscles with a response.
    detector: the detector whose onsets count.
    """
    stretched, shortened, early = {}, {}, {}
    for muscle, joints in lengthened_by.items():
        answers = {True: [], False: []}
        before = []
        for responses in trials:
            if muscle not in responses.muscles or not responses.count:
                continue
            stretch = first_stretch(responses, joints)
            if abs(stretch) < ONE_WAY:
                continue
            first = stretch > 0.0
            answers[first].append(_answers(responses, muscle, REFLEX_S))
            before += [_answers(responses, muscle, BEFORE_REFLEX_S)] if first else []
        stretched[muscle], shortened[muscle] = (np.concatenate([*answers[k], []]) for k in (True, False))
        early[muscle] = np.concatenate([*before, []])
    found = [
        muscle
        for muscle, own in lengthened_by.items()
        if _exchanged(
            stretched[muscle],
            shortened[muscle],
            [
                stretched[m]
                for m, of in lengthened_by.items()
                if sum(w * of.get(j, 0) for j, w in own.items()) < 0
            ],
        )
    ]
    onsets = [x.onsets[detector].latency_s for x in latencies if detector in x.onsets]
    known = [onset for onset in onsets if onset is not None]
    wrong = any(map(_clear, early.values())) or (bool(known) and min(known) > LATEST_S)
    return ("muscles-exchanged",) * bool(found) + ("emg-trigger",) * wrong


def _answers(responses: StandingEpochs, muscle: str, span_s: tuple[float, float]) -> np.ndarray:
    """Answers of a muscle to the usable pulses of a trial, shape (n,)."""
    column = responses.muscles.index(muscle)
    usable = responses.usable[:, column]
    emg, time = responses.emg[usable][..., column], responses.emg_time
    if len(emg) < 2:
        return np.zeros(0)
    belt = responses.perturbed["belt_velocity"][usable]
    sizes = np.take_along_axis(belt, np.abs(belt).argmax(axis=1)[:, None], axis=1)[:, 0]
    active = np.abs(without_artefact(emg, sizes))
    during, quiet = (active[:, (time >= a) & (time <= b)].mean(axis=1) for a, b in (span_s, QUIET_S))
    return during / max(float(quiet.mean()), 1e-300) - 1.0


def _clear(answers: np.ndarray) -> bool:
    """Test for answers that are large, and above 0 by more than chance."""
    if answers.size < FEWEST or answers.mean() < CLEAR:
        return False
    error, freedom = scatter(answers)
    return bool(scipy.special.stdtr(freedom, -answers.mean() / max(float(error), 1e-300)) < BY_CHANCE)


def _exchanged(stretched: np.ndarray, shortened: np.ndarray, antagonists: Sequence[np.ndarray]) -> bool:
    """Test for a muscle that answers when it is shortened, and not when it is stretched.

    antagonists: answers of every antagonist to its own stretch.
    """
    if not _clear(shortened):
        return False
    if stretched.size >= FEWEST:
        means = np.array([shortened.mean()]), np.array([stretched.mean()])
        p, _ = welch(*means, scatter(shortened[:, None]), scatter(stretched[:, None]))
        return bool(means[0] > means[1] and p[0] < CHANCE)
    return any(x.size >= FEWEST and x.mean() < 0.5 * CLEAR for x in antagonists)
