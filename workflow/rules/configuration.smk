# Reads every configuration file strictly, before the study does. Snakemake has loaded those of the command line already:
# the command `tepsipe check` and make read them before it.

import gc
import os
import sys
from pathlib import Path

# folder of rules, scripts and report: a checkout, or that of an installation; also where a study elsewhere
# takes its Snakefile as a module
CHECKOUT = Path(workflow.snakefile).absolute().parents[2]
sys.path.insert(0, str(CHECKOUT))

from tepsipe.errors import InputError
from workflow.support import runs
from workflow.support.yaml_file import CODE, read_settings

# those of the command line come last, as they override the others
CONFIGFILES = [
    Path(os.path.relpath(CHECKOUT / "config/config.yaml")),
    *(Path(os.path.relpath(path)) for path in workflow.overwrite_configfiles),
]

# garbage is looked for less often, and only in what is made from here on: 7 % of the time of a run with nothing to do
gc.freeze()
gc.set_threshold(50_000)
runs.spare_pandas()

try:
    for path in CONFIGFILES:
        read_settings(path)
    if not runs.looks(sys.argv):
        runs.refuse_a_full_disk()
    # now, because Snakemake writes to the folder when it loads the first of them
    if not runs.looks(sys.argv) and not runs.is_dry(sys.argv):
        runs.begin()
except InputError as error:
    # those of the command line have been loaded
    late = (
        "; the code has run by now, tepsipe check looks first"
        if path != CONFIGFILES[0] and CODE in str(error)
        else ""
    )
    sys.exit(f"tepsipe: {error}{late}")
