# The run itself: what earlier ones have left and made, and what is said at the end.

import atexit

from workflow.support.stopped import what_stopped

AGAIN = []  # results that are missing or damaged, which Snakemake makes again only if it is asked for them
try:
    if not runs.looks(sys.argv):
        dry = runs.is_dry(sys.argv)
        if not dry:
            runs.refuse_a_lock()
        recordings = [path for path in CHANGED if path not in FILES_OF_STUDY.values()]
        if recordings:
            more = f" and {len(recordings) - 1} more" if len(recordings) > 1 else ""
            print(f"tepsipe: recording changed, analysed again: {recordings[0]}{more}", file=sys.stderr)
        changes = job_outputs.changes(config["pathvars"]["logs"])
        job_outputs.refuse_edited(changes)
        # a run that is given a trial makes what this needs
        AGAIN = [] if NAMED else job_outputs.remade(changes, config, workflow.main_snakefile, sys.argv, dry)
except InputError as error:
    sys.exit(f"tepsipe: {error}")


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
