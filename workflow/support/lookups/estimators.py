"""Pathways and estimators that the configuration has chosen, and their windows."""

from tepsipe.experiments.standing.muscle_torque import ACTIVE
from tepsipe.identification.estimators import ESTIMATORS
from workflow.settings.complete import only
from workflow.support.lookups.sheet import Sheet


class Estimators:
    """Pathways and estimators of a study; ``has_foot`` if it has the torque from the foot."""

    def __init__(self, sheet: Sheet, settings: dict, has_foot: bool) -> None:
        self.sheet, self.settings, self.has_foot = sheet, settings, has_foot

    def budgeted_foot(self) -> str | None:
        """Pathway from the foot whose budget is shown: the last one with a treadmill model, None without."""
        pathways = self.settings["dummy"]["foot"]["pathways"] if self.has_foot else {}
        compensated = [name for name, choice in pathways.items() if choice["treadmill_model"] is not None]
        return compensated[-1] if compensated else None

    def foot_pathways(self) -> list[str]:
        """Pathways of the dummy with the torque from the foot."""
        return list(self.settings["dummy"]["foot"]["pathways"]) if self.has_foot else []

    def active(self) -> list[str]:
        """Estimators of the standing person that separate the muscle torque."""
        choices = self.settings["standing"]["estimators"]
        return [name for name, choice in choices.items() if ACTIVE[choice["active"]].separates]

    def dummy_windows(self) -> dict[str, float | None]:
        """Pathway of the dummy whose truth is that of windows -> length (s), None if that of the pulse."""
        dummy = self.settings["dummy"]
        foot = dummy["foot"]["pathways"] if self.has_foot else {}
        legs = [name for name, p in dummy["pathways"].items() if ESTIMATORS[p["estimator"]].true_in_windows]
        return dict.fromkeys(legs) | {name: p["window_s"] for name, p in foot.items()}

    def quoted_dummy(self) -> dict[str, float | None]:
        """The same of the two pathways that may be quoted."""
        windows, dummy = self.dummy_windows(), self.settings["dummy"]
        return {name: windows.get(name) for name in (dummy["recommended"], dummy["quoted"])}

    def true_windows(self, experiment: str) -> dict:
        """Windows in which the truth of a simulated joint is that of its motion, as it was fitted in them."""
        if experiment == "dummy":
            return {"lengths_s": self.dummy_windows(), "foot": self.foot_pathways()}
        if experiment != "standing":
            return {}
        settings = self.settings["standing"]
        return {
            "baseline_s": settings["analysis"]["baseline_s"],
            "estimators": {n: only(e, "window_s", "inertia") for n, e in settings["estimators"].items()},
        }

    def windows(self) -> dict[str, dict[str, float | None]]:
        """Experiment -> name of a pathway or estimator -> its window (s)."""
        standing = self.settings["standing"]["estimators"]
        return {
            "dummy": self.dummy_windows(),
            "standing": {name: choice["window_s"] for name, choice in standing.items()},
        }
