# The study's table of contents: from raw trial files to the thesis as a PDF.
#
#   snakemake -c2                   the whole study
#   snakemake -c2 dummy/sine-0.3    one condition alone: its estimates, figures and page


from snakemake.utils import min_version

min_version("9.14")


# refuses configuration files that cannot be read as they are meant; lets one run at a time into a folder
include: "workflow/rules/configuration.smk"


configfile: str(CONFIGFILES[0])


# checks the configuration and the trial sheet, and says what there is to do
include: "workflow/rules/common.smk"
# looks after the results of earlier runs
include: "workflow/rules/run.smk"


# studies with rules and a report of their own: how often intervals hold the truth (coverage), what an experiment
# will show (plan), the ankle in walking (walking)
if STUDY.kind:

    include: f"workflow/studies/{STUDY.kind}.smk"

else:

    # chapter 2: the rigs, where no recordings exist
    include: "workflow/rules/virtual_lab.smk"
    # raw files of any origin to one HDF5 file per trial
    include: "workflow/rules/experiments.smk"
    # sections 3-1-1 and 4-1-1: the joint in the torque-controlled manipulator
    include: "workflow/rules/wristalyzer.smk"
    # sections 3-1-2 and 4-1-2: TEP-SIPE on the ankle dummy
    include: "workflow/rules/dummy.smk"
    # sections 3-1-2 and 4-1-2: what the treadmill adds to the force, and models of it
    include: "workflow/rules/weight.smk"
    # sections 2-1 and 2-2: the rigs, and time lines of the trials
    include: "workflow/rules/rigs.smk"
    # sections 2-1-3 and 4-1-3: the dummy in a forward simulation
    include: "workflow/rules/simulation.smk"
    # sections 3-1-3 and 4-1-3: sensitivity to measurement noise
    include: "workflow/rules/noise.smk"
    # sections 2-2, 3-2 and 4-2: a person standing on the treadmill
    include: "workflow/rules/standing.smk"
    # participants of any experiment: values per person, means over people
    include: "workflow/rules/participants.smk"
    # a treadmill of your own
    include: "workflow/rules/belt.smk"
    include: "workflow/rules/operating_points.smk"
    # tables across experiments, and where truth meets estimate
    include: "workflow/rules/tables.smk"
    # the PDF
    include: "workflow/rules/report.smk"
    # a page per trial, and names of trials as targets
    include: "workflow/rules/pages.smk"

    OUTPUTS = [*outputs.everything(STUDY), *outputs.pages(STUDY)]


# the report as a page for a browser, of all studies
include: "workflow/rules/web_report.smk"


rule all:
    """Make the whole study."""
    default_target: True
    input:
        OUTPUTS,
        "<results>/report/index.html",
        AGAIN,


onstart:
    begin()


onsuccess:
    succeed()


onerror:
    fail(log)
