"""Check a study without running it: ``python -m workflow.check [CONFIG...]``, as after ``--configfile``.

Configuration and trial sheet first, then every recording is read as its job would read it.
"""

import sys

from tepsipe.errors import InputError
from workflow.support import made
from workflow.support.experiments import EXPERIMENTS
from workflow.support.odd import odd_settings
from workflow.support.recordings import refused_recordings
from workflow.support.start import (
    checked_sections,
    checked_study,
    merged_settings,
    shipped,
    with_its_file,
)


def main(files: list[str]) -> int:
    """Say what the study holds, or in one sentence each what would stop it; 0 or 2."""
    configfiles, config = [shipped(), *files], {}
    try:
        config = merged_settings(configfiles)
        study = checked_study(config, configfiles)
        for key in ("virtual_lab", "reported"):
            checked_sections(config, key)
        found = made.changes(config["pathvars"]["logs"])
        made.refuse_edited(found)
    except InputError as error:
        print(f"tepsipe: {with_its_file(error, config, configfiles)}", file=sys.stderr)
        return 2
    refused = refused_recordings(study)
    for sentence in refused:
        print(f"tepsipe: {sentence}", file=sys.stderr)
    if refused:
        return 2
    for question in odd_settings(study):
        print(f"to be confirmed: {question}")
    counts = ", ".join(f"{len(study.conditions(name))} of {name}" for name in study.experiments)
    trials = "1 trial" if len(study.trials) == 1 else f"{len(study.trials)} trials"
    print(f"{files[-1] if files else shipped()}: {trials} ({counts})")
    print(f"trial sheet: {config['study']['trial_sheet']}; results: {config['pathvars']['results']}")
    left = made.of_no_trial(config["pathvars"]["logs"], study.trials, EXPERIMENTS)
    for what, paths in (("missing or damaged", found.missing + found.damaged), ("of no trial", left)):
        if paths:
            print(f"results that are {what}: {len(paths)}, for example {paths[0]}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
