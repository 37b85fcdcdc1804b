"""Figure of the participants: every person, and the mean over people."""

import job

job.start(snakemake)

import pandas as pd

from tepsipe.reporting.figures import participants as figures
from tepsipe.reporting.figures.style import save_figure

text = {"participant": str, "condition": str}
people = pd.read_csv(snakemake.input.participants, dtype=text)
group = pd.read_csv(snakemake.input.group, dtype=text)
drawn = {"figure_participants": figures.plot_participants(people, group, snakemake.params.shown)}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
