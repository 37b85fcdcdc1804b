"""Samples in SI units, from arrays or from signals that name their unit.

Every public function reads its arguments here; a wrong unit, shape or sample raises one sentence.
"""

import math
from collections.abc import Sequence

import numpy as np

from tepsipe.errors import InputError, quoted

# conversion of units: (from, to) -> factor
FACTORS = {
    ("ms", "s"): 1e-3,
    ("us", "s"): 1e-6,
    ("mm", "m"): 1e-3,
    ("cm", "m"): 1e-2,
    ("mm/s", "m/s"): 1e-3,
    ("cm/s", "m/s"): 1e-2,
    ("km/h", "m/s"): 1.0 / 3.6,
    ("deg", "rad"): math.pi / 180.0,
    ("mrad", "rad"): 1e-3,
    ("deg/s", "rad/s"): math.pi / 180.0,
    ("Nmm", "Nm"): 1e-3,
    ("mNm", "Nm"): 1e-3,
    ("kNm", "Nm"): 1e3,
    ("mN", "N"): 1e-3,
    ("kN", "N"): 1e3,
    ("mV", "V"): 1e-3,
    ("uV", "V"): 1e-6,
}
SPELLINGS = {
    "N m": "Nm",
    "N*m": "Nm",
    "N·m": "Nm",
    "N mm": "Nmm",
    "N·mm": "Nmm",
    "degree": "deg",
    "degrees": "deg",
    "°": "deg",
    "radian": "rad",
    "radians": "rad",
    "sec": "s",
    "seconds": "s",
    "m s-1": "m/s",
    "m·s-1": "m/s",
    "µV": "uV",
}


def factor(unit: str, wanted: str, name: str) -> float:
    """Factor that converts samples from ``unit`` to ``wanted`` (unit of ``wanted`` over ``unit``).

    Parameters
    ----------
    unit, wanted : str
        Given unit, and the unit to convert to.
    name : str
        Names the signal in messages.

    Returns
    -------
    float
        The factor (unit of ``wanted`` over ``unit``).

    Raises
    ------
    InputError
        If the units are of different quantities or unknown.
    """
    unit = unit.strip()
    unit = SPELLINGS.get(unit, unit)
    if unit == wanted:
        return 1.0
    if (unit, wanted) in FACTORS:
        return FACTORS[unit, wanted]
    if (wanted, unit) in FACTORS:
        return 1.0 / FACTORS[wanted, unit]
    known = sorted({wanted, *(a for a, b in FACTORS if b == wanted)})
    raise InputError(
        f"{name}: expected a unit of {', '.join(known)}, found {quoted(unit)}: convert the signal, or "
        "correct its unit"
    )


def samples(
    values: object,
    unit: str,
    name: str,
    *,
    shape: Sequence[int | None] = (None,),
) -> np.ndarray:
    """Samples as floating-point numbers in ``unit``.

    Parameters
    ----------
    values : array_like or Signal
        Samples in ``unit``; an object with the attributes ``values`` and ``unit`` is converted.
    unit : str
        Required unit.
    name : str
        Names the argument in messages.
    shape : sequence of int or None
        Required shape, None for any length.

    Returns
    -------
    ndarray
        The samples (``unit``).

    Raises
    ------
    InputError
        If they are not numbers, have another shape, another quantity's unit, or a sample is missing.
    """
    scale = 1.0
    if hasattr(values, "unit") and hasattr(values, "values"):
        scale = factor(str(values.unit), unit, name)
        values = values.values
    try:
        x = np.asarray(values)
        if x.dtype.kind not in "fiub":
            raise TypeError(f"{x.dtype} is no real number")
        x = x.astype(float)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{name}: expected an array of numbers, found {quoted(str(error))}: correct it"
        ) from error
    if len(x.shape) != len(shape) or any(
        wanted not in (None, n) for wanted, n in zip(shape, x.shape, strict=True)
    ):
        wanted_shape = ", ".join("n" if n is None else str(n) for n in shape)
        raise InputError(
            f"{name}: expected an array of shape ({wanted_shape}), found {tuple(map(int, x.shape))}: "
            "select or transpose its axes"
        )
    if not x.size:
        raise InputError(f"{name}: expected samples, found an empty array: check what was read")
    bad = int(np.count_nonzero(~np.isfinite(x)))
    if bad:
        first = int(np.argmax(~np.isfinite(x).reshape(x.shape[0], -1).all(axis=1)))
        raise InputError(
            f"{name}: expected a number for every sample, found {bad} of {x.size} missing or infinite, the "
            f"first at sample {first}: fill or cut the gaps first"
        )
    return scale * x


def regular_rate(time: object, name: str = "time") -> tuple[np.ndarray, float]:
    """Instants on a regular clock, and their rate.

    Parameters
    ----------
    time : array_like or Signal, shape (n,)
        Instants (s).
    name : str
        Names the argument in messages.

    Returns
    -------
    time : ndarray, shape (n,)
        The instants (s).
    rate_hz : float
        Sampling rate (Hz).

    Raises
    ------
    InputError
        If there are fewer than 8 instants, they do not increase, or their steps differ by more than 1 %.
    """
    t = samples(time, "s", name)
    if t.size < 8:
        raise InputError(f"{name}: expected at least 8 instants, found {t.size}: record longer")
    step = np.diff(t)
    mean = float((t[-1] - t[0]) / (t.size - 1))
    if not mean > 0.0 or not (step > 0.0).all():
        at = int(np.argmax(step <= 0.0))
        raise InputError(
            f"{name}: expected instants that increase, found {t[at + 1]:.6g} s after {t[at]:.6g} s: sort the "
            "samples, and drop repeated ones"
        )
    worst = int(np.argmax(np.abs(step - mean)))
    if abs(step[worst] - mean) > 0.01 * mean:
        raise InputError(
            f"{name}: expected a regular clock, found steps of {step[worst]:.6g} s and {mean:.6g} s on "
            "average: resample all signals to a regular clock first"
        )
    return t, float(f"{1.0 / mean:.12g}")  # 250 Hz, not 250.00000000000003 Hz


def same_length(time: np.ndarray, **signals: np.ndarray) -> None:
    """Refuse signals that have not one sample per instant (s); the names of the arguments name them.

    Raises
    ------
    InputError
        If a signal is longer or shorter than ``time``.
    """
    for name, x in signals.items():
        if x.shape[0] != time.size:
            raise InputError(
                f"{name}: expected {time.size} samples, as many as instants, found {x.shape[0]}: cut or "
                "resample one of the two"
            )


def plausible_angle(angle: np.ndarray) -> np.ndarray:
    """The angle (rad), shape (n,), refused where it looks like degrees.

    Raises
    ------
    InputError
        If it leaves two turns.
    """
    largest = float(np.abs(angle).max())
    if largest > 4.0 * math.pi:
        raise InputError(
            f"angle: expected radians, found {largest:.3g}, which looks like degrees: give "
            'Signal(angle, "deg")'
        )
    return angle
