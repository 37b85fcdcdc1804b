# TEP-SIPE on the ankle dummy: thesis sections 3-1-2 and 4-1-2.

# the trial that is analysed by every combination of choices
SPECIFIED = shown_condition("dummy", SETTINGS["dummy"]["specification"]["condition"])


rule fit_dummy:
    input:
        trial="<results>/trials/dummy/{condition}.h5",
        library=library_of("fit_dummy"),
    output:
        fit="<results>/fits/dummy/{condition}.h5",
        estimates="<results>/estimates/dummy/{condition}.csv",
    log:
        "<logs>/fit_dummy/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        geometry=SETTINGS["dummy"]["geometry"],
        analysis=SETTINGS["dummy"]["analysis"],
        pathways=SETTINGS["dummy"]["pathways"],
        belt_fixed_labels=SETTINGS["dummy"]["foot"]["belt_fixed_labels"],
        seed=config["study"]["seed"],
    script:
        "../scripts/fit_dummy.py"


rule cross_validate_dummy:
    input:
        fits=of_trials("<results>/fits/dummy/{condition}.h5", "dummy"),
        library=library_of("cross_validate_dummy"),
    output:
        matrices="<results>/cross_validation/dummy.h5",
        estimates="<results>/cross_validation/dummy.csv",
    log:
        "<logs>/cross_validate_dummy.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=conditions("dummy"),
    script:
        "../scripts/cross_validate_dummy.py"


rule specify_dummy:
    input:
        trial=f"<results>/trials/dummy/{SPECIFIED}.h5",
        library=library_of("specify_dummy"),
    output:
        table=report(
            "<results>/tables/specification.csv",
            caption="../../report/captions/specification.rst",
            category="TEP-SIPE on the ankle dummy",
            labels={"table": "specifications"},
        ),
    log:
        "<logs>/specify_dummy.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        condition=SPECIFIED,
        geometry=SETTINGS["dummy"]["geometry"],
        analysis=SETTINGS["dummy"]["analysis"],
        foot=SETTINGS["dummy"]["foot"],
        belt=SETTINGS["dummy"]["belt"],
        options={k: v for k, v in SETTINGS["dummy"]["specification"].items() if k != "condition"},
        as_printed=SETTINGS["dummy"]["pathways"][SETTINGS["dummy"]["as_printed"]],
        recommended=SETTINGS["dummy"]["pathways"][SETTINGS["dummy"]["recommended"]],
    script:
        "../scripts/specify_dummy.py"


rule plot_dummy:
    input:
        fits=of_trials("<results>/fits/dummy/{condition}.h5", "dummy"),
        specification="<results>/tables/specification.csv",
        matrices="<results>/cross_validation/dummy.h5",
        library=library_of("plot_dummy"),
    output:
        **figure_files("dummy"),
    log:
        "<logs>/plot_dummy.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=conditions("dummy"),
        example=shown_condition("dummy", SETTINGS["dummy"]["example_condition"]),
        as_printed=SETTINGS["dummy"]["as_printed"],
        recommended=SETTINGS["dummy"]["recommended"],
    script:
        "../scripts/plot_dummy.py"


rule fit_foot:
    input:
        trial="<results>/trials/dummy/{condition}.h5",
        models=expand("<results>/treadmill_models/plate_{load}.json", load=("Fy", "Mx")),
        library=library_of("fit_foot"),
    output:
        fit="<results>/fits/foot/{condition}.h5",
        estimates="<results>/estimates/foot/{condition}.csv",
    log:
        "<logs>/fit_foot/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        geometry=SETTINGS["dummy"]["geometry"],
        analysis=SETTINGS["dummy"]["analysis"],
        foot=SETTINGS["dummy"]["foot"],
        belt=SETTINGS["dummy"]["belt"],
        seed=config["study"]["seed"],
    script:
        "../scripts/fit_foot.py"


rule plot_foot:
    input:
        leg=of_trials("<results>/fits/dummy/{condition}.h5", "dummy"),
        foot=of_trials("<results>/fits/foot/{condition}.h5", "dummy"),
        library=library_of("plot_foot"),
    output:
        **figure_files("foot"),
    log:
        "<logs>/plot_foot.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        conditions=conditions("dummy"),
        recommended=SETTINGS["dummy"]["recommended"],
    script:
        "../scripts/plot_foot.py"
