"""The report as a page for a browser: its words, anchors and origins; no name of a user breaks it."""

import re
import unicodedata
from dataclasses import replace
from pathlib import Path

import pytest
from joint_builders import content_of, fit_of, rows_of, run_of
from page_builders import NASTY, estimates_of, parsed
from study_chapter_builders import CLAIM, study_content, study_run
from typst_builders import page_of, plain_words

from tepsipe.io.estimates import Recovery
from tepsipe.reporting.page_parts import trial_rows, trials_table
from tepsipe.reporting.report_page import Origin, ReportPage, html_of, made_again, render_report
from workflow.support.origins import study_command

DECISIONS = Path(__file__).parents[2] / "docs/decisions"
TYPESET = """<style>math {}</style></head><body><div data-source="chapters/a.typ"><h2>1 A &amp; B</h2>
<p>See <a href="#figure_x">Figure 1</a>, <a id="loc-9" href="#loc-7">[2]</a>,
<a href="#loc-2">Section 1.1</a>.</p>
<h3 id="loc-2">1.1 Detail</h3><div data-lead="figure_x"></div>
<figure id="figure_x"><img src="../figures/figure_x.svg" loading="lazy" alt="A">
<figcaption>Figure 1: Found 1.5 N. More.</figcaption></figure>
<figure><figcaption>Table 3: T.</figcaption><table><tr><td>one</td><td>-1.5</td></tr></table></figure>
<div data-label="own"></div><h3>1.2 Labelled</h3>
<div data-label="two"></div><h3 id="loc-3">1.3 Labelled</h3> <a href="#loc-3">1.3</a>
<table><tr><th></th><th>n</th></tr><tr><td>of the study</td><td><code>1.2</code></td></tr></table>
<div class="equation"><math display="block"><mi>\U0001d43e</mi></math><span class="number">(4)</span></div>
<ul><li id="loc-7"><span class="prefix"><a href="#loc-9" role="doc-backlink">[2]</a></span> A.</li></ul>
</div></body>"""


def rendered(typeset=TYPESET, title="A study", **changed):
    origin = Origin({"x.csv": "../x y.csv"}, [("Rule", "plot (a.smk:1)")], "snakemake -c1 <x>")
    given = {
        "facts": [("Authors", "N. N.")],
        "files": {"Report as PDF": "my study.pdf"},
        "sizes": {"../figures/figure_x.svg": (400.0, 200.0)},
        "origins": {"figure_x": origin, "chapters/a.typ": origin},
        "rests_on": {"figure_x": [3], "chapters/a.typ": [7]},
        "decisions": {3: ("Three", "<p>Why</p>", "0003.md"), 7: ("Seven", "", "0007.md"), 8: ("Not", "", "")},
        "parts": {"trials": ("Trials", "<p>none</p>")},
    }
    return render_report(typeset, ReportPage(title=title, **given | changed))


def test_first_paragraph_says_what_joint_impedance_is():
    content, tables = content_of(run_of({"a": fit_of()}, rows_of("a")))
    told = plain_words(page_of(content, tables, '#include "lead.typ"'))
    assert told.startswith("Joint impedance is the resistance of a joint to being moved")


def test_a_report_is_one_page_with_formulas_that_every_font_has():
    content, tables = content_of(run_of({"a": fit_of()}, rows_of("a")))
    run, claims = study_content(study_run({"claims": [CLAIM]}))
    content["chapters"] |= run["chapters"]
    content["experiments"] = ["position_manipulator"]
    content["study"] |= {"experiments": {"position_manipulator": ["a"]}, "tasks": []}
    html = rendered(f"<body>{page_of(content, tables | {'claims': claims['claims']})}")
    assert "<mi>K</mi>" in html and not any(0x1D400 <= ord(c) < 0x1D800 for c in html)
    assert "<td>N·m/rad</td>" in unicodedata.normalize("NFKC", html).replace("\u2060", "")
    parsed(html)


def test_every_section_figure_table_equation_and_reference_has_an_anchor_of_its_own():
    reader = parsed(rendered())
    assert {
        "a-b",
        "detail",
        "figure_x",
        "table-3",
        "equation-4",
        "reference-2",
        "decision-3",
        "own",
        "two",
    } <= set(reader.ids)
    assert {link[1:] for link in reader.links if link.startswith("#")} <= set(reader.ids)
    # one more section before changes none of them
    more = parsed(rendered(TYPESET.replace("<h2>1 A", "<h2>New</h2><h2>1 A")))
    assert set(reader.ids) < set(more.ids)


def test_what_scrolls_on_a_narrow_screen_is_reached_by_keys():
    html = rendered(TYPESET.replace("<h2>1", '<div class="drawn" role="img"></div><h2>1'))
    for kind in ("drawn", "equation", "wide"):
        assert f'class="{kind}" tabindex="0"' in html and f'class="{kind}">' not in html


