# How often intervals hold the truth: many laboratories, drawn from what the analysis assumes and from other
# distributions. A job is a whole study of one laboratory, by the same Snakefile.

from tepsipe.virtual_lab.drawn_laboratories import draw_laboratory
from workflow.support.laboratories import Laboratories

LABORATORIES = Laboratories(config)
TABLES = ("coverage", "dropped", "flags", "outcomes", "laboratories")
OUTPUTS = [*(f"<results>/tables/{name}.csv" for name in TABLES), "<results>/report/coverage.pdf"]
FIGURES = [f"<results>/figures/figure_{name}.svg" for name in ("coverage", "coverage_intervals")]


# on a cluster, beside the run itself
localrules:
    collect_coverage,
    plot_coverage,
    write_coverage,
    typeset_report,


rule run_laboratory:
    """Run the study of one drawn laboratory."""
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
        files=lambda w: LABORATORIES.files(int(w.laboratory), draw_laboratory),
    script:
        "../scripts/run_laboratory.py"


rule collect_coverage:
    """Count how often the intervals hold the truth."""
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


rule plot_coverage:
    """Draw the figures of the coverage study."""
    input:
        coverage="<results>/tables/coverage.csv",
        outcomes="<results>/tables/outcomes.csv",
        library=library_of("plot", "tepsipe/reporting/figures.py"),
    output:
        **figure_pairs("figure_coverage", "figure_coverage_intervals"),
    log:
        "<logs>/plot_coverage.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="reporting.figures:draw_coverage",
        first=next(iter(LABORATORIES.sets())),
    script:
        "../scripts/plot.py"


rule write_coverage:
    """Write the numbers of the report on coverage."""
    input:
        fits=[],
        tables=[f"<results>/tables/{name}.csv" for name in ("coverage", "dropped", "flags", "laboratories")],
        provenance=[],
        library=library_of("write_report", *chapter_modules(outputs.OWN_REPORTS["coverage"])),
    output:
        data="<results>/report/coverage.json",
    log:
        "<logs>/write_coverage.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        chapters=outputs.OWN_REPORTS["coverage"],
        settings={},
        study=as_it_is(
            ABOUT_STUDY
            | {
                "code": code_version(CHECKOUT),
                "sets": LABORATORIES.sets(),
                "drawn": LABORATORIES.drawn(),
                "seed": config["coverage"]["seed"],
            }
        ),
    script:
        "../scripts/write_report.py"
