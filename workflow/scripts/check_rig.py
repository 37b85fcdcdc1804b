"""Pool the checks of all trials of the dummy, which share a rig."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.rig import RIG_FLAGS, rig_flags
from tepsipe.io.result import read_facts

fits = zip(snakemake.params.conditions, snakemake.input.fits, strict=True)
RIG_FLAGS.write(snakemake.output.flags, rig_flags({condition: read_facts(path) for condition, path in fits}))
