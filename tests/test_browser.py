"""Pages of a tiny study in a real browser, from files: no errors, readable on a telephone."""

import browser_driver
import pytest

from tepsipe.drawing.names import PARAMETER_SETS
from tepsipe.experiments.forward.scores import FORWARD_SCORES

pytestmark = [
    pytest.mark.study,
    pytest.mark.browser,
    pytest.mark.skipif(
        not (browser_driver.CHROMIUM and browser_driver.CHROMEDRIVER), reason=browser_driver.MISSING
    ),
]


# what every row of a table that is shown has
SHOWN = "return [...document.querySelectorAll('#TABLE tbody tr:not([hidden])')].map((row) => row.{})"


@pytest.fixture(scope="module")
def browser():
    with browser_driver.browser() as opened:
        yield opened


# tests of one page and width follow each other: another one opens the page again, which takes a second
@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
def test_report_opens_without_errors_and_fits_into_the_window(study, browser, width, theme):
    browser.show(study / "results/report/index.html", width)
    browser.run("document.documentElement.dataset.theme = given[0]", theme)
    # all images are loaded, and nothing but wide tables, formulas and sources is wider than the window
    browser.run("for (const part of document.querySelectorAll('details')) part.open = true;")
    broken = """
        document.querySelectorAll("img").forEach((image) => { image.loading = "eager"; });
        await Promise.all([...document.images].map((image) => image.decode().catch(() => null)));
        return [...document.images].filter((image) => !image.naturalWidth).map((image) => image.src);
    """
    assert browser.run(broken) == []
    assert browser.run("return document.documentElement.scrollWidth - innerWidth") <= 0
    assert browser.log() == []
    assert browser.run("return performance.getEntriesByName('first-contentful-paint')[0].startTime") < 3000


@pytest.mark.parametrize(
    ("page", "table"),
    [
        ("index", "#trials-table"),
        ("index", "#ledger-table"),
        ("index", "table.cells"),
        ("trials/dummy/sine-0.5", "table"),
    ],
)
def test_on_a_telephone_the_first_column_stays_beside_the_others(study, browser, page, table):
    browser.show(study / f"results/report/{page}.html", 390)
    distances = """
        const table = document.querySelector(given[0]);
        const wide = table.parentElement;
        wide.scrollLeft = 150;
        const cell = table.querySelector("tbody tr").cells[0].getBoundingClientRect();
        const box = wide.getBoundingClientRect();
        return [wide.scrollLeft, Math.round(cell.left - box.left), cell.width / box.width];
    """
    moved, left, share = browser.run(distances, table)
    assert moved == 150 and left == 0 and share < 0.5


def test_a_reference_is_previewed(study, browser):
    browser.show(study / "results/report/index.html")
    pointed = """
        const link = document.querySelector('main p a[href="#figure_pathways"]');
        link.dispatchEvent(new PointerEvent("pointerover", { bubbles: true, pointerType: "mouse" }));
        await new Promise((resolve) => setTimeout(resolve, 500));
        const card = document.querySelector(".popover");
        return card.hidden ? null : [card.querySelector("img").getAttribute("src"), card.textContent];
    """
    source, words = browser.run(pointed)
    assert source == "../figures/figure_pathways.svg" and "Figure" in words
    focused = """
        const link = document.querySelector("a.basis");
        link.focus({ focusVisible: true });
        return document.querySelector(".popover").textContent;
    """
    assert "Tables 4-2 and 4-3" in browser.run(focused)


def test_search_finds_words_and_shows_their_place(study, browser):
    browser.show(study / "results/report/index.html")
    typed = """
        const field = document.getElementById("search");
        field.value = given[0];
        field.dispatchEvent(new Event("input"));
        return [...document.querySelectorAll("#found li")].map((item) => item.textContent);
    """
    found = browser.run(typed, "bystander")
    assert found == ["Nothing found."]
    found = browser.run(typed, "virtual laboratory")
    assert len(found) > 3 and "virtual laboratory" in found[1].lower()


def test_trials_are_sorted_and_filtered(study, browser):
    browser.show(study / "results/report/index.html")
    shown = SHOWN.replace("TABLE", "trials-table")
    experiments = browser.run(shown.format("dataset.experiment"))
    assert len(experiments) == 10
    of = "const e = document.querySelector('[data-of=trials-table] select'); e.value = 'dummy';"
    of += "e.dispatchEvent(new Event('input', { bubbles: true }));"
    assert set(browser.run(of + shown.format("dataset.experiment"))) == {"dummy"}
    press = "document.querySelectorAll('#trials-table thead button')[2].click();"
    rising = browser.run(press + shown.format("cells[2].dataset.value"))
    falling = browser.run(press + shown.format("cells[2].dataset.value"))
    assert rising == sorted(rising, key=float) == falling[::-1] and len(set(rising)) == 2


