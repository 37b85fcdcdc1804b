"""Simulated recordings with their truth, to try the functions on: they are installed with the library."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, overload

import numpy as np

from tepsipe.errors import InputError, nearest, quoted
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.signals.perturbations import Perturbation, find_perturbations

if TYPE_CHECKING:
    import pandas as pd

# simulated by tepsipe.virtual_lab.example_recordings
FOLDER = Path(__file__).parent / "example_data"
EXAMPLES = ("dummy", "ankle", "manipulator")


@dataclass(frozen=True, eq=False)
class Example:
    """A simulated recording of a joint, with the true values of what is estimated from it.

    Attributes
    ----------
    name : str
        Its name in `load_example`.
    description : str
        What was simulated, in a sentence or two.
    time : ndarray, shape (n,)
        Instants (s).
    angle, torque : ndarray, shape (n,)
        theta (rad) and tau (N·m), positive when it resists a positive angle; with noise, not filtered. In
        the manipulator, the torque that drives the joint.
    truth : mapping of str to float
        Name of a quantity, as in ``fit.quantities`` -> its true value: ``I`` (N·m·s²/rad), ``B``
        (N·m·s/rad), ``K`` (N·m/rad), and others of some examples.
    period_s : float or None
        Period of the perturbation (s), None where it is not periodic.
    """

    name: str
    description: str
    time: np.ndarray
    angle: np.ndarray
    torque: np.ndarray
    truth: Mapping[str, float]
    period_s: float | None

    @property
    def script(self) -> str:
        """Command that simulates all examples again, into a folder."""
        return "python -m tepsipe.virtual_lab.example_recordings FOLDER"

    def to_frame(self) -> "pd.DataFrame":
        """The signals as a pandas table for ``tepsipe fit``: units are in the names of the columns."""
        import pandas as pd

        return pd.DataFrame({"time_s": self.time, "angle_rad": self.angle, "torque_Nm": self.torque})

    def __repr__(self) -> str:
        truth = ", ".join(f"{name} = {value:g}" for name, value in self.truth.items())
        return f"<{type(self).__name__} {self.name!r}: {self.time.size} samples, truth {truth}>"


@dataclass(frozen=True, eq=False, repr=False)
class LegExample(Example):
    """A simulated recording of a leg on a moving belt."""

    belt_velocity: Annotated[np.ndarray, "(n,)", "m/s"]
    """Logged velocity of the belt."""
    perturbations: list[Perturbation]
    """The pulses of the belt, found by `find_perturbations` (samples)."""
    positions: Annotated[np.ndarray, "(n, markers, 2)"]
    """Marker positions y, z (m): y along the belt, z up; with noise, not filtered."""
    labels: tuple[str, ...]
    belt_fixed: tuple[str, ...]
    """Names of all markers, and of those that move with the foot."""
    markers: SegmentMarkers
    """Markers on the leg, and their places (m)."""
    leg: Leg
    """The leg (kg, m, kg·m²)."""

    def to_frame(self) -> "pd.DataFrame":
        """The signals as a pandas table, the belt velocity among them (units in the names of the columns)."""
        return super().to_frame().assign(belt_velocity_m_per_s=self.belt_velocity)


@overload
def load_example(name: Literal["dummy"] = "dummy") -> LegExample: ...
@overload
def load_example(name: Literal["ankle", "manipulator"]) -> Example: ...
@overload
def load_example(name: str) -> Example: ...
def load_example(name: str = "dummy") -> Example:
    """A simulated recording with its truth.

    ``dummy`` is a leg on an elastic joint, on a belt that is pulsed (`fit_impedance`,
    `fit_joint_likelihood`, `fit_output_error`). ``ankle`` is a human ankle with a stretch reflex under
    random movement (`fit_parallel_cascade`). ``manipulator`` is a joint under a periodic torque
    (`frequency_response`, `fit_admittance`). All joints are linear.

    Parameters
    ----------
    name : {"dummy", "ankle", "manipulator"}
        Name of the recording.

    Returns
    -------
    Example
        Time (s), angle (rad), torque (N·m) and truth; of the dummy a `LegExample`, with the belt velocity
        (m/s), perturbations, markers (m) and leg, too.

    Raises
    ------
    InputError
        If there is no such example.

    Examples
    --------
    >>> from tepsipe import load_example
    >>> load_example("dummy")
    <LegExample 'dummy': 15500 samples, truth I = 0.02, B = 0.15, K = 10>
    >>> load_example("manipulator").period_s
    10.0
    """
    if not isinstance(name, str) or name not in EXAMPLES:
        raise InputError(
            f"load_example: expected the name of an example, found {quoted(name)}: {nearest(name, EXAMPLES)}"
        )
    with np.load(FOLDER / f"{name}.npz") as file:
        facts: dict[str, Any] = json.loads(str(file["facts"]))
        signals = {key: step * file[key] for key, step in facts["resolution"].items()}
    time = np.arange(signals["angle_rad"].size) / facts["rate_hz"]
    common = {
        "name": name,
        "description": facts["description"],
        "time": time,
        "angle": signals["angle_rad"],
        "torque": signals["torque_Nm"],
        "truth": facts["truth"],
        "period_s": facts.get("period_s"),
    }
    if name != "dummy":
        return Example(**common)
    belt_velocity, layout = signals["belt_velocity_m_per_s"], facts["layout_m"]
    return LegExample(
        **common,
        belt_velocity=belt_velocity,
        perturbations=find_perturbations(time, belt_velocity),
        positions=np.moveaxis(signals["positions_m"], -1, 0).copy(),
        labels=tuple(facts["labels"]),
        belt_fixed=tuple(facts["belt_fixed"]),
        markers=SegmentMarkers(tuple(layout), np.array(list(layout.values()))),
        leg=Leg(**facts["leg"]),
    )
