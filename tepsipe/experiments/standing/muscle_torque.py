"""Registry of the models of the delayed torque of a standing person's muscles, tau_active.

    none       tau_active = 0: B and K then include the effect of reflexes in the window
    velocity   tau_active = h * [ G_+ [phi'(t - L)]_+  -  G_- [-phi'(t - L)]_+  +  P phi(t - D)
                               +  Q phi'(t - D) ]
    emg        tau_active = h * sum_m F_m e_m(t)
    free       tau_active of unknown shape: `tepsipe.experiments.standing.free_reflex.fit`

with the delays L of the reflex and D of balance (s), gains G, P, Q, rectified electromyogram e_m (uV), torque
per drive F_m >= 0 (N·m/uV), with the sign of the muscle's action at the ankle, and twitch response h,
critically damped and of second order with time constant T (s) (Milner-Brown, Stein & Yemm 1973):

    T^2 x'' + 2 T x' + x = u

An estimator of the study is a window, with or without inertia, and one of these models. To add a model, write
a function that returns its regressors, and enter it in `ACTIVE`.
"""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Annotated, Self

import numpy as np
import scipy

from tepsipe.identification.cascade.pathways import delayed
from tepsipe.quantities import Different, Latency

NONE, VELOCITY, EMG, FREE = "none", "velocity", "emg", "free"
# time by which a zero-lag low-pass of about 20 Hz advances the start of a response (s)
FILTER_WIDTH_S = 0.03


@dataclass(frozen=True)
class ActiveOptions:
    """Values that are tried for the torque of the muscles."""

    twitch_s: Different[Latency]
    """Time constants of the twitch response that are tried."""
    reflex_delay_s: Different[Latency]
    """Delays of the reflex that are tried."""
    balance_delay_s: Different[Latency]
    """Delays of balance that are tried."""
    action: Mapping[str, float]
    """Muscle -> 1 if it resists tipping forward, -1 if it resists tipping backward; others do not act at the
    ankle."""

    @classmethod
    def from_settings(cls, active: dict, muscles: dict[str, dict]) -> Self:
        """Values that are tried (s), and muscle -> settings with its ``ankle_action``, which may be 0."""
        actions = {muscle: choice["ankle_action"] for muscle, choice in muscles.items()}
        action = {muscle: float(acts) for muscle, acts in actions.items() if acts}
        return cls(**active, action=action)

    @property
    def tried(self) -> dict[str, tuple[float, ...]]:
        """Delay -> values that are tried (s)."""
        return {"T": self.twitch_s, "L": self.reflex_delay_s, "D": self.balance_delay_s}


@dataclass(frozen=True)
class MeanResponses:
    """Mean responses of one trial relative to unperturbed standing, per resampling."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    """From the onset."""
    signals: dict[str, np.ndarray]
    drive: dict[str, np.ndarray]
    """Motion (rad) and torque (N·m), and rectified electromyograms by muscle (uV), shape (1 + draws, n)."""

    def of(self, rows: slice) -> "MeanResponses":
        """A selection of the resamplings."""
        return MeanResponses(
            self.time,
            {key: x[rows] for key, x in self.signals.items()},
            {key: x[rows] for key, x in self.drive.items()},
        )

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Responses of several trials at the same times, below one another."""
        first = parts[0]
        return cls(
            first.time,
            {key: np.concatenate([part.signals[key] for part in parts]) for key in first.signals},
            {key: np.concatenate([part.drive[key] for part in parts]) for key in first.drive},
        )

    @cached_property
    def _known(self) -> dict[Hashable, np.ndarray]:
        return {}

    def once(self, key: Hashable, compute: Callable[[], np.ndarray]) -> np.ndarray:
        """Result of ``compute``, cached for these responses and a key that names its other inputs.

        Of the delays that are tried, a regressor depends on some only.
        """
        if key not in self._known:
            self._known[key] = compute()
        return self._known[key]


