"""Names of conditions (thesis Figure 4-4) and of choices, and symbols of units, in figures and tables."""

from collections.abc import Iterable

PROFILES = {"sine": "sinusoidal", "minjerk": "minimum jerk"}
# sets of parameters of the simulated dummy: estimates of the run, then what the thesis printed
ESTIMATED_SETS = {
    "wristalyzer": "Wristalyzer",
    "tep": "TEP-SIPE as printed",
    "corrected": "TEP-SIPE, consistent",
    "joint-likelihood": "joint likelihood",
}
THESIS_SETS = {
    "thesis-wristalyzer": "Wristalyzer (thesis)",
    "thesis-without-handle": "Wristalyzer without handle",
    "thesis-tep": "TEP-SIPE (thesis)",
}
PARAMETER_SETS = ESTIMATED_SETS | THESIS_SETS
COMPARED_SETS = ("thesis-wristalyzer", "thesis-tep", "joint-likelihood")
# units as tables and files write them -> as text and figures show them
UNIT_SYMBOLS = {
    "Nms2/rad": "N·m·s²/rad",
    "Nms/rad": "N·m·s/rad",
    "Nm/rad": "N·m/rad",
    "Nms/rad2": "N·m·s/rad²",
    "Nm/rad2": "N·m/rad²",
    "Nm/rad3": "N·m/rad³",
    "Nm": "N·m",
    "Nm/rad/kg": "N·m/rad/kg",
    "Nms/rad/kg": "N·m·s/rad/kg",
}
# names in configurations and files -> words in figures, where hyphens do not simply become spaces
WORDS = {
    "leg-thesis-aligned": "leg, thesis equation, aligned markers",
    "leg-output-error": "leg, output error",
    "leg-joint-likelihood": "leg, joint likelihood",
    "foot-long": "foot, long window",
    "foot-compensated": "foot, compensated",
    "foot-compensated-short": "foot, compensated, short window",
    "ankle-compensated": "ankle, compensated",
    "ankle-thesis": "ankle, thesis equation",
    "windowed-least-squares-thesis": "windowed least squares, thesis",
    "windowed-least-squares-own-zero": "windowed least squares, zero per window",
    "free-reflex-gls": "free reflex torque (GLS)",
    "pre-reflex-window": "pre-reflex window",
    "emg-driven": "EMG-driven",
    "emg": "EMG",
    "spectral-fit": "spectral fit",
    "spectral-fit-modulus": "spectral fit, modulus",
    "spectral-fit-periods": "spectral fit, whole periods",
    "time-domain-pooled": "time domain, all trials",
    "recommended-regression": "recommended, least squares",
    "mass-spring-damper": "mass-spring-damper",
    "hnat2014": "Hnat (2014)",
    "fir": "impulse response",
    "fir-causal": "impulse response, causal",
    "spectral": "transfer function",
    "per segment": "per perturbation",
    "teager-kaiser": "Teager-Kaiser",
    "changepoint": "change point",
}


def words(name: str) -> str:
    """A pathway, estimator, filter or detector as figures show it (no unit).

    For example "leg, thesis equation" for leg-thesis and "zero-lag 20 Hz" for bidirectional 20 Hz.
    """
    if name in WORDS:
        return WORDS[name]
    for kind, label in (("bidirectional ", "zero-lag "), ("unidirectional ", "forward-only ")):
        if name.startswith(kind):
            return label + name.removeprefix(kind)
    return name.replace("-thesis", ", thesis equation").replace("-", " ")


def unit_symbol(unit: str) -> str:
    """A unit as text and figures show it, for example N·m·s²/rad for N·m·s²/rad."""
    return UNIT_SYMBOLS.get(unit, unit)


def compared_sets(known: Iterable[str]) -> list[str]:
    """Sets in a figure of few (no unit): what the thesis compares, and the recommended estimate.

    Without numbers of the thesis all known sets.
    """
    known = list(known)
    return [name for name in COMPARED_SETS if name in known] if "thesis-tep" in known else known


def short_name(condition: str) -> str:
    """The thesis's label of a condition (no unit), for example S3 for sine-0.3 and M52 for minjerk-0.5-8s.

    A pulse that begins backwards has a minus sign; a mass follows after a comma.
    """
    backwards = condition.startswith("negative-")
    profile, _, rest = condition.removeprefix("negative-").partition("-")
    if profile not in PROFILES:
        return condition
    amplitude, _, interval = rest.partition("-")
    sign = "\N{MINUS SIGN}" if backwards else ""
    digit = amplitude.removeprefix("0.")
    if interval.endswith("kg"):
        return f"{sign}{profile[0].upper()}{digit}, {interval.removesuffix('kg')} kg"
    return f"{sign}{profile[0].upper()}{digit}{'2' if interval else ''}"
