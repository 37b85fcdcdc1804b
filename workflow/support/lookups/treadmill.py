"""Belts of the plate treadmill, their calibrations, and the weights on them."""

from tepsipe.errors import InputError
from tepsipe.experiments.registry import EXPERIMENTS
from workflow.settings.complete import plate_treadmill
from workflow.support.lookups.sheet import Sheet
from workflow.support.people import BELTS
from workflow.support.trial_sheet import check_roles


class Treadmill:
    """Plate treadmill of a study: belts of its trials, and trials that calibrate the models of a belt."""

    def __init__(self, sheet: Sheet, config: dict, settings: dict) -> None:
        self.sheet, self.config, self.settings = sheet, config, settings

    def belt_of(self, experiment: str, condition: str) -> str | None:
        """Belt of a trial, by its row or by the configuration; None if it is not on the plate treadmill."""
        if not EXPERIMENTS[experiment].on_plate:
            return None
        row = self.sheet.trials.get((experiment, condition))
        return (row and row.belt) or plate_treadmill(self.config, experiment)["belt"]

    def belts(self) -> list[str]:
        """Belts with models of the force plate, in the order left, right."""
        return sorted({self.belt_of(e, c) for e in ("empty", "weight") for c in self.sheet.conditions(e)})

    def plates(self) -> dict[str, str]:
        """Name of a calibration of the force plate in its files -> its belt."""
        return {self.plate_of(belt): belt for belt in self.belts()}

    def plate_of(self, belt: str) -> str:
        """Name of a belt's calibration: plate, or plate_left and plate_right if the sheet names belts."""
        return f"plate_{belt}" if self.sheet.by_belt else "plate"

    def plates_of(self, experiment: str, condition: str) -> list[str]:
        """Names of the calibrations of a trial: of its belt, or of both, left and right."""
        belt = self.belt_of(experiment, condition)
        return [self.plate_of(own) for own in (BELTS if belt == "both" else (belt,))]

    def plate_trials(self, belt: str | None = None) -> list[list[str]]:
        """[experiment, condition, role] of the trials for models of the force plate, or of one belt of it."""
        return [
            [e, c, role]
            for e in ("empty", "weight")
            for c, role in self.sheet.roles(e).items()
            if belt is None or self.belt_of(e, c) == belt
        ]

    def weight_of(self, experiment: str, condition: str) -> dict | None:
        """Weight of a trial: the usual one, or a further one of the mass in its row; None without any."""
        if experiment != "weight":
            return None
        usual = self.settings["weight"]["weight"]
        mass = self.sheet.trials[experiment, condition].mass_kg
        if mass is None or mass == usual["mass_kg"]:
            return usual
        others = {other["mass_kg"]: other for other in self.settings["weight"]["further_weights"]}
        if mass not in others:
            known = " or ".join(f"{kg:g}" for kg in (usual["mass_kg"], *others))
            raise InputError(
                f"{self.config['study']['trial_sheet']}: expected a mass_kg of {known} for "
                f"weight/{condition}, found {mass:g}: correct it, or add the weight to "
                "weight.further_weights in the configuration"
            )
        return usual | others[mass]

    def usual_weight(self) -> list[str]:
        """Conditions of the weight of the thesis, without those of further weights."""
        usual = self.settings["weight"]["weight"]
        return [c for c in self.sheet.conditions("weight") if self.weight_of("weight", c) == usual]

    def check(self, path: str) -> None:
        """Refuse trials that need models of the treadmill on a belt that has not been calibrated."""
        plate = [row for (e, _), row in self.sheet.trials.items() if EXPERIMENTS[e].models == "plate"]
        for belt in self.belts():
            check_roles(
                [row for row in plate if self.belt_of(row.experiment, row.condition) == belt], path, belt
            )
        for (experiment, condition), row in self.sheet.trials.items():
            belt = self.belt_of(experiment, condition)
            for own in BELTS if belt == "both" else (belt,):
                if row.experiment in ("dummy", "standing") and own not in self.belts():
                    raise InputError(
                        f"{path}: expected trials of weight and empty on the {own} belt, because models of "
                        f"the treadmill are those of one belt and {experiment}/{condition} is on it, found "
                        "none: add their rows, or correct its belt"
                    )