def test_what_did_not_reproduce_is_one_click_away(study, browser):
    browser.show(study / "results/report/index.html")
    shown = SHOWN.replace("TABLE", "ledger-table").format("dataset.verdict")
    every = browser.run(shown)
    left = browser.run(f"document.querySelector('.questions a[data-filter]').click(); {shown}")
    assert set(left) == {"not reproduced"} and len(left) == every.count("not reproduced") < len(every)
    assert browser.run("return location.hash") == "#ledger"
    told = browser.run("return document.querySelector('[data-of=ledger-table] output').textContent")
    assert told == f"{len(left)} rows"


def test_contents_list_the_sections_of_the_chapter_that_is_read(study, browser):
    browser.show(study / "results/report/index.html")
    shown = """
        document.getElementById(given[0]).scrollIntoView();
        await new Promise((resolve) => setTimeout(resolve, 300));
        const items = [...document.querySelectorAll("#contents .level-3:not([hidden]) a")];
        return [items.map((a) => a.hash), document.querySelector("[aria-current]").hash];
    """
    sections, current = browser.run(shown, "own-recordings")
    assert sections == ["#code", "#own-recordings"] and current == "#own-recordings"
    sections, current = browser.run(shown, "make-again")
    assert sections == ["#code", "#own-recordings"] and current == "#make-again"


def test_figures_to_try_keep_their_controls_when_their_links_are_pointed_at(study, browser):
    browser.show(study / "results/report/index.html")
    pointed = """
        const link = document.querySelector('.questions a[href="#try-apparent"]');
        link.dispatchEvent(new PointerEvent("pointerover", { bubbles: true, pointerType: "mouse" }));
        await new Promise((resolve) => setTimeout(resolve, 500));
        return document.querySelectorAll("#try-apparent input:checked").length;
    """
    assert browser.run(pointed) == 1


def test_the_source_of_a_function_is_copied_to_every_figure_that_it_makes(study, browser):
    browser.show(study / "results/report/index.html")
    opened = """
        const again = document.querySelector("details.code:not([id])");
        const name = again.querySelector("a").hash.slice(1);
        again.open = true;
        await new Promise((resolve) => setTimeout(resolve, 100));
        return [again.querySelector("pre").textContent, document.querySelector(`#${name} pre`).textContent];
    """
    copied, source = browser.run(opened)
    assert copied == source and source.startswith("def ")


def test_signs_as_printed_return_the_apparent_impedance_with_a_perfect_fit(study, browser):
    browser.show(study / "results/report/index.html")
    cells = "[...document.querySelectorAll('[data-explore=apparent] tbody tr')]"
    cells += ".map((row) => row.lastChild.textContent)"
    *joint, vaf = browser.run(f"return {cells}")
    # I + 2 I_leg, B, K - 2 m g r of the dummy (docs/method.md)
    assert joint == ["0.0610✗", "0.0649✓", "6.68✗"] and vaf == "100.00 %"
    consistent = "document.querySelectorAll('.explorer input[type=radio]')[1].click();"
    assert browser.run(f"{consistent} return {cells}")[2:] == ["10.2✓", "100.00 %"]


def test_the_leg_of_the_page_agrees_with_the_forward_simulation_for_every_set_of_parameters(study, browser):
    browser.show(study / "results/report/index.html")
    names = browser.run(
        """
        const mount = document.querySelector(".explorer[data-explore=forward]");
        const select = mount.querySelector("select");
        return [...select.options].map((option) => option.value).filter(Boolean).map((name) => {
          select.value = name;
          select.dispatchEvent(new Event("change"));
          return [name, mount.querySelector("table tr:last-child td").textContent];
        });
        """
    )
    shown = {name: float(vaf.removesuffix(" %").replace("\u2212", "-")) for name, vaf in names}
    rows = FORWARD_SCORES.read(study / "results/tables/forward.csv")
    expected = {
        PARAMETER_SETS[row.parameter_set]: row.vaf_trial
        for row in rows
        if (row.condition, row.quantity) == ("sine-0.5", "theta")
    }
    assert len(expected) > 3 and shown == pytest.approx(expected, rel=0.01, abs=0.3)


def test_printed_cells_are_read_by_pointing_and_by_keys(study, browser):
    browser.show(study / "results/report/index.html")
    about = "return document.querySelector('.cell-about').textContent;"
    cell = "document.querySelector('table.cells td[data-about]')"
    first = browser.run(f"{cell}.dispatchEvent(new PointerEvent('pointerenter')); {about}")
    assert first.startswith("cellTable 4-1 of the thesis, I, 0.08") and "tolerance" in first
    press = (
        "document.activeElement.dispatchEvent(new KeyboardEvent('keydown', {key: given[0], bubbles: true}));"
    )
    browser.run(f"{cell}.focus(); {press}", "ArrowDown")
    assert browser.run(f"{press} {about}", "ArrowRight").startswith("cellTable 4-1 of the thesis, B, 0.12")


def test_a_page_of_a_trial_opens_without_errors(study, browser):
    browser.open(study / "results/report/trials/dummy/sine-0.5.html")
    assert browser.run("return document.querySelectorAll('canvas').length") > 3
    assert browser.log() == []
