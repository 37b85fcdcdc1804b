"""Trials of the dummy whose belt motions the noise study simulates."""

from workflow.support.lookups.sheet import Sheet


class NoiseTrials:
    """Trials of the noise study."""

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet

    def conditions(self) -> list[str]:
        """One trial of the dummy for every profile and amplitude: the belt motions of the noise study."""
        chosen: dict = {}
        for condition in self.sheet.conditions("dummy"):
            row = self.sheet.trials["dummy", condition]
            key = condition if row.amplitude is None else (row.profile, row.amplitude)
            chosen.setdefault(key, condition)
        return list(chosen.values())

    def averaged(self) -> list[str]:
        """Trials of Table 4-4 and Figure 4-12: with sinusoidal perturbations, or all if there are none."""
        names = self.conditions()
        return [name for name in names if name.startswith("sine")] or names

    def same_profile(self, condition: str) -> list[str]:
        """The noise study's trials with the profile of a given trial, which is included."""
        profile = self.sheet.trials["dummy", condition].profile
        return [c for c in self.conditions() if self.sheet.trials["dummy", c].profile == profile]
