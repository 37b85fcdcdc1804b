"""Result of every estimator of impedance: I, B, K, their intervals, and the VAF of the prediction."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.quantities import unit_symbol
from tepsipe.signals.notebook_display import as_html, new_axes
from tepsipe.statistics.bootstrap import expanded_tail
from tepsipe.statistics.uncertainty import CONFIDENCE, SCATTER, Budget

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Quantity:
    """One estimated number."""

    value: float
    """The estimate (``unit``)."""
    unit: str
    standard_error: float = np.nan
    """Its standard error (``unit``); NaN where there is none."""
    low: float = np.nan
    high: float = np.nan
    """Ends of its interval (``unit``); NaN where there is none."""
    u_type_a: float | None = None
    u_type_b: float | None = None
    """Standard uncertainties from the scatter and from everything else (``unit``); None where they were not
    evaluated."""
    parts: Mapping[str, float] = field(default_factory=dict)
    """Source -> its standard uncertainty (``unit``), `SCATTER` for Type A; empty without a budget."""
    as_printed: float | None = None
    """Standard error by thesis eq (3-2) as printed (``unit``); None where there is none."""
    flags: tuple[str, ...] = ()
    """Checks that the number failed (`tepsipe.flags.FLAGS`)."""
    refusal: str = ""
    """Sentence that says why the record does not determine the number; empty where it does."""

    @property
    def identified(self) -> bool:
        """True if there is a number."""
        return not self.refusal

    @classmethod
    def refused(cls, unit: str, refusal: str) -> "Quantity":
        """A quantity without a number (``unit``)."""
        return cls(np.nan, unit, refusal=refusal)

    @classmethod
    def drawn(
        cls, value: float, unit: str, draws: np.ndarray, confidence: float, blocks: int | None = None
    ) -> "Quantity":
        """An estimate with the spread and the quantiles of bootstrapped ones (``unit``), shape (draws,).

        With the number of blocks from which they are drawn, the quantiles are expanded (`expanded_tail`).
        Draws without a value are left out; without any other there is no interval.
        """
        draws = draws[np.isfinite(draws)]
        tail = expanded_tail(confidence, blocks) if blocks else 50.0 * (1.0 - confidence)
        low, high = np.percentile(draws, [tail, 100.0 - tail]) if draws.size else (np.nan, np.nan)
        spread = float(draws.std(ddof=1)) if draws.size > 1 else np.nan
        return cls(float(value), unit, spread, float(low), float(high), spread)

    @classmethod
    def scaled(
        cls, value: float, unit: str, draws: np.ndarray, confidence: float, error: float, freedom: float
    ) -> "Quantity":
        """An estimate with a standard error (``unit``) and the shape of bootstrapped estimates (``unit``).

        The deviations of the draws, shape (draws,), are scaled to the standard error. Ends of the interval
        are their quantiles where Student's distribution of these degrees of freedom has its own.
        """
        deviations = (draws - draws.mean()) * (error / max(float(draws.std()), 1e-300))
        tail = expanded_tail(confidence, freedom + 1.0)
        low, high = np.percentile(deviations, [tail, 100.0 - tail]) * np.sqrt(freedom / (freedom + 1.0))
        return cls(float(value), unit, float(error), float(value + low), float(value + high))

    def times(self, factor: float, unit: str) -> "Quantity":
        """The quantity times a positive constant, in another unit."""
        others = ("unit", "parts", "flags", "refusal")
        numbers = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in others}
        parts = {source: factor * u for source, u in self.parts.items()}
        numbers = {k: None if x is None else factor * x for k, x in numbers.items()}
        return replace(self, unit=unit, parts=parts, **numbers)

    def cells(self) -> tuple[str, str, str]:
        """Value, standard error and interval as text (``unit``), rounded by the standard error."""
        if self.refusal:
            return "undetermined", "–", "–"
        error = self.standard_error if np.isfinite(self.standard_error) else None
        interval = "–"
        if np.isfinite([self.low, self.high]).all():
            interval = f"[{_digits(self.low, error)}, {_digits(self.high, error)}]"
        return _digits(self.value, error), "–" if error is None else _digits(error, error), interval

    def __str__(self) -> str:
        value, _, interval = self.cells()
        unit = "" if self.refusal else self.unit
        return " ".join(part for part in (value, interval.strip("–"), unit) if part)

    def __repr__(self) -> str:
        return f"<{self}>"


@dataclass(frozen=True)
class Curve:
    """A measured and a predicted signal, for `ImpedanceFit.plot`."""

    x: np.ndarray
    """Instants (s) or frequencies (Hz)."""
    measured: np.ndarray
    predicted: np.ndarray
    """The signals (unit in ``label``); complex where ``x`` are frequencies."""
    label: str
    """Quantity and unit."""
    shaded: Annotated[np.ndarray, "(w, 2)"] = field(default_factory=lambda: np.empty((0, 2)))
    """Perturbations within ``x`` (s), in order; empty if there are none."""


# part of a record that is drawn around the onset of a perturbation (s)
BEFORE_S, AFTER_S = 0.1, 1.0


@dataclass(frozen=True, repr=False)
class ImpedanceFit:
    """Estimated impedance of a joint, tau = I theta'' + B theta' + K (theta - theta_ref).

    Attributes
    ----------
    estimator : str
        Name of the estimator (`tepsipe.identification.estimators`).
    quantities : mapping of str to Quantity
        ``I`` (N·m·s²/rad), ``B`` (N·m·s/rad), ``K`` (N·m/rad), and what else the estimator gives, each with
        its unit and interval.
    vaf : float
        Variance accounted for (%) of the fitted signal, see ``vaf_of``.
    vaf_of : str
        Fitted signal.
    confidence : float
        Probability of the intervals.
    curve : Curve
        Measured and predicted signal.
    details : object
        The estimator's complete result.
    windows : ndarray, shape (w, 3)
        I, B, K of every perturbation (N·m·s²/rad, N·m·s/rad, N·m/rad); empty where one fit serves all.
    notes : tuple of str
        Caveats: input that was probably not meant, numbers not to be trusted. One sentence each; none for a
        valid record (`tepsipe.identification.notes`).
    findings : tuple of str
        Further results in words, one sentence each.
    type_b : tuple of str
        Sources of Type B that were given as ``uncertainty``. Without any, standard errors and intervals are
        of Type A: they include the scatter within the record, and the delay of the torque where the record
        determines it, but no errors of masses, lengths and calibrations, which all records of the rig
        share.

    Examples
    --------
    >>> from tepsipe import fit_impedance, load_example
    >>> dummy = load_example("dummy")
    >>> fit = fit_impedance(dummy.time, dummy.angle, dummy.torque, perturbations=dummy.perturbations)
    >>> list(fit.quantities)
    ['I', 'B', 'K', 'delay']
    >>> low, high = fit.intervals["K"]
    >>> low < dummy.truth["K"] < high
    True
    >>> list(fit.to_frame().columns)
    ['value', 'unit', 'standard_error', 'low', 'high']
    """

    estimator: str
    quantities: Mapping[str, Quantity]
    vaf: float
    vaf_of: str
    confidence: float
    curve: Curve
    details: object
    windows: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    notes: tuple[str, ...] = ()
    findings: tuple[str, ...] = ()
    type_b: tuple[str, ...] = ()

    @property
    def I(self) -> float:  # noqa: E743, N802  the symbol of the thesis
        """Inertia (N·m·s²/rad), unit as in eq (2-1)."""
        return self.quantities["I"].value

    @property
    def B(self) -> float:  # noqa: N802
        """Damping in N·m·s/rad, unit as in eq (2-1)."""
        return self.quantities["B"].value

    @property
    def K(self) -> float:  # noqa: N802
        """Stiffness in N·m/rad, unit as in eq (2-1)."""
        return self.quantities["K"].value

    @property
    def parameters(self) -> np.ndarray:
        """I, B, K as an array, shape (3,), units N·m·s²/rad, N·m·s/rad, N·m/rad."""
        return np.array([self.quantities[name].value for name in PARAMETERS])

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Name -> ends of its interval (unit of the quantity)."""
        return {name: (q.low, q.high) for name, q in self.quantities.items()}

    @property
    def standard_errors(self) -> dict[str, float]:
        """Name -> standard error (unit of the quantity)."""
        return {name: q.standard_error for name, q in self.quantities.items()}

    @property
    def budget(self) -> dict[str, Mapping[str, float]]:
        """Quantity -> source -> standard uncertainty (unit of the quantity), ``scatter`` for Type A."""
        return {name: q.parts for name, q in self.quantities.items() if q.parts}

    @property
    def interval_type(self) -> str:
        """Sentence that names what the intervals include."""
        if self.type_b:
            return f"Intervals: scatter (Type A), and {', '.join(self.type_b)} (Type B)."
        if "torque_delay_s" in self.budget.get("K", {}):
            return (
                "Intervals: scatter and the delay of the torque, both from the record (Type A). Errors of "
                "masses, lengths and scales are not included; state them as uncertainty (Type B)."
            )
        return (
            "Intervals: scatter within the record only (Type A). Errors of masses, lengths, scales and "
            "delays are not included; state them as uncertainty (Type B)."
        )

    def summary(self) -> str:
        """Table of the estimates with units, standard errors and intervals, as text."""
        percent = f"{100.0 * self.confidence:g} % interval"
        head = f"{'':<16}{'estimate':>12}{'std. error':>12}{percent:>26}  unit"
        lines = [f"Joint impedance by {self.estimator}", head]
        for name, q in self.quantities.items():
            value, error, interval = q.cells()
            lines.append(f"{name:<16}{value:>12}{error:>12}{interval:>26}  {q.unit}".rstrip())
        lines.append(f"VAF of {self.vaf_of}: {self.vaf:.2f} %")
        if len(self.windows):
            lines.append(f"mean over {len(self.windows)} perturbations")
        lines.append(self.interval_type)
        return "\n".join([*lines, *self.findings, *(f"Note: {note}" for note in self.notes)])

    def __str__(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        values = ", ".join(f"{name} = {self.quantities[name]}" for name in PARAMETERS)
        notes = f", {len(self.notes)} note{'s'[: len(self.notes) != 1]}" if self.notes else ""
        return f"<ImpedanceFit {self.estimator}: {values}, VAF {self.vaf:.2f} %{notes}>"

    def _repr_html_(self) -> str:
        """The result in a notebook: table, VAF, notes and a small figure."""
        rows = [(name, *q.cells(), q.unit) for name, q in self.quantities.items()]
        lines = [f"VAF of {self.vaf_of}: {self.vaf:.2f} %"]
        if len(self.windows):
            lines.append(f"mean over {len(self.windows)} perturbations")
        lines += self.findings
        head = ("", "estimate", "std. error", f"{100.0 * self.confidence:g} % interval", "unit")
        title = f"Joint impedance by {self.estimator}"
        return as_html(title, head, rows, lines, self.notes, self._draw, self._panels)

    def to_frame(self) -> "pd.DataFrame":
        """The estimates as a pandas table: value, unit, standard_error, low, high by name."""
        import pandas as pd

        columns = ("value", "unit", "standard_error", "low", "high")
        rows = {name: {key: getattr(q, key) for key in columns} for name, q in self.quantities.items()}
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("quantity")

    def to_xarray(self) -> "xr.Dataset":
        """The estimates and the curve as an xarray Dataset; units are in ``unit`` and in the attributes.

        Raises
        ------
        InputError
            If xarray is not installed.
        """
        try:
            import xarray as xr
        except ImportError as error:
            raise InputError(
                "to_xarray: expected the package xarray, found none: install it with pip install xarray"
            ) from error

        table = self.to_frame()
        along = "frequency_hz" if self._panels == 2 else "time_s"
        name, _, unit = self.curve.label.partition(" (")
        curve = {"long_name": name, "units": unit.removesuffix(")")}
        data = {name: ("quantity", table[name].to_numpy()) for name in table if name != "unit"} | {
            name: (along, getattr(self.curve, name), curve) for name in ("measured", "predicted")
        }
        if len(self.windows):
            data["windows"] = (("perturbation", "parameter"), self.windows)
        coordinates = {
            "quantity": table.index.to_numpy(),
            "unit": ("quantity", table["unit"].to_numpy()),
            along: self.curve.x,
            "parameter": list(PARAMETERS),
        }
        attributes = {"estimator": self.estimator, "vaf_percent": self.vaf, "vaf_of": self.vaf_of}
        attributes |= {"confidence": self.confidence, "notes": list(self.notes)}
        return xr.Dataset(data, coordinates, attributes)

    def plot(self, ax: "Axes | Sequence[Axes] | None" = None) -> "Figure":
        """Measured and predicted signal, or gain and phase of a response, as a matplotlib figure.

        Perturbations are drawn on top of each other, from 0.1 s before their onset; the part that was fitted
        is shaded.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on, two of them for a frequency response; by default a new figure (7 inches wide).

        Returns
        -------
        matplotlib Figure
            The figure of the axes (size in inches).
        """
        figure, axes = new_axes(ax, self._panels, (7.0, 2.2 + 2.0 * self._panels))
        self._draw(axes)
        text = [f"{name} = {self.quantities[name]}" for name in PARAMETERS]
        axes[0].set_title("\n".join(text), loc="left", fontsize="small")
        return figure

    @property
    def _panels(self) -> int:
        """Number of axes of the figure: gain and phase, or one signal."""
        return 2 if np.iscomplexobj(self.curve.measured) else 1

    def _draw(self, axes) -> None:
        (_draw_response if self._panels == 2 else _draw_signal)(np.ravel(axes), self.curve)


def symbol_of(name: str) -> str:
    """Unit of a quantity, by its name in `UNITS`, as text shows it."""
    return unit_symbol(UNITS[name])


def quantities_of(
    values: Mapping[str, float], budget: Budget, confidence: float = CONFIDENCE
) -> dict[str, Quantity]:
    """Estimates with the combined standard uncertainties and intervals of a budget.

    values: estimates by name in `UNITS`, in the order of the budget.
    confidence: probability of the intervals.
    Returns: by the same names.
    """
    low, high = budget.interval(np.array(list(values.values()), dtype=float), confidence)
    of_b = budget.type_b.tolist() if budget.contributions else [None] * len(values)
    columns = (budget.combined.tolist(), low.tolist(), high.tolist(), budget.type_a.tolist(), of_b)
    return {
        name: Quantity(float(x), symbol_of(name), *numbers, parts=parts)
        for (name, x), parts, *numbers in zip(values.items(), parts_of(budget), *columns, strict=True)
    }


def parts_of(budget: Budget) -> list[dict[str, float]]:
    """For each quantity of a budget: source -> standard uncertainty (unit of the quantity)."""
    sources = {SCATTER: budget.type_a} | {name: budget.of_source(name) for name in budget.contributions}
    return [
        {source: float(np.broadcast_to(u, budget.type_a.shape)[k]) for source, u in sources.items()}
        for k in range(budget.type_a.size)
    ]


def _digits(x: float, error: float | None) -> str:
    """Two significant digits of the standard error, or four of the value."""
    if error is None or not error > 0.0 or not np.isfinite(x):
        return f"{x:.4g}"
    decimals = 1 - int(np.floor(np.log10(error)))
    if not -3 < decimals < 8:
        return f"{x:.3g}"
    rounded = round(x, decimals)
    return f"{rounded + 0.0:.{max(0, decimals)}f}"


def _draw_signal(axes, curve: Curve) -> None:
    (axis,) = axes
    if len(curve.shaded):
        # all perturbations on top of each other; those that follow within a second are cut there
        starts, ends = curve.shaded.T
        after = min(AFTER_S, float(np.diff(starts).min(initial=np.inf)) - BEFORE_S)
        axis.axvspan(0.0, float(np.median(ends - starts)), color="0.9", linewidth=0.0)
        spans = [slice(*np.searchsorted(curve.x, (t - BEFORE_S, t + after))) for t in starts]
        axis.set(xlabel="Time after the onset (s)", ylabel=curve.label)
    else:
        starts, spans = [0.0], [slice(None)]
        axis.set(xlabel="Time (s)", ylabel=curve.label)
    for signal, colour, width, label in (
        (curve.measured, "0.45", 1.8, "measured"),
        (curve.predicted, "#c8371b", 0.8, "predicted"),
    ):
        for k, (start, span) in enumerate(zip(starts, spans, strict=True)):
            name = label if k == 0 else None
            axis.plot(curve.x[span] - start, signal[span], color=colour, linewidth=width, label=name)
    axis.legend(loc="upper right", frameon=False)


def _draw_response(axes, curve: Curve) -> None:
    gain, phase = axes
    for values, colour, label in (
        (curve.measured, "0.4", "measured"),
        (curve.predicted, "#c8371b", "predicted"),
    ):
        gain.loglog(curve.x, np.abs(values), color=colour, label=label)
        phase.semilogx(curve.x, np.degrees(np.unwrap(np.angle(values))), color=colour)
    gain.set(ylabel=curve.label)
    phase.set(xlabel="Frequency (Hz)", ylabel="Phase (degrees)")
    gain.legend(loc="upper right", frameon=False)
