# %% [markdown]
# # A person on a treadmill: from C3D files to K
#
# A person stands on a treadmill whose belt makes short pulses. Marker positions, forces
# and electromyograms are stored in one C3D file per trial. From such files, this
# tutorial estimates the stiffness *K* and the damping *B* of the ankles, with their
# uncertainty.
#
# It uses the command line and Snakemake, so it needs a copy of the repository and the
# environment that `make` builds. The recordings are simulated, so the true values are
# known.
#
# ## The recordings
#
# | Trial | What it determines |
# |---|---|
# | person, with pulses backwards and forwards | the impedance of the ankles |
# | empty belt | the load that the moving belt causes by itself |
# | a weight near the person's mass | how this load changes with the mass on the belt |
#
# The virtual laboratory simulates these trials and writes them in the file formats of
# the thesis.

# %%
recorded = {
    "standing": ("relax-neg-0.5", "relax-pos-0.5"),
    "empty": ("sine-0.5", "minjerk-0.5"),
    "weight": ("sine-0.3-60kg", "negative-sine-0.5-60kg", "minjerk-0.5-60kg"),
}
logs = " ".join(
    f"results/raw/{experiment}/{name}/log.mat"
    for experiment, names in recorded.items()
    for name in names
)

# %%
# !snakemake -c1 --quiet all -- {logs} > simulation.log 2>&1 || cat simulation.log

# %% [markdown]
# A function from the project's tests converts each trial into one C3D file, as a motion
# capture system with force plates would have written it. With recordings of your own,
# you already have such files. Put them into one folder, with `empty`, `weight` and
# `standing` in their names.

# %%
import sys
from pathlib import Path

sys.path.append("tests")
from c3d_builders import single_c3d

muscles = [f"EMG {name}" for name in ("TA", "SOL", "GAS", "BF", "RF")]
for trial in sorted(Path("results/raw").glob("*/*")):
    files = {path.stem: path for path in trial.iterdir()}
    folder = Path("recordings") / trial.parent.name
    folder.mkdir(parents=True, exist_ok=True)
    channels = muscles if "emg" in files else ()
    # without markers, nothing but the protocol says how long the trial is
    duration_s = None if "markers" in files else 60.0
    name = trial.name.removesuffix("-60kg")
    print(single_c3d(files, folder / f"{name}.c3d", channels, duration_s=duration_s))

# %% [markdown]
# ## What is in a file?

# %%
# !tepsipe info recordings/standing/relax-neg-0.5.c3d

# %% [markdown]
# ## A study in one command
#
# `tepsipe new-study` inspects all files and writes the settings. It detects the axes,
# the loaded plates, the muscles and the channel of the belt velocity.

# %%
# !tepsipe new-study recordings --name my-person --output my-person

# %% [markdown]
# `MISSING.md` lists the values that no file contains, and how to measure them.

# %%
print(Path("my-person/MISSING.md").read_text().partition("## Assumed")[0])

# %% [markdown]
# We write the measured values into a separate file. The marker positions on foot, shank
# and thigh are measured with a ruler, along the segment's axis and forward from it. If
# your cameras sample all markers at once, set `marker_sampling_hz: null`. The simulated
# cameras sample one marker after the other.

# %%
measured = """
weight:
  ingest: {marker_sampling_hz: 2500}
  weight: {mass_kg: 60.0, com_height_m: 0.15}
standing:
  ingest: {marker_sampling_hz: 2500}
  person:
    mass_kg: 64.0
    stature_m: 1.75
    com_height: 0.55
    ankle_height_m: 0.08
    foot_com_m: 0.05
    foot_markers:
      - {label: foot1, anterior_offset_m: 0.14, longitudinal_offset_m: -0.05}
      - {label: foot2, anterior_offset_m: -0.05, longitudinal_offset_m: -0.05}
      - {label: ankle, anterior_offset_m: 0.0, longitudinal_offset_m: 0.0}
    shank_markers:
      - {label: ankle, anterior_offset_m: 0.0, longitudinal_offset_m: 0.0}
      - {label: shank1, anterior_offset_m: 0.025, longitudinal_offset_m: 0.37}
      - {label: shank2, anterior_offset_m: -0.02, longitudinal_offset_m: 0.16}
    thigh_markers:
      - {label: thigh1, anterior_offset_m: 0.03, longitudinal_offset_m: 0.3}
      - {label: thigh2, anterior_offset_m: -0.03, longitudinal_offset_m: 0.18}
      - {label: thigh3, anterior_offset_m: 0.03, longitudinal_offset_m: 0.06}
"""
_ = Path("my-person/measured.yaml").write_text(measured)

# %% [markdown]
# The trial sheet contains one row per file. Only you can decide which calibration
# trials to hold out, so we set the column `role` ourselves. The calibration trials with
# minimum-jerk pulses are used for validation, all others for calibration.

# %%
import pandas as pd

