"""The report as a page for a browser, from the same sources, numbers and tables as the PDF."""

import job

job.start(snakemake)

import json
from pathlib import Path

import yaml
from typeset import report_files, source_files, table_files, typeset_page

from tepsipe.drawing.trial_page import table
from tepsipe.io.estimates import ESTIMATES, RECOVERIES
from tepsipe.io.result import read_result
from tepsipe.reporting.claims import CLAIM_VERDICTS
from tepsipe.reporting.ledger import CELL_VERDICTS
from tepsipe.reporting.page_parts import explored, ledger_table, trial_rows, trials_table
from tepsipe.reporting.report_page import (
    ReportPage,
    about_code,
    inline,
    link,
    made_again,
    picture_size,
    record_of,
    render_report,
)
from workflow.support.origins import ReportOrigins, Sources, chapters_of, repository_at, study_command

given, params = snakemake.input, snakemake.params
tables = table_files(given.tables)
sources = source_files(given.source, params.source_folder)
choices = json.loads(Path(given.data).read_text(encoding="utf-8")).get("choices", {})
truth = RECOVERIES.read(tables["recovery"]) if "recovery" in tables else []
made = ReportOrigins(
    Sources(params.root, params.kind),
    snakemake.output.html,
    tables,
    given.data,
    params.written_by,
    params.configfiles,
    params.joined,
)

estimates = ESTIMATES.read(tables["estimates"]) if "estimates" in tables else []
parts = {}
if params.trials:
    parts["trials"] = ("Results of every trial", trials_table(trial_rows(params.trials, estimates, truth)))
if "claims" in tables or "cells" in tables:
    claims = CLAIM_VERDICTS.read(tables["claims"]) if "claims" in tables else []
    cells = CELL_VERDICTS.read(tables["cells"]) if "cells" in tables else []
    parts["ledger"] = ("Statements and numbers of the thesis", ledger_table(params.statements, claims, cells))
# tables of the run, also those that the report does not read
run_tables = {name: f"{params.results}/tables/{name}.csv" for name in params.captions} or tables
listed = [
    [link(made.beside(path), f"{name}.csv"), inline(params.captions.get(name, "").replace("``", "`"))]
    for name, path in run_tables.items()
]
parts["tables-of-the-run"] = ("Tables of the run", table(("Table", "Content"), listed))
parts["make-again"] = ("Command, code, own recordings", made_again(study_command(params.configfiles)))

tried = {}
if "specification" in tables:
    simulated = dict(zip(params.simulated, map(read_result, given.simulated), strict=True))
    tried = explored(choices["dummy"]["geometry"], tables["specification"], estimates, truth, simulated)
origins = made.of_report(
    dict(zip(given.figures, given.numbers, strict=True)),
    chapters_of(f"{params.root}/report", sources, params.main),
    {"trials": ("trials_table", ("estimates", "recovery")), "ledger": ("ledger_table", ("claims", "cells"))},
)
page = ReportPage(
    title=params.title,
    facts=about_code(yaml.safe_load(Path(given.citation).read_text(encoding="utf-8")), params.code),
    files={words: made.beside(path) for words, path in params.forms.items()},
    sizes={f"../figures/{Path(path).name}": picture_size(path) for path in given.figures},
    source=params.main,
    origins=origins,
    functions=made.sources.functions(origins.values()),
    repository="" if params.code["modified"] else repository_at(params.root, params.code["commit"]),
    rests_on={
        anchor: numbers
        for path in given.rests_on
        for anchor, numbers in yaml.safe_load(Path(path).read_text(encoding="utf-8")).items()
    },
    decisions={int(Path(path).name[:4]): record_of(path) for path in given.decisions},
    parts=parts,
    explored=tried,
)
files = sources | report_files(given.data, tables, given.figures)
html = render_report(typeset_page(files, params.main), page)
Path(snakemake.output.html).write_text(html, encoding="utf-8", newline="\n")
