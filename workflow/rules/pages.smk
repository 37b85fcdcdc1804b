# A page per trial for a web browser, all of an experiment in one job.

PAGE, PICTURE = (f"<results>/report/trials/{{}}/{{{{condition}}}}.{kind}" for kind in ("html", "svg"))
TRUTH = outputs.recovery(STUDY)[:1]
PAGE_SOURCE = [here(f"tepsipe/reporting/pages/{name}") for name in ("plot.js", "page.css", "theme.js")]
TITLE = as_it_is(config["study"]["title"])


rule write_wristalyzer_pages:
    input:
        trials=STUDY.of_trials("<results>/trials/wristalyzer/{condition}.h5", "wristalyzer"),
        fits=STUDY.of_trials("<results>/fits/wristalyzer/{condition}.h5", "wristalyzer"),
        estimates=STUDY.of_trials("<results>/estimates/wristalyzer/{condition}.csv", "wristalyzer"),
        truth=TRUTH,
        source=PAGE_SOURCE,
        library=library_of("write_pages", "tepsipe/reporting/pages/wristalyzer.py"),
    output:
        pages=STUDY.of_trials(PAGE.format("wristalyzer"), "wristalyzer"),
        pictures=STUDY.of_trials(PICTURE.format("wristalyzer"), "wristalyzer"),
    log:
        "<logs>/write_wristalyzer_pages.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        composed_by="wristalyzer",
        chapter="wristalyzer",
        title=TITLE,
        trials=report_params.described(STUDY, "wristalyzer"),
    script:
        "../scripts/write_pages.py"


rule write_dummy_pages:
    input:
        trials=STUDY.of_trials("<results>/trials/dummy/{condition}.h5", "dummy"),
        fits=STUDY.of_trials("<results>/fits/dummy/{condition}.h5", "dummy"),
        estimates=STUDY.of_trials("<results>/estimates/dummy/{condition}.csv", "dummy"),
        foot=STUDY.of_foot("<results>/fits/foot/{condition}.h5"),
        foot_estimates=STUDY.of_foot("<results>/estimates/foot/{condition}.csv"),
        truth=TRUTH,
        source=PAGE_SOURCE,
        library=library_of("write_pages", "tepsipe/reporting/pages/dummy.py"),
    output:
        pages=STUDY.of_trials(PAGE.format("dummy"), "dummy"),
        pictures=STUDY.of_trials(PICTURE.format("dummy"), "dummy"),
    log:
        "<logs>/write_dummy_pages.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        composed_by="dummy",
        chapter="dummy",
        title=TITLE,
        trials=report_params.described(STUDY, "dummy"),
        recommended=DUMMY["recommended"],
    script:
        "../scripts/write_pages.py"


rule write_weight_pages:
    input:
        trials=STUDY.of_trials("<results>/trials/weight/{condition}.h5", "weight"),
        fits=STUDY.of_trials("<results>/fits/weight/{condition}.h5", "weight"),
        estimates=STUDY.of_trials("<results>/estimates/weight/{condition}.csv", "weight"),
        plates=outputs.plate_fits(STUDY),
        truth=TRUTH,
        source=PAGE_SOURCE,
        library=library_of("write_pages", "tepsipe/reporting/pages/weight.py"),
    output:
        pages=STUDY.of_trials(PAGE.format("weight"), "weight"),
        pictures=STUDY.of_trials(PICTURE.format("weight"), "weight"),
    log:
        "<logs>/write_weight_pages.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        composed_by="weight",
        chapter="weight",
        title=TITLE,
        experiment="weight",
        belts=list(STUDY.treadmill.plates().values()),
        trials=report_params.described(STUDY, "weight"),
    script:
        "../scripts/write_pages.py"


use rule write_weight_pages as write_empty_pages with:
    input:
        trials=STUDY.of_trials("<results>/trials/empty/{condition}.h5", "empty"),
        fits=STUDY.of_trials("<results>/fits/empty/{condition}.h5", "empty"),
        estimates=STUDY.of_trials("<results>/estimates/empty/{condition}.csv", "empty"),
        plates=[],
        truth=TRUTH,
        source=PAGE_SOURCE,
        library=library_of("write_pages", "tepsipe/reporting/pages/weight.py"),
    output:
        pages=STUDY.of_trials(PAGE.format("empty"), "empty"),
        pictures=STUDY.of_trials(PICTURE.format("empty"), "empty"),
    log:
        "<logs>/write_empty_pages.log",
    params:
        composed_by="weight",
        chapter="weight",
        title=TITLE,
        experiment="empty",
        belts=[],
        trials=report_params.described(STUDY, "empty"),


