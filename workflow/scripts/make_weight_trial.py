"""Make one treadmill trial's raw files, the weight on the belt, or nothing, which has no markers."""

import job

job.start(snakemake)

from pathlib import Path

from tepsipe.virtual_lab.treadmill_trial import Protocol
from tepsipe.virtual_lab.weight_trial import make_weight_trial

files = {"log": Path(snakemake.output.log), "calibration": Path(snakemake.output.calibration)}
markers = getattr(snakemake.output, "markers", None)
if markers is not None:
    files["markers"] = Path(markers)
make_weight_trial(
    snakemake.params.truth,
    snakemake.wildcards.condition,
    Protocol(**snakemake.params.protocol),
    files,
    snakemake.params.belt,
)
