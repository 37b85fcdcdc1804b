"""Results of a study as its report reads them, and faults that a reader would find in a report."""

import csv
import io
import json
import re

from typst_builders import page_of, plain_words, tables_of

from tepsipe.drawing.names import by_uncertainty, number


def run_of(results):
    """Run of results, whose tables and fits may be altered, and modules of the chapters of its report."""
    from workflow.scripts.typeset import chapters, read_run

    data = json.loads((results / "report/report.json").read_text(encoding="utf-8"))
    names = [(group, name) for group, own in data["facts"].items() for name in own]
    places = [results / f"fits/{group}/{name}.h5" for group, name in names]
    places += [results / f"fits/{name}.h5" for group, name in names if group == name]
    fits = [str(path) for path in places if path.is_file()]
    files = {name: str(path) for name, path in tables_of(results).items()}
    run = read_run(files, fits, data["choices"], data["study"], str(results / "provenance.json"))
    return run, chapters(data["chapters"])


def faults_of_study(results):
    """Faults of the report of a study that has run, by its data and tables."""
    data = json.loads((results / "report/report.json").read_text(encoding="utf-8"))
    estimates = (results / "tables/estimates.csv").read_text(encoding="utf-8")
    return faults_of(page_of(data, tables_of(results)), estimates)


def faults_of(page, estimates):
    """Sentences with what must not be in a report: the thesis, a dash for a value, a number without its mark.

    page: the report as HTML.
    estimates: text of its table of estimates.
    """
    page = re.sub(r"(?s)<(script|style)\b.*?</\1>", "", page)
    texts = [plain_words(part) for part in re.split(r"</?(?:p|li|td|th|tr|figcaption|div|h\d|dd|dt)\b", page)]
    texts += re.findall(r' (?:alt|aria-label)="([^"]*)"', page)
    texts = [re.sub(r"^[^<>]*>", "", text).strip() for text in texts]
    found = [text for text in texts if re.search("thesis", text, re.IGNORECASE)]
    found += [text for text in texts if re.search(r"(?<!\w)\N{EN DASH}(?!\w)", text) and len(text) > 3]
    words = plain_words(re.sub(r"</t[dh]>", " | ", page))
    rows = list(csv.DictReader(io.StringIO(estimates)))
    clean = {printed(row) for row in rows if row["recommended"] == "true" and not row["flags"]}
    for row in rows:
        marks = ("†" if row["flags"] else "") + ("‡" if row["recommended"] != "true" else "")
        text = printed(row)
        if not marks or text is None or text in clean:
            continue
        after = re.findall(rf"(?<![\d.]){re.escape(text)}([†‡]*)", words)
        found += [f"{text} without {mark}" for one in after for mark in marks if mark not in one]
    return found


def printed(row):
    """An estimate with its interval as reports print it; None without an interval."""
    if not row["value"] or not row["ci_low"]:
        return None
    value, ends = by_uncertainty(*(float(row[name]) for name in ("value", "ci_low", "ci_high")))
    return f"{value} ({ends})" if ends else number(float(row["value"]))
