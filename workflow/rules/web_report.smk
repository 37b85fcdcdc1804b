# The report of every kind of study as PDFs and as a page for a browser, from the same sources, numbers and tables.

from workflow.support.captions import read_captions

WRITTEN_BY = f"write_{STUDY.kind or 'report'}"
REPORT = getattr(rules, WRITTEN_BY)
PAGES = [] if STUDY.kind else outputs.pages(STUDY)
# the article or the only document, and the supplement
PDFS = [f"<results>/report/{STUDY.kind or config['study']['name']}.pdf"]
# words of a link -> what the page rests on
OTHERS = {}
if not STUDY.kind:
    PDFS += outputs.supplement(STUDY)
    OTHERS = {"Provenance": "<results>/provenance.json", "Configuration": "<results>/config.yaml"}
FORMS = dict(zip(["Report as PDF", "Supplement as PDF"], PDFS)) | OTHERS
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


rule typeset_report:
    """Typeset the report as a PDF, and the supplement of the article."""
    input:
        data=REPORT.output.data,
        tables=REPORT.input.tables,
        figures=FIGURES,
        source=report_sources(),
        library=library_of("typeset_report"),
    output:
        pdf=PDFS,
    log:
        "<logs>/typeset_report.log",
    conda:
        "../envs/tepsipe.yaml"
    params:
        main=f"{STUDY.kind or 'report'}.typ",
        source_folder=lambda w: here("report"),
    script:
        "../scripts/typeset_report.py"


rule write_index:
    """Write the report as a page for a browser."""
    input:
        data=REPORT.output.data,
        tables=REPORT.input.tables,
        figures=FIGURES,
        numbers=[path.removesuffix("svg") + "csv" for path in FIGURES],
        simulated=[f"<results>/fits/simulation/{condition}.h5" for condition in SIMULATED],
        source=report_sources(),
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
        main=rules.typeset_report.params.main,
        statements=as_it_is(reported_of("assertions").get("assertions", [])),
        written_by=WRITTEN_BY,
        kind=STUDY.kind,
        root=lambda w: here("."),
        source_folder=lambda w: here("report"),
        results=as_it_is(config["pathvars"]["results"]),
        configfiles=[path.as_posix() for path in CONFIGFILES[1:]],
        simulated=as_it_is(SIMULATED),
        code=code_version(CHECKOUT),
        forms=as_it_is(
            {
                words: path.replace("<results>", config["pathvars"]["results"])
                for words, path in FORMS.items()
            }
        ),
        joined=as_it_is({} if STUDY.kind else outputs.joined(STUDY)),
        trials=STUDY.all_conditions() if PAGES else {},
        captions=as_it_is({} if STUDY.kind else {name: CAPTIONS[name] for name in outputs.tables(STUDY)}),
    script:
        "../scripts/write_index.py"