def test_figures_have_size_origin_and_the_nearest_decision():
    html = rendered()
    assert '<img src="../figures/figure_x.svg" width="400" height="200" loading="lazy"' in html
    figure, table = (
        html.partition(f'<figure id="{name}"')[2].partition("</figure>")[0]
        for name in ("figure_x", "table-3")
    )
    assert 'href="./../x%20y.csv">x.csv</a>' in figure and "<code>snakemake -c1 &lt;x&gt;</code>" in figure
    assert "decision 3: Three" in figure and "decision 7: Seven" in table
    assert '<td>one</td><td class="n">-1.5</td>' in table
    assert 'id="decision-8"' not in html
    origin = Origin({}, [], "x")
    part = rendered(origins={"trials": origin}, rests_on={"trials": [8]})
    assert "decision 8: Not" in part.partition('id="trials"')[2] and 'id="decision-8"' in part


def test_a_table_without_caption_has_the_origin_of_its_chapter_and_no_empty_heading():
    table = rendered().partition("of the study")[2].partition("<div class=")[0]
    assert "<td><code>1.2</code></td>" in table and "<code>plot (a.smk:1)</code>" in table
    assert "decision 7: Seven" in table
    assert "<tr><td></td><th>n</th></tr>" in rendered()


def test_questions_lead_to_sections_that_the_report_has():
    questions = rendered().partition('<nav class="questions"')[2].partition("</nav>")[0]
    assert parsed(f"<p>{questions.partition('>')[2]}</p>").links == ["#trials"]
    assert "questions" not in rendered(parts={}).partition("</style>")[2].partition("<script")[0]


def test_subtitle_and_first_paragraph_stand_between_title_and_questions():
    lead = '<section id="lead">\n<p>The answer.</p></section>'
    typeset = f'<body><p class="subtitle">A study of a thesis</p>{lead}<h2>Question</h2></body>'
    html = rendered(typeset).partition("<main")[2]
    places = [
        html.index(part) for part in ("<h1>", "A study of", "The answer.", "<nav", "facts", ">Question")
    ]
    assert places == sorted(places) and html.count("The answer.") == html.count("A study of") == 1


def test_how_sure_leads_to_the_table_of_certainty_before_counts_of_one_laboratory():
    typeset = "<body><h2>Certain</h2><h2>Truth</h2></body>"
    for label, words in (("truth", "Truth"), ("certainty", "Certain")):
        typeset = typeset.replace(f"<h2>{words}", f'<div data-label="{label}"></div><h2>{words}')
        assert f'<a href="#{label}">How certain is this?</a>' in rendered(typeset)


def test_chapters_of_the_supplement_are_folded():
    chapters = "<h2>S1 One</h2><p>a</p><h3>S1.1 Deep</h3><h2>S2 Two</h2>"
    html = rendered(f"<body><h2>1 Main</h2><h3>1.1 Sub</h3><div>{chapters}</div><h2>References</h2></body>")
    parsed(html)
    folds = re.findall(r'(?s)<details class="chapter"><summary><h2 id="(.*?)".*?</details>', html)
    assert folds == ["one", "two"] and "<p>a</p>" in html.partition('id="one"')[2].partition("</details>")[0]
    assert '<h2 id="references">' in html.rpartition("</details>\n</div>")[2]
    # of a folded chapter the contents name no sections
    contents = html.partition('<ol id="contents">')[2].partition("</ol>")[0]
    assert re.findall('href="#(.*?)"', contents)[:5] == ["main", "sub", "one", "two", "references"]


def test_the_source_of_a_function_is_folded_in_once_with_a_link_to_its_line():
    place = "draw (tepsipe/a.py:7)"
    code = [("Rule", "plot (a.smk:1)"), ("Function", place)]
    origins = {"figure_x": Origin({}, code, "x"), "chapters/a.typ": Origin({}, code, "x")}
    given = {"origins": origins, "functions": {place: "def draw():\n    return 1 < 2"}}
    html = rendered(**given)
    assert html.count("return 1 &lt; 2") == 1 and "in the repository" not in html
    name = re.search(r'<details class="code" id="([^"]+)"><summary><code>draw', html)[1]
    assert html.count(f'<a href="#{name}">Source</a>') == 2
    known = rendered(**given, repository="https://a.example/b/blob/0123")
    assert '<a href="https://a.example/b/blob/0123/tepsipe/a.py#L7">' in known
    assert '<a href="https://a.example/b/blob/0123/a.smk#L1">' in known


