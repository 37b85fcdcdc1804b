# The numbers of the report: of the article on the thesis and its supplement, or of other recordings.

import json

from workflow.support.imported_files import checksums

# the kept campaign of coverage, which the report of the thesis's simulated study quotes
CAMPAIGN = [here(f"benchmarks/coverage/{name}") for name in ("coverage.csv", "campaign.json")]
if not (
    config["study"]["reported"] and any(STUDY.all_simulated().values()) and all(map(os.path.exists, CAMPAIGN))
):
    CAMPAIGN = []
# kept studies with other force plates, which it quotes, too
PLATES = [here("benchmarks/plate_constants.csv")]
if not (CAMPAIGN and STUDY.has("weight") and all(map(os.path.exists, PLATES))):
    PLATES = []
FIGURES = outputs.figures(STUDY)


rule record_provenance:
    """Record versions, seeds and checksums of the run."""
    input:
        trials=outputs.trials(STUDY),
        library=library_of("record_provenance"),
    output:
        provenance="<results>/provenance.json",
        config="<results>/config.yaml",
    log:
        "<logs>/record_provenance.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        config=config,
        # no inputs, which Snakemake refuses if they are dated in the future
        files=as_it_is(
            checksums(
                {
                    "trial sheet": config["study"]["trial_sheet"],
                    "virtual laboratory": config["study"]["virtual_lab"],
                    "base of the virtual laboratory": base_of(config["study"]["virtual_lab"]),
                    "reported values": config["study"]["reported"],
                    "participants": config["study"]["participants"],
                    # the pinned environment of a checkout
                    "requirements": (
                        here("requirements.txt") if (CHECKOUT / "requirements.txt").is_file() else None
                    ),
                }
            )
        ),
        code=code_version(CHECKOUT),
        engine=ENGINE,
    script:
        "../scripts/record_provenance.py"


rule write_report:
    """Write the numbers of the report."""
    input:
        fits=outputs.report_fits(STUDY),
        tables=outputs.report_tables(STUDY) + CAMPAIGN[:1] + PLATES,
        provenance="<results>/provenance.json",
        library=library_of("write_report", *chapter_modules(outputs.chapters(STUDY))),
    output:
        data="<results>/report/report.json",
    log:
        "<logs>/write_report.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        chapters=outputs.chapters(STUDY),
        settings=report_params.printed(STUDY),
        study=as_it_is(
            ABOUT_STUDY
            | {
                "reported": (
                    reported_of("tables", "values", "slips", "simulations", "assertions")
                    if STUDY.repeats_thesis
                    else None
                ),
                "campaign": json.loads(Path(CAMPAIGN[1]).read_text("utf-8")) if CAMPAIGN else None,
                "best": STUDY.shown("wristalyzer", SETTINGS["wristalyzer"]["best_condition"]),
                "start_stiffness": SETTINGS["wristalyzer"]["analysis"]["start"]["K_Nm_per_rad"],
                "step_s": SETTINGS["dummy"]["simulation"]["step_s"],
                "engine": ENGINE,
                "planned_joint": SETTINGS["noise"]["joint"],
                "simulated": {
                    f"4_{k}": STUDY.shown(
                        "dummy", SETTINGS["dummy"]["simulation"][f"figure_4_{k}_condition"]
                    )
                    for k in (7, 8)
                },
                "amplitudes": STUDY.amplitudes("dummy"),
                "timing": STUDY.timing(),
                "roles": STUDY.roles("belt"),
                "models": outputs.model_names(STUDY),
                "belt_of_models": (
                    STUDY.treadmill.plates().get(STUDY.shown_plate()) if STUDY.by_belt else None
                ),
                "foot_pathway": STUDY.estimators.budgeted_foot(),
                "tasks": STUDY.tasks.names(),
                "shown_of_participants": groups.shown_estimators(STUDY),
            }
        ),
    script:
        "../scripts/write_report.py"
