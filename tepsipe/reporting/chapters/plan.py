"""Report on planned experiments: errors of K and B behind filters, and conditions of its sentences."""

import pandas as pd

from tepsipe.reporting.run import Run

PERTURBATIONS = 14.0  # of a trial of the thesis
NEAR = 1.25  # error of a filter that is as good as the best one, over the least error
HALF = 0.5
FILTER = ["kind", "order", "cutoff_hz"]


def numbers(run: Run) -> dict:
    """Numbers that no table has (units in the keys)."""
    return {
        "recommended": [
            {"pathway": pathway, "quantity": quantity} | _cutoffs(trials)
            for pathway in ("leg", "foot-compensated")
            for quantity in ("K", "B")
            if len(trials := _trials(run, pathway, quantity, kind="zero-lag", order=4))
        ],
        "near": NEAR,
        # largest error of any trial, filter by filter
        "largest_percent": {name: _largest(run, name) for name in ("foot", "foot-compensated")},
    }


def _trials(run: Run, pathway: str, quantity: str, **wanted: object) -> pd.DataFrame:
    """Errors of simulated trials, by filter."""
    rows = run.rows("filters", pathway=pathway, quantity=quantity, **wanted)
    return rows[rows.source != "predicted"]


def _cutoffs(trials: pd.DataFrame) -> dict[str, float]:
    """Cutoffs with nearly the least root mean square error, and the least and the largest error."""
    square = trials.bias**2 + trials.sd_of_window**2 / PERTURBATIONS
    error = square.groupby(trials.cutoff_hz.astype(float)).mean() ** 0.5
    near = error.index[error <= NEAR * error.min()]
    return {
        "from_hz": near.min(),
        "to_hz": near.max(),
        "least": error.min(),
        "least_at_hz": error.idxmin(),
        "most": error.max(),
        "most_at_hz": error.idxmax(),
    }


def _largest(run: Run, pathway: str) -> list[float]:
    trials = _trials(run, pathway, "K")
    return trials.bias_percent.abs().groupby([trials[name] for name in FILTER]).max().tolist()


# ---- conditions of sentences


def one_suffices(run: Run) -> bool:
    """One perturbation gives K within ±10 % in some design."""
    return bool((run.rows("plan", quantity="K").n_for_10_percent == 1).any())


def none_suffices(run: Run) -> bool:
    """No number of perturbations gives K within ±10 % in some design."""
    return bool(run.rows("plan", quantity="K").n_for_10_percent.isna().any())


def _within_peaks(run: Run, belt: str) -> pd.DataFrame:
    return run.rows("pulses", limits="its own peaks", belt=belt)


def belt_returns(run: Run) -> bool:
    """Pulses were optimised that return the belt, within the peaks of the reference."""
    return len(_within_peaks(run, "returns")) > 0


def bound_above_half(run: Run) -> bool:
    """No pulse that returns the belt can have less than half the reference's Cramér-Rao bound."""
    rows = _within_peaks(run, "returns")
    return bool((rows.least_cramer_rao / rows.reference_cramer_rao).min() > HALF)


def belt_stays(run: Run) -> bool:
    """Pulses were optimised that leave the belt displaced, within the peaks of the reference."""
    return len(_within_peaks(run, "one way")) > 0


def drive_alone_limits(run: Run) -> bool:
    """Pulses were optimised without limits of velocity and displacement."""
    return len(run.rows("pulses", limits="its own acceleration")) > 0


def drive_alone_halves(run: Run) -> bool:
    """Without limits of velocity and displacement, every standard error is below half the reference's."""
    return bool(run.rows("pulses", limits="its own acceleration").u_ratio.max() < HALF)


def compensation_tried(run: Run) -> bool:
    """Simulated trials have K from plate and foot with and without compensation."""
    return all(len(_trials(run, name, "K")) for name in ("foot", "foot-compensated"))


def one_side_filtered(run: Run) -> bool:
    """Bias was predicted for a filter of torque or motion alone, of 20 Hz and fourth order."""
    wanted = {"quantity": "K", "kind": "zero-lag", "order": 4, "cutoff_hz": 20.0}
    rows = run.rows("filters", source="predicted", **wanted)
    return bool((rows.filtered != "alike").any())


PREDICATES = (
    one_suffices,
    none_suffices,
    belt_returns,
    bound_above_half,
    belt_stays,
    drive_alone_limits,
    drive_alone_halves,
    compensation_tried,
    one_side_filtered,
)