def test_figures_to_try_are_linked_at_the_top_also_without_their_figure():
    tried = {"figure_x": ("apparent", {}), "figure_gone": ("forward", {})}
    html = rendered(explored=tried)
    questions = html.partition('<nav class="questions"')[2].partition("</nav>")[0]
    assert "#try-apparent" in questions and "#try-forward" in questions and "specification" not in questions
    figure, _, after = html.partition('id="try-apparent"')
    assert "Found 1.5 N" in figure and 'id="try"' in after.partition('id="try-forward"')[0]
    assert rendered().count('class="explorer"') == 0


def test_parts_name_sections_by_their_titles():
    link = '<a href="#section:{0}">{0}</a>'
    part = f"{link.format('Detail')}, {link.format('A &amp; B')}, {link.format('Absent')}"
    shown = rendered(parts={"trials": ("Trials", part)})
    assert '<a href="#detail">Section 1.1 “Detail”</a>, <a href="#a-b">Section 1 “A &amp; B”</a>' in shown
    assert "</a>, Section “Absent”" in shown


def test_commands_that_make_the_run_again_can_be_copied():
    html = made_again(study_command(["config/a<b.yaml"]))
    assert "<code>snakemake -c2 --configfile config/a&lt;b.yaml</code> <button" in html
    assert study_command([]) == "snakemake -c2"
    assert "tepsipe new-study" in html.partition('id="own-recordings"')[2]


def test_the_figure_of_the_result_stands_at_the_top_with_its_finding():
    lead = rendered().partition('<div class="lead">')[2].partition("</div>")[0]
    assert 'src="../figures/figure_x.svg"' in lead and "lazy" not in lead
    assert "<p>Found 1.5 N." in lead and "More" not in lead and 'href="#figure_x"' in lead
    parts = rendered(TYPESET.replace("Found 1.5 N. More.", "Left: one. Right: two."))
    assert "<p>Left: one. Right: two. <a" in parts


def test_images_are_described_by_themselves_or_by_their_captions():
    content, tables = content_of(run_of({"a": fit_of()}, rows_of("a")))
    source = """#import "style.typ": style
    #show: style
    #figure(image("figures/figure_walking.svg"), caption: [_K_ by phase.])
    #figure(image("figures/figure_needed.svg", alt: "Own words"), caption: [Other words.])
    #image("figures/figure_coverage.svg")"""
    html = page_of(content, tables, source)
    assert (
        re.findall(r'<img [^>]*alt="([^"]*)"', html) == ["K by phase.", "Own words"]
        and html.count("<img") == 3
    )


def test_page_needs_nothing_from_outside_and_no_name_of_a_user_breaks_it():
    html = rendered(
        title=NASTY,
        facts=[(NASTY, NASTY)],
        files={NASTY: "a:b #1?%<i>"},
        explored={"figure_x": ("apparent", NASTY)},
        functions={"plot (a.smk:1)": NASTY},
    )
    reader = parsed(html)
    assert len(reader.scripts) == 5 and "".join(reader.words).count("alert(1)") >= 3
    assert "./a%3Ab%20%231%3F%25%3Ci%3E" in reader.links
    assert not any(link.startswith(("http", "//", "/")) for link in reader.links)
    assert re.findall(r"url\(.{6}", html) == ['url("data:'] and "@import" not in html


def test_same_content_gives_the_same_page():
    assert rendered() == rendered()


def test_trials_have_quoted_estimates_beside_their_truth():
    k, i, vaf = (e for e in estimates_of(flags="at-bound"))
    k = replace(k, recommended=True)
    key = (k.experiment, k.condition, k.pathway, k.estimator, "K", "Nm/rad")
    truth = Recovery(*key, 10.2, 10.1, 0.01, True, "small movements")
    rows = trial_rows({"dummy": ["sine-0.3"], "empty": [NASTY]}, [k, i, vaf], [truth])
    html = trials_table(rows)
    reader = parsed(html)
    assert '<td class="n" data-value="10.1272">10.13 ± 0.12 <small>true 10.2</small></td>' in html
    assert ">41.5</td>" in html and ">at-bound</span></td>" in html
    assert "<dt><code>at-bound</code></dt><dd>a parameter lies at a bound" in html
    assert "alert(1)" in " ".join(reader.words)
    assert "./trials/dummy/sine-0.3.html" in reader.links and reader.scripts == []


@pytest.mark.parametrize("path", sorted(DECISIONS.glob("0*.md")), ids=lambda path: path.stem[:4])
def test_every_decision_is_shown_as_well_formed_html(path):
    text = path.read_text(encoding="utf-8")
    reader = parsed(html_of(text))
    shown = " ".join(reader.words)
    assert "**" not in shown and "](" not in shown and "Decision" in shown and reader.links == []
