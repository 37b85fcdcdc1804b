"""How figures and tables call the conditions (thesis Figure 4-4)."""

PROFILES = {"sine": "sinusoidal", "minjerk": "minimum jerk"}
# sets of parameters that the dummy is simulated with
PARAMETER_SETS = {
    "wristalyzer": "Wristalyzer",
    "tep": "TEP-SIPE as printed",
    "corrected": "TEP-SIPE, consistent",
}


def short_name(condition: str) -> str:
    """The thesis's label of a condition (no unit), for example S3 for sine-0.3 and M52 for minjerk-0.5-8s."""
    profile, _, rest = condition.partition("-")
    if profile not in PROFILES:
        return condition
    amplitude, _, interval = rest.partition("-")
    digit = amplitude.removeprefix("0.")
    return f"{profile[0].upper()}{digit}{'2' if interval else ''}"
