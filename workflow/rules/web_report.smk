# The report as a page for a browser, of every kind of study: from the sources, numbers and tables of its PDF.

from workflow.support.captions import read_captions

WRITTEN_BY = f"write_{STUDY.kind or 'report'}"
REPORT = getattr(rules, WRITTEN_BY)
PAGES = [] if STUDY.kind else outputs.pages(STUDY)
# words of a link -> the same report in another form, and what it rests on
PDFS = [REPORT.output.pdf] if STUDY.kind else REPORT.output.pdf
FORMS = dict(zip(["Report as PDF", "Supplement as PDF"], map(str, PDFS)))
if not STUDY.kind:
    others = {"Provenance": "provenance.json", "Configuration": "config.yaml"}
    FORMS |= {words: f"{config['pathvars']['results']}/{name}" for words, name in others.items()}
# the trial whose forward simulation the page repeats
SIMULATED = (
    [STUDY.shown("dummy", SETTINGS["dummy"]["simulation"]["figure_4_7_condition"])]
    if not STUDY.kind and STUDY.has("simulation")
    else []
)
# what rests on which decision, and the decisions, which explain departures from the thesis
DECISIONS = [
    here("report/decisions.yaml"),
    *sorted(os.path.relpath(path) for path in CHECKOUT.glob("docs/decisions/0*.md")),
]
if not config["study"]["reported"]:
    DECISIONS = []
CAPTIONS = read_captions(CHECKOUT / "report/captions.yaml")


rule write_index:
    """Write the report as a page for a browser."""
    input:
        data=REPORT.output.data,
        tables=REPORT.input.tables,
        figures=REPORT.input.figures,
        numbers=[str(path).removesuffix("svg") + "csv" for path in REPORT.input.figures],
        simulated=[f"<results>/fits/simulation/{condition}.h5" for condition in SIMULATED],
        source=REPORT.input.source,
        rests_on=DECISIONS[:1],
        decisions=DECISIONS[1:],
        citation=here("CITATION.cff"),
        outputs=PAGES,
        library=library_of(
            "write_index",
            *(
                f"tepsipe/drawing/web/{name}"
                for name in (
                    "report.css",
                    "report-math.woff2",
                    "report.js",
                    "swing.js",
                    "explore.js",
                    "theme.js",
                )
            ),
        ),
    output:
        html="<results>/report/index.html",
    log:
        "<logs>/write_index.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        title=as_it_is(config["study"]["title"]),
        main=str(REPORT.params.main),
        statements=as_it_is(reported_of("assertions").get("assertions", [])),
        written_by=WRITTEN_BY,
        kind=STUDY.kind,
        root=lambda w: here("."),
        source_folder=lambda w: here("report"),
        results=as_it_is(config["pathvars"]["results"]),
        configfiles=[path.as_posix() for path in CONFIGFILES[1:]],
        simulated=as_it_is(SIMULATED),
        code=code_version(CHECKOUT),
        forms=as_it_is(FORMS),
        joined=as_it_is({} if STUDY.kind else outputs.joined(STUDY)),
        trials=STUDY.all_conditions() if PAGES else {},
        captions=as_it_is({} if STUDY.kind else {name: CAPTIONS[name] for name in outputs.tables(STUDY)}),
    script:
        "../scripts/write_index.py"
