"""Names, units and numbers as figures and pages show them: signs, digits, intervals.

Names are those of conditions (thesis Figure 4-4) and of choices. Typst has the same rules for numbers in
report/format.typ.
"""

import math
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
# names in configurations and files -> words in figures, where hyphens do not simply become spaces
WORDS = {
    "leg-thesis-aligned": "leg, thesis equation, aligned markers",
    "leg-output-error": "leg, output error",
    "leg-joint-likelihood": "leg, joint likelihood",
    "foot-long": "foot, long window",
    "long": "long window",
    "foot-compensated": "foot, compensated",
    "foot-compensated-short": "foot, compensated, short window",
    "ankle-compensated": "ankle, compensated",
    "ankle-thesis-vector": "eq (3-14), vectors",
    "ankle-thesis": "eq (3-14), scalars",
    "windowed-least-squares-thesis": "windowed least squares, thesis",
    "windowed-least-squares-own-zero": "windowed least squares, torque offset per window",
    "free-reflex-gls": "free reflex torque (GLS)",
    "pre-reflex-window": "pre-reflex window",
    "emg-driven": "EMG-driven",
    "emg": "EMG",
    "least-squares": "belt as instrument",  # of the mass of the weight
    "spectral-fit": "spectral fit",
    "spectral-fit-modulus": "spectral fit, modulus",
    "spectral-fit-periods": "spectral fit, whole periods",
    "time-domain-pooled": "time domain, all trials",
    "recommended": "consistent, IV",  # of the noise study
    "recommended-regression": "consistent, least squares",
    "mass-spring-damper": "mass-spring-damper",
    "hnat2014": "Hnat (2014)",
    "fir": "impulse response",
    "fir-causal": "impulse response, causal",
    "spectral": "transfer function",
    "per segment": "per perturbation",
    "teager-kaiser": "Teager-Kaiser",
    "changepoint": "change point",
}
# the same of what follows the thesis, in reports that do not
NEUTRAL = {
    "leg-thesis": "leg, single-body equation",
    "leg-thesis-aligned": "leg, single-body equation, aligned markers",
    "foot-thesis": "foot, single-body equation",
    "ankle-thesis": "ankle, single-body equation",
    "ankle-thesis-vector": "ankle, single-body equation, vectors",
    "windowed-least-squares-thesis": "windowed fit, no torque at rest",
    "as-printed": "inertia, damping and stiffness",
}


def words(name: str, neutral: bool = False) -> str:
    """A pathway, estimator, filter or detector as figures show it (no unit).

    For example "leg, thesis equation" for leg-thesis and "zero-lag 20 Hz" for bidirectional 20 Hz.
    ``neutral``: without mentioning the thesis.
    """
    if neutral and name in NEUTRAL:
        return NEUTRAL[name]
    if name in WORDS:
        return WORDS[name]
    for kind, label in (("bidirectional ", "zero-lag "), ("unidirectional ", "forward-only ")):
        if name.startswith(kind):
            return label + name.removeprefix(kind)
    return name.replace("-thesis", ", thesis equation").replace("-", " ")


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


SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MINUS = "\N{MINUS SIGN}"


def number(value: float | int | None, digits: int = 3) -> str:
    """A number (any unit) as text with ``digits`` significant digits; a dash for None."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "\N{EN DASH}"
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    if value != 0.0 and not 1e-3 <= abs(value) < 1e5:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        text = f"{mantissa}·10{str(int(exponent)).translate(SUPERSCRIPTS)}"
    elif value == 0.0:
        text = "0"
    elif isinstance(value, int):
        text = str(value)
    else:
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
        text = f"{value:.{decimals}f}"
    return text.replace("-", MINUS)


def by_uncertainty(value: float, low: float | None, high: float | None) -> tuple[str, str]:
    """A value and its 95 % interval (any unit) as text, to two significant digits of the half-width.

    The second is empty where there is no interval; the value then has three significant digits.
    """
    if low is None or high is None or not math.isfinite(value) or not high - low > 0.0:
        return number(value), ""
    if not math.isfinite(high - low):
        return number(value), f"{number(low)} to {number(high)}"
    decimals = 1 - math.floor(math.log10(0.5 * (high - low)))
    # beyond 1e-9 the numbers would be longer than they are readable
    if decimals > 9:
        return number(value), f"{number(low)} to {number(high)}"
    # the sum with 0.0 turns a rounded -0.0 into 0.0
    rounded = [f"{round(x, decimals) + 0.0:.{max(0, decimals)}f}" for x in (value, low, high)]
    texts = [text.replace("-", MINUS) for text in rounded]
    return texts[0], f"{texts[1]} to {texts[2]}"


def below_100(shown: str, value: float) -> str:
    """A VAF (%) as text, with as many more decimals as keep a value below 100 from being rounded up to it."""
    decimals = len(shown.partition(".")[2])
    while shown.partition(".")[0] == "100" and value < 100.0 and decimals < 9:
        decimals += 1
        shown = f"{value:.{decimals}f}"
    return shown
