"""Parts of a study beside its experiments, and the figures of its appendix."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Part:
    """A part of a study without trials of its own, which needs the trials of several experiments.

    ``tables`` are those of the thesis that it needs, with conditions in the study. Its figures are found by
    its name, as for an experiment.
    """

    needs: tuple[str, ...]
    printed: tuple[str, ...] = ()
    tables: tuple[str, ...] = ()


# Figures B-1 to B-12 are one per condition of the dummy, in the order of the trial sheet, with one caption
APPENDIX = tuple(f"figure_b_{number}" for number in range(1, 13))
OF_APPENDIX = "figure_b_trial"
PARTS = {
    # schematics of the thesis's rigs, and time lines of the trials
    "rigs": Part(("dummy",)),
    # the torque from the foot's side needs models of the force plate
    "foot": Part(("dummy", "weight")),
    # the dummy that the printed tables describe
    "thesis_dummy": Part(("dummy",), tables=("table_4_2", "table_4_3")),
    # simulations compare the parameters of both experiments with the dummy
    "simulation": Part(("wristalyzer", "dummy")),
    # all trials of the manipulator together, if they hold enough periods of the perturbation
    "wristalyzer_pooled": Part(("wristalyzer",)),
    # any experiment whose trials have uncertainty budgets
    "budgets": Part(()),
    # any experiment whose trials name participants
    "participants": Part(()),
    # at least two trials
    "operating_points": Part(("position_manipulator",)),
    # if the configuration wants it
    "time_varying": Part(("position_manipulator",)),
    "noise": Part(
        ("wristalyzer", "dummy"),
        printed=("joint", "table_snr_db", "draws", "predicted_draws", "table_estimators"),
    ),
}