rule write_standing_pages:
    input:
        trials=STUDY.of_trials("<results>/trials/standing/{condition}.h5", "standing"),
        fits=STUDY.of_trials("<results>/fits/standing/{condition}.h5", "standing"),
        estimates=STUDY.of_trials("<results>/estimates/standing/{condition}.csv", "standing"),
        epochs=STUDY.of_trials("<results>/epochs/standing/{condition}.h5", "standing"),
        truth=TRUTH,
        source=PAGE_SOURCE,
        library=library_of("write_pages", "tepsipe/reporting/pages/standing.py"),
    output:
        pages=STUDY.of_trials(PAGE.format("standing"), "standing"),
        pictures=STUDY.of_trials(PICTURE.format("standing"), "standing"),
    log:
        "<logs>/write_standing_pages.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        composed_by="standing",
        chapter="standing",
        title=TITLE,
        trials=report_params.described(STUDY, "standing"),
        recommended=STANDING["recommended"],
    script:
        "../scripts/write_pages.py"


rule write_position_manipulator_pages:
    input:
        trials=STUDY.of_trials("<results>/trials/position_manipulator/{condition}.h5", "position_manipulator"),
        fits=STUDY.of_trials("<results>/fits/position_manipulator/{condition}.h5", "position_manipulator"),
        estimates=STUDY.of_trials(
            "<results>/estimates/position_manipulator/{condition}.csv", "position_manipulator"
        ),
        truth=TRUTH,
        source=PAGE_SOURCE,
        library=library_of("write_pages", "tepsipe/reporting/pages/position_manipulator.py"),
    output:
        pages=STUDY.of_trials(PAGE.format("position_manipulator"), "position_manipulator"),
        pictures=STUDY.of_trials(PICTURE.format("position_manipulator"), "position_manipulator"),
    log:
        "<logs>/write_position_manipulator_pages.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        composed_by="position_manipulator",
        chapter="position-manipulator",
        title=TITLE,
        trials=report_params.described(STUDY, "position_manipulator"),
    script:
        "../scripts/write_pages.py"


rule write_platform_pages:
    input:
        trials=STUDY.of_trials("<results>/trials/platform/{condition}.h5", "platform"),
        fits=STUDY.of_trials("<results>/fits/platform/{condition}.h5", "platform"),
        estimates=STUDY.of_trials("<results>/estimates/platform/{condition}.csv", "platform"),
        truth=TRUTH,
        source=PAGE_SOURCE,
        library=library_of("write_pages", "tepsipe/reporting/pages/platform.py"),
    output:
        pages=STUDY.of_trials(PAGE.format("platform"), "platform"),
        pictures=STUDY.of_trials(PICTURE.format("platform"), "platform"),
    log:
        "<logs>/write_platform_pages.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        composed_by="platform",
        chapter="platform",
        title=TITLE,
        trials=report_params.described(STUDY, "platform"),
    script:
        "../scripts/write_pages.py"


rule write_belt_pages:
    input:
        trials=STUDY.of_trials("<results>/trials/belt/{condition}.h5", "belt"),
        fit=outputs.model_files(STUDY, "belt")[:1],
        truth=TRUTH,
        source=PAGE_SOURCE,
        library=library_of("write_pages", "tepsipe/reporting/pages/belt.py"),
    output:
        pages=STUDY.of_trials(PAGE.format("belt"), "belt"),
        pictures=STUDY.of_trials(PICTURE.format("belt"), "belt"),
    log:
        "<logs>/write_belt_pages.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        composed_by="belt",
        chapter="treadmill",
        title=TITLE,
        trials=report_params.described(STUDY, "belt"),
        model=SETTINGS["belt"]["chosen"],
    script:
        "../scripts/write_pages.py"
