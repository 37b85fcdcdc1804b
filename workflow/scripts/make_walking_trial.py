"""Make one walking trial's files: real strides, with simulated responses to belt pulses added to some."""

import job

job.start(snakemake)

from pathlib import Path

from tepsipe.errors import InputError
from tepsipe.experiments.walking.strides import SIGNALS
from tepsipe.experiments.walking.trial import read_trial
from tepsipe.virtual_lab.walking_trial import make_walking_trial

recording, strides, _ = read_trial(snakemake.params.base, snakemake.params.settings)
first_s = recording.time[0]
try:
    make_walking_trial(
        snakemake.params.truth,
        snakemake.wildcards.condition,
        {name: getattr(recording, name) for name in SIGNALS} | recording.state,
        recording.rate_hz,
        (strides.start - first_s, strides.stance, strides.end - first_s),
        snakemake.params.protocol,
        snakemake.params.chosen,
        {
            "c3d": Path(snakemake.output.c3d),
            "text": Path(snakemake.output.text),
            "events": Path(snakemake.output.events),
            "truth": Path(snakemake.output.truth),
        },
    )
except ValueError as error:
    place = "walking.simulated.trials"
    raise InputError(f"{place}: {error}: plan fewer pulses or a longer duration_s") from None
