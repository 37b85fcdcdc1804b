# The run itself: what earlier ones have left and made, and what is said at the end.

import atexit

from workflow.support import job_outputs
from workflow.support.stopped import what_stopped

# contents of recordings, and those that have changed since the last run
CONTENTS, CHANGED = job_outputs.contents(
    chain.from_iterable(row.files.values() for row in STUDY.trials.values()),
    dry=runs.looks(sys.argv) or runs.is_dry(sys.argv),
)
AGAIN = []  # results that are missing or damaged, which Snakemake makes again only if it is asked for them
try:
    if not runs.looks(sys.argv):
        dry = runs.is_dry(sys.argv)
        if not dry:
            runs.refuse_a_lock()
        if CHANGED:
            more = f" and {len(CHANGED) - 1} more" if len(CHANGED) > 1 else ""
            print(f"tepsipe: recording changed, analysed again: {CHANGED[0]}{more}", file=sys.stderr)
        changes = job_outputs.changes(config["pathvars"]["logs"])
        job_outputs.refuse_edited(changes)
        # a run that is given a trial makes what this needs
        AGAIN = [] if NAMED else job_outputs.remade(changes, config, workflow.main_snakefile, sys.argv, dry)
except InputError as error:
    sys.exit(f"tepsipe: {error}")
except OSError as error:
    sys.exit(f"tepsipe: {runs.refused_by_the_system(error, error.filename or Path.cwd())}")


def contents_of(experiment, condition=None):
    """Param function: kind -> SHA-256 of the recorded files of the trial, or of another one."""
    return lambda w: {
        kind: CONTENTS[path]
        for kind, path in STUDY.trials[experiment, condition or w.condition].files.items()
    }


def begin():
    """Before the first job."""
    try:
        runs.refuse_interpreter()
    except InputError as error:
        sys.exit(f"tepsipe: {error}")
    runs.note_run()


def succeed():
    """After the last job: results of no trial are named; the last line is the path of the page to open."""
    runs.forget_run()
    left = job_outputs.of_no_trial(config["pathvars"]["logs"], STUDY.trials, EXPERIMENTS)
    if left:
        more = f" and {len(left) - 1} more" if len(left) > 1 else ""
        print(f"tepsipe: of no trial of the sheet, not needed: {left[0]}{more}", file=sys.stderr)
    page = Path(config["pathvars"]["results"]) / "report/index.html"
    if page.is_file():
        sys.stdout.reconfigure(errors="backslashreplace")  # its folder may have a name that cannot be shown
        atexit.register(print, page.absolute())  # after Snakemake's own last line


def fail(log):
    """After a failed run: the sentence of every job that stopped, and where a bug left its trace."""
    runs.forget_run()
    print("\nWhat stopped:", *what_stopped(next(iter(log), ".snakemake/log")), sep="\n", file=sys.stderr)
    print("Everything else is kept; the next run goes on from there.", file=sys.stderr)