path = Path("my-person/trials.tsv")
trials = pd.read_csv(path, sep="\t", comment="#", dtype=str)
calibration = trials["experiment"].isin(["weight", "empty"])
held_out = trials["condition"].str.startswith("minjerk")
trials.loc[calibration, "role"] = "calibrate"
trials.loc[calibration & held_out, "role"] = "validate"
trials.to_csv(path, sep="\t", index=False)
trials[["experiment", "condition", "duration_s", "log", "role", "task"]]

# %% [markdown]
# ## Check, then run
#
# `tepsipe check` does not run the analysis. It reports each mistake with its file and
# line.

# %%
# !cd my-person && tepsipe check config.yaml measured.yaml

# %% [markdown]
# The run reads the files, calibrates the treadmill and fits the person's responses. We
# request one table only. Without its name, the run would also draw all figures and
# write the report.

# %%
table = "results/tables/estimates.csv"

# %%
# !cd my-person && snakemake -c1 --quiet all --configfile config.yaml measured.yaml -- {table} > study.log 2>&1 || cat study.log

# %% [markdown]
# ## The result
#
# The column `recommended` marks the estimates to quote. For a person, these are the
# estimates of the task, computed from all of its trials together.

# %%
results = Path("my-person/results/tables")
estimates = pd.read_csv(results / "estimates.csv")
columns = ["condition", "quantity", "unit", "value", "ci_low", "ci_high", "flags"]
joint = estimates["quantity"].isin(["B", "K"])
person = estimates[(estimates["experiment"] == "standing") & joint]
quoted = person[person["recommended"]]
quoted[columns].round(2)

# %% [markdown]
# The simulated joint is not linear. Beyond a short range of 0.23°, its stiffness is
# `stiffness_Nm_per_rad`. Within this range, `short_range_Nm_per_rad` is added. At the
# working amplitude, *K* lies between the stiffness within and the stiffness beyond the
# short range, closer to the lower one. In each line below, the first number belongs to
# the ankle.

# %%
import yaml

laboratory = yaml.safe_load(Path("config/virtual_lab.yaml").read_text())
relaxed = laboratory["standing"]["tasks"]["relax"]
for name in ("stiffness_Nm_per_rad", "short_range_Nm_per_rad", "damping_Nms_per_rad"):
    print(name, relaxed[name])

# %% [markdown]
# Without the calibration of the treadmill (pathway `ankle`), the same signals give
# different values. The moving belt loads the plate, and this load is mistaken for joint
# torque.

# %%
compared = person[
    (person["condition"] == "relax")
    & (person["estimator"] == "pre-reflex-window")
    & person["pathway"].isin(["ankle", "ankle-compensated"])
]
compared[["pathway", "quantity", "value", "ci_low", "ci_high"]].round(1)

# %% [markdown]
# ## Where does the uncertainty come from?

# %%
import matplotlib.pyplot as plt

sources = pd.read_csv(results / "uncertainty.csv")
estimate = quoted[quoted["quantity"] == "K"].iloc[0]
of_stiffness = sources.merge(
    estimate.to_frame().T[["condition", "pathway", "estimator", "quantity"]]
)
largest = of_stiffness.nlargest(8, "u").iloc[::-1]
figure, ax = plt.subplots(figsize=(7, 3), layout="constrained")
ax.barh(
    largest["source"],
    largest["u"],
    color=["C0" if kind == "A" else "C1" for kind in largest["type"]],
)
ax.set_xlabel("standard uncertainty of K (N·m/rad); blue: Type A, orange: Type B")
plt.show()

# %% [markdown]
# The longest bar is the source to measure better, here the origin of the force plate
# along the belt. The trials of the weight determine this origin if you state where the
# centre of mass of the weight is relative to its markers (`com_forward_of_markers_m`).
# `new-study` asked for this value in `config.yaml`. More pulses shorten only
# the blue bar.
#
# ## What can go wrong
#
# **A wrong length.** While writing this tutorial, we first entered the height of the
# weight's centre of mass as 0.10 m instead of 0.15 m. The treadmill model therefore
# included the moment of 60 kg on a lever arm that was 5 cm too short. The result was
# *K* = 628 N·m/rad and *B* = −0.9 N·m·s/rad. The flag `negative` marked it, and no
# estimate was recommended.
#
# **A value that is still missing.** The run is refused with a one-sentence message that
# names the missing keys.

# %%
# !cd my-person && tepsipe check

# %% [markdown]
# **A damaged file.** Only the job that reads this file stops, with a one-sentence
# message. The results of the other trials are kept ([when a run
# stops](../when-it-stops.md)).
#
# ## Exercises
#
# 1. Enter the wrong height yourself, `com_height_m: 0.10`, and run again. Which jobs
#    are repeated?
# 2. Run the study without naming a table, and open
#    `my-person/results/report/index.html`.
# 3. Leave out one of the two directions of the pulses. Which uncertainty grows most?
#
# The following pages describe all steps and settings: [a standing
# person](../recordings/standing.md), [C3D](../recordings/c3d.md), [weight and empty
# belt](../recordings/weight-and-empty.md).
