"""Trials of the manipulators together: of the torque-controlled one, and by operating point of the other."""

from workflow.support.lookups.sheet import Sheet
from workflow.support.row_names import with_names

LEAST_PERIODS = 12  # of the perturbation in all trials of the torque-controlled one, to fit them together


class Manipulators:
    """Trials of both manipulators across conditions."""

    def __init__(self, sheet: Sheet, settings: dict) -> None:
        self.sheet, self.settings = sheet, settings

    def periods_suffice(self) -> bool:
        """Whether the manipulator's trials, of at least two amplitudes, can be fitted together."""
        rows = [self.sheet.trials["wristalyzer", c] for c in self.sheet.conditions("wristalyzer")]
        if len(rows) < 2:
            return False
        analysis = self.settings["wristalyzer"]["analysis"]
        period, cut = analysis["perturbation_period_s"], analysis["cut_s"]
        if period is None:
            return False
        periods = [int((row.duration_s - 2.0 * cut) / period + 1e-9) for row in rows]
        return min(periods) >= 2 and sum(periods) >= LEAST_PERIODS

    def pooled(self) -> dict:
        """Choices of the manipulator's trials that hold for the fit to all of them together."""
        analysis = self.settings.get("wristalyzer", {}).get("analysis", {})
        names = ("lowpass_cutoff_hz", "lowpass_order", "cut_s", "excited_band_hz")
        return {name: analysis.get(name) for name in names} | {
            "period_s": analysis.get("perturbation_period_s")
        }

    def operating_points(self) -> dict[str, dict]:
        """Condition of the position-controlled manipulator -> participant, angle (rad), torque (N·m).

        Trials with a schedule or a trigger have no operating point of their own.
        """
        name, rows = "position_manipulator", {}
        for condition in self.sheet.conditions(name):
            row = self.sheet.trials[name, condition]
            columns = with_names(self.settings[name], row.names)["files"]["columns"]
            if columns["schedule"] is None and columns["trigger"] is None:
                rows[condition] = row
        return {
            condition: {
                "participant": row.participant or "",
                "angle_rad": row.operating_angle_rad,
                "torque_Nm": row.operating_torque_Nm,
            }
            for condition, row in rows.items()
        }
