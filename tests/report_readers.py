"""Faults that a reader would find in the report of a study of other recordings."""

import csv
import io
import json
import re

from typst_builders import page_of, plain_words, tables_of

from tepsipe.drawing.names import by_uncertainty, number


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
