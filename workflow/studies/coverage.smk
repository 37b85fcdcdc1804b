# How often intervals hold the truth: many laboratories, drawn from what the analysis assumes and from other
# distributions. A job is a whole study of one laboratory, by the same Snakefile.

from workflow.support.laboratories import Laboratories

LABORATORIES = Laboratories(config)
TABLES = ("coverage", "dropped", "flags", "outcomes", "laboratories")
OUTPUTS = [*(f"<results>/tables/{name}.csv" for name in TABLES), "<results>/report/coverage.pdf"]


# on a cluster, beside the run itself
localrules:
    collect_coverage,
    write_coverage,


rule run_laboratory:
    input:
        source=laboratory_sources(),
        library=library_of("run_laboratory"),
    output:
        laboratory="<results>/laboratories/{laboratory}/laboratory.json",
        estimates="<results>/laboratories/{laboratory}/estimates.csv",
        uncertainty="<results>/laboratories/{laboratory}/uncertainty.csv",
        recovery="<results>/laboratories/{laboratory}/recovery.csv",
    log:
        "<logs>/run_laboratory/{laboratory}.log",
    wildcard_constraints:
        laboratory="[0-9]+",
    group:
        "laboratories"
    conda:
        "../envs/tepsipe.yaml"
    resources:
        laboratories=1,
    params:
        about=lambda w: LABORATORIES.about(int(w.laboratory)),
        files=lambda w: LABORATORIES.files(int(w.laboratory)),
    script:
        "../scripts/run_laboratory.py"


rule collect_coverage:
    input:
        laboratories=LABORATORIES.all("laboratory.json"),
        estimates=LABORATORIES.all("estimates.csv"),
        uncertainty=LABORATORIES.all("uncertainty.csv"),
        recovery=LABORATORIES.all("recovery.csv"),
        library=library_of("collect_coverage"),
    output:
        coverage="<results>/tables/coverage.csv",
        dropped="<results>/tables/dropped.csv",
        flags="<results>/tables/flags.csv",
        outcomes="<results>/tables/outcomes.csv",
        laboratories="<results>/tables/laboratories.csv",
    log:
        "<logs>/collect_coverage.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        pooled=STUDY.tasks.names(),
        also_evaluated=config["coverage"]["also_evaluated"],
        sets=list(LABORATORIES.sets()),
        windows_s=STUDY.estimators.windows(),
    script:
        "../scripts/collect_coverage.py"


rule write_coverage:
    input:
        source=report_sources(),
        coverage="<results>/tables/coverage.csv",
        dropped="<results>/tables/dropped.csv",
        flags="<results>/tables/flags.csv",
        outcomes="<results>/tables/outcomes.csv",
        laboratories="<results>/tables/laboratories.csv",
        library=library_of("write_coverage"),
    output:
        pdf="<results>/report/coverage.pdf",
        data="<results>/report/coverage.json",
        shares="<results>/figures/figure_coverage.svg",
        shares_png="<results>/figures/figure_coverage.png",
        intervals="<results>/figures/figure_coverage_intervals.svg",
        intervals_png="<results>/figures/figure_coverage_intervals.png",
    log:
        "<logs>/write_coverage.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        title=as_it_is(config["study"]["title"]),
        sets=LABORATORIES.sets(),
        drawn=LABORATORIES.drawn(),
        experiments=STUDY.all_conditions(),
        code=code_version(workflow.basedir),
        seed=config["coverage"]["seed"],
        source_folder=lambda w: here("report"),
    script:
        "../scripts/write_coverage.py"