@dataclass(frozen=True)
class MuscleTorque:
    """A model of the delayed torque of the muscles."""

    meaning: str
    """Description in a few words."""
    regressors: Callable[..., list[np.ndarray]] | None = None
    """From mean responses, delays (s), options and muscles to arrays of shape (1 + draws, n); None if the
    torque is not fitted by least squares."""
    delays: tuple[str, ...] = ()
    """Those of T, L and D that it needs."""
    gains: tuple[str, ...] = ()
    """Names of the gains, one per regressor."""
    by_muscle: bool = False
    """True for a non-negative gain F_m of every muscle with an electromyogram, because muscles only pull."""

    @property
    def separates(self) -> bool:
        """True if least squares separate the torque of the muscles from the intrinsic one."""
        return bool(self.gains) or self.by_muscle

    def grid(self, options: ActiveOptions) -> list[dict[str, float]]:
        """All combinations of the delays that are tried (s)."""
        values = product(*(options.tried[name] for name in self.delays))
        return [dict(zip(self.delays, combination, strict=True)) for combination in values]

    def gain_names(self, muscles: tuple[str, ...]) -> tuple[str, ...]:
        """Names of the gains with these muscles (N·m/uV for each muscle's gain)."""
        return tuple(f"F_{muscle}" for muscle in muscles) if self.by_muscle else self.gains


def twitch(
    u: Annotated[np.ndarray, "(..., n)"], step_s: float, twitch_s: float
) -> Annotated[np.ndarray, "(..., n)"]:
    """Twitch response of muscles at rest at first, T^2 x'' + 2 T x' + x = u, along the last axis (unit of u).

    u: Drive.
    step_s, twitch_s: sampling interval and T.
    Returns: x (unit of ``u``), by the bilinear rule.
    """
    ratio = 2.0 * twitch_s / step_s
    denominator = np.array([(1.0 + ratio) ** 2, 2.0 * (1.0 - ratio**2), (1.0 - ratio) ** 2])
    return scipy.signal.lfilter(
        np.array([1.0, 2.0, 1.0]) / denominator[0], denominator / denominator[0], u, axis=-1
    )


def _answered(means: MeanResponses) -> np.ndarray:
    """Samples that can be a response: from the onset on, extended by the width of the filter."""
    return means.time >= -FILTER_WIDTH_S


def _none(
    means: MeanResponses, delays: dict[str, float], options: ActiveOptions, muscles: tuple[str, ...]
) -> list[np.ndarray]:
    return []


def _velocity(
    means: MeanResponses, delays: dict[str, float], options: ActiveOptions, muscles: tuple[str, ...]
) -> list[np.ndarray]:
    step, answered = float(means.time[1] - means.time[0]), _answered(means)
    twitch_s, reflex_s, balance_s = (delays[key] for key in ("T", "L", "D"))

    def late(key: str, delay_s: float) -> np.ndarray:
        return delayed((means.signals[key] * answered).T, delay_s, 1.0 / step).T

    def reflex(rectify: Callable) -> np.ndarray:
        def compute():
            return twitch(rectify(late("ankle_d", reflex_s), 0.0), step, twitch_s)

        return means.once((rectify, reflex_s, twitch_s), compute)

    def balance(key: str) -> np.ndarray:
        return means.once((key, balance_s, twitch_s), lambda: twitch(late(key, balance_s), step, twitch_s))

    return [reflex(np.maximum), reflex(np.minimum), balance("ankle"), balance("ankle_d")]


def _emg(
    means: MeanResponses, delays: dict[str, float], options: ActiveOptions, muscles: tuple[str, ...]
) -> list[np.ndarray]:
    step, answered = float(means.time[1] - means.time[0]), _answered(means)
    drive = {muscle: means.drive[muscle] * answered for muscle in muscles}
    return [options.action[muscle] * twitch(drive[muscle], step, delays["T"]) for muscle in muscles]


ACTIVE = {
    NONE: MuscleTorque("no active torque: valid only in a pre-reflex window", _none),
    VELOCITY: MuscleTorque(
        "delayed velocity, rectified in each direction, and delayed angle and velocity for balance, with a "
        "twitch response",
        _velocity,
        delays=("T", "L", "D"),
        gains=("G_plus", "G_minus", "P", "Q"),
    ),
    EMG: MuscleTorque(
        "rectified electromyograms of the ankle muscles, with a twitch response, each with a non-negative "
        "gain",
        _emg,
        delays=("T",),
        by_muscle=True,
    ),
    FREE: MuscleTorque(
        "reflex torque of any smooth shape from its earliest instant on, by generalised least squares"
    ),
}
