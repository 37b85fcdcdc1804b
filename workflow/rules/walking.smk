# The ankle in the stance phase of walking: belt pulses at random strides. It has a trial sheet of its own.

from workflow.support.walking import read_walking_sheet

WALKING = config["walking"]

try:
    WALKING_TRIALS = read_walking_sheet(WALKING["trial_sheet"], config["study"]["recordings_folder"])
except InputError as error:
    sys.exit(f"tepsipe: {error}")


# where a study is called walking
ruleorder: write_walking > write_report


rule fit_walking:
    input:
        raw=lambda w: [p for p in vars(WALKING_TRIALS[w.walk]).values() if os.path.exists(p)],
        library=library_of("fit_walking"),
    output:
        rows="<results>/estimates/walking/{walk}.csv",
        needed="<results>/estimates/walking/{walk}_needed.csv",
        about="<results>/estimates/walking/{walk}.json",
    log:
        "<logs>/fit_walking/{walk}.log",
    wildcard_constraints:
        walk=any_of(WALKING_TRIALS),
    conda:
        "../envs/tepsipe.yaml"
    params:
        recording=lambda w: WALKING_TRIALS[w.walk].recording,
        events=lambda w: WALKING_TRIALS[w.walk].events,
        settings=without(WALKING, "trial_sheet"),
        seed=SEED,
    script:
        "../scripts/fit_walking.py"


rule write_walking:
    input:
        source=report_sources(),
        rows=[f"<results>/estimates/walking/{walk}.csv" for walk in WALKING_TRIALS],
        needed=[f"<results>/estimates/walking/{walk}_needed.csv" for walk in WALKING_TRIALS],
        about=[f"<results>/estimates/walking/{walk}.json" for walk in WALKING_TRIALS],
        library=library_of("write_walking"),
    output:
        rows="<results>/tables/walking.csv",
        needed="<results>/tables/needed.csv",
        figure="<results>/figures/figure_walking.svg",
        figure_png="<results>/figures/figure_walking.png",
        data="<results>/report/walking.json",
        pdf="<results>/report/walking.pdf",
    log:
        "<logs>/write_walking.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        title=as_it_is(config["study"]["title"]),
        recordings_source=as_it_is(config["study"]["recordings_source"]),
        planned=WALKING["planned"],
        code=code_version(workflow.basedir),
        source_folder=lambda w: here("report"),
    script:
        "../scripts/write_walking.py"
