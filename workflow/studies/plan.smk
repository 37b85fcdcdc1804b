# What an experiment will show before it is done, the best pulse, and the best filter. Designs need no trials;
# filters are also tried on simulated trials, made, ingested and calibrated by the rules of other studies. Several
# joints are those of the person that is planned for: the person's constants are the plan's, no hidden truth.

PLAN = config["plan"]
PLAN_TABLES = (
    *("plan", "pulses", "filters"),
    *("several_joints", "several_joints_elements", "several_joints_models"),
)
SHOWN_TABLES = ("plan", "pulses", "filters", "several_joints")
OUTPUTS = [*(f"<results>/tables/{name}.csv" for name in SHOWN_TABLES), "<results>/report/plan.pdf"]
FIGURES = [
    f"<results>/figures/figure_{name}.svg"
    for name in ("needed", "pulses", "filters", "treadmill_filters", "several_joints")
]


include: "../rules/virtual_lab.smk"
include: "../rules/experiments.smk"
include: "../rules/dummy.smk"
include: "../rules/weight.smk"


rule plan_design:
    """Predict the uncertainty of one design, and check it by simulation."""
    input:
        library=library_of("plan_design"),
    output:
        rows="<results>/designs/{design}.csv",
    log:
        "<logs>/plan_design/{design}.log",
    wildcard_constraints:
        design=any_of(PLAN["designs"]),
    conda:
        "../envs/tepsipe.yaml"
    params:
        plan=lambda w: outputs.plan_of_design(PLAN, w.design),
        geometry=DUMMY["geometry"],
        uncertainty=SETTINGS["uncertainty"]["dummy"],
    script:
        "../scripts/plan_design.py"


rule optimise_pulses:
    """Find the pulse with the least uncertainty."""
    input:
        library=library_of("optimise_pulses"),
    output:
        pulses="<results>/tables/pulses.csv",
        shapes="<results>/tables/pulse_shapes.csv",
    log:
        "<logs>/optimise_pulses.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        plan=without(PLAN, "filters", "draws", "window_draws", "seed", "several_joints"),
        geometry=DUMMY["geometry"],
        uncertainty=SETTINGS["uncertainty"]["dummy"],
    script:
        "../scripts/optimise_pulses.py"


rule sweep_filters:
    """Predict noise and bias behind every filter."""
    input:
        trial="<results>/trials/dummy/{condition}.h5",
        models=lambda w: outputs.plate_models(STUDY, "dummy", w.condition),
        library=library_of("sweep_filters"),
    output:
        windows="<results>/filters/{condition}.csv",
    log:
        "<logs>/sweep_filters/{condition}.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        geometry=DUMMY["geometry"],
        analysis=DUMMY_ANALYSIS,
        foot=without(DUMMY["foot"], "pathways"),
        treadmill_model=DUMMY["foot"]["pathways"]["foot-compensated"]["treadmill_model"],
        belt=lambda w: STUDY.treadmill.belt_of("dummy", w.condition),
        filters=without(PLAN["filters"], "design"),
    script:
        "../scripts/sweep_filters.py"


rule make_several_joints:
    """Simulate the responses of a person with three joints."""
    input:
        library=library_of("make_several_joints"),
    output:
        trials="<results>/trials/several_joints.h5",
    log:
        "<logs>/make_several_joints.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        joints=pick(PLAN["several_joints"], "persons", "person", "perturbations", "protocol"),
        seed=PLAN["seed"],
        engine=config["dummy"]["simulation"]["engine"],
    script:
        "../scripts/make_several_joints.py"


rule plan_several_joints:
    """Predict which matrices of stiffness and damping a set of perturbations determines."""
    input:
        trials="<results>/trials/several_joints.h5",
        library=library_of("plan_several_joints"),
    output:
        sets="<results>/tables/several_joints.csv",
        elements="<results>/tables/several_joints_elements.csv",
        models="<results>/tables/several_joints_models.csv",
    log:
        "<logs>/plan_several_joints.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        joints=PLAN["several_joints"],
        seed=PLAN["seed"],
    script:
        "../scripts/plan_several_joints.py"


rule collect_plan:
    """Join the predictions of all designs."""
    input:
        designs=[f"<results>/designs/{name}.csv" for name in PLAN["designs"]],
        windows=STUDY.of_trials("<results>/filters/{condition}.csv", "dummy"),
        truth=STUDY.of_trials("<results>/truth/dummy/{condition}.h5", "dummy"),
        library=library_of("collect_plan"),
    output:
        plan="<results>/tables/plan.csv",
        filters="<results>/tables/filters.csv",
    log:
        "<logs>/collect_plan.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        plan=without(PLAN, "several_joints"),
        conditions=STUDY.conditions("dummy"),
        geometry=DUMMY["geometry"],
        uncertainty=SETTINGS["uncertainty"]["dummy"],
    script:
        "../scripts/collect_plan.py"


rule plot_planning:
    """Draw the figures of the plan."""
    input:
        plan="<results>/tables/plan.csv",
        shapes="<results>/tables/pulse_shapes.csv",
        filters="<results>/tables/filters.csv",
        library=library_of("plot", "tepsipe/experiments/planning/figures.py"),
    output:
        **figure_pairs("figure_needed", "figure_pulses", "figure_filters", "figure_treadmill_filters"),
    log:
        "<logs>/plot_planning.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.planning.figures:draw_planning",
    script:
        "../scripts/plot.py"


rule plot_several_joints:
    """Draw the prediction for several joints."""
    input:
        sets="<results>/tables/several_joints.csv",
        elements="<results>/tables/several_joints_elements.csv",
        library=library_of("plot", "tepsipe/experiments/planning/figures.py"),
    output:
        **figure_pairs("figure_several_joints"),
    log:
        "<logs>/plot_several_joints.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        drawn_by="experiments.planning.figures:draw_several_joints",
        limits=PLAN["several_joints"]["limits"],
    script:
        "../scripts/plot.py"


rule write_plan:
    """Write the numbers of the report of the plan."""
    input:
        fits=[],
        tables=[f"<results>/tables/{name}.csv" for name in PLAN_TABLES],
        provenance=[],
        library=library_of("write_report", *chapter_modules(outputs.OWN_REPORTS["plan"])),
    output:
        data="<results>/report/plan.json",
    log:
        "<logs>/write_plan.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        chapters=outputs.OWN_REPORTS["plan"],
        settings={"plan": pick(PLAN, "seed", "several_joints")},
        study=as_it_is(ABOUT_STUDY | {"code": code_version(CHECKOUT)}),
    script:
        "../scripts/write_report.py"
