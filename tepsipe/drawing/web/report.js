// The page of a report: contents that follow, search, previews of references, commands to copy, tables to sort.
"use strict";
(() => {
  const one = (selector, root = document) => root.querySelector(selector);
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const made = (tag, words = "", kind = "") => Object.assign(document.createElement(tag), { textContent: words, className: kind });
  const main = one("main");

  // ---- contents: open beside the text, closed above it
  const contents = one(".side details");
  const wide = matchMedia("(min-width: 70rem)");
  const unfold = () => { contents.open = wide.matches; };
  unfold();
  wide.addEventListener("change", unfold);
  const entries = new Map(all("#contents a").map((a) => [decodeURIComponent(a.hash.slice(1)), a]));
  const headings = [...entries.keys()].map((id) => document.getElementById(id)).filter(Boolean);
  // sections are listed below the chapter that is read
  const sections = new Map();
  let chapter = null;
  for (const item of all("#contents li")) {
    if (item.classList.contains("level-2")) chapter = item;
    else sections.set(item, chapter);
  }
  let current = null;
  const follow = () => {
    let last = headings[0];
    for (const heading of headings) {
      if (heading.checkVisibility && !heading.checkVisibility()) continue; // in a folded chapter
      if (heading.getBoundingClientRect().top > 120) break;
      last = heading;
    }
    const entry = last && entries.get(last.id);
    if (entry === current || !entry) return;
    current?.removeAttribute("aria-current");
    entry.setAttribute("aria-current", "true");
    const own = sections.get(entry.parentElement) ?? entry.parentElement;
    for (const [item, of] of sections) item.hidden = of !== own;
    if (wide.matches) entry.scrollIntoView({ block: "nearest" });
    current = entry;
  };
  let waiting = false;
  addEventListener("scroll", () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; follow(); });
  }, { passive: true });
  follow();
  contents.addEventListener("click", (event) => {
    if (event.target.closest("a") && !wide.matches) contents.open = false;
  });

  // ---- search in headings, captions, paragraphs and cells
  const found = one("#found");
  const field = one("#search");
  let index = null;
  const indexed = () => index ??= all("h2, h3, h4, figcaption, p, li, tbody tr", main).map((element) => ({
    element, words: element.textContent.replace(/\s+/g, " ").trim(), weight: /^H/.test(element.tagName) ? 0 : element.tagName === "FIGCAPTION" ? 1 : 2,
  }));
  const plain = (words) => words.toLowerCase().normalize("NFKD").replace(/[\u0300-\u036f\u2060]/g, "");
  const around = (words, wanted) => {
    const at = plain(words).indexOf(wanted);
    const start = Math.max(0, at - 30);
    const item = made("small");
    item.append((start ? "…" : "") + words.slice(start, at), made("mark", words.slice(at, at + wanted.length)), words.slice(at + wanted.length, at + wanted.length + 70));
    return item;
  };
  const headingOf = (element) => headings.filter((h) => h.compareDocumentPosition(element) & Node.DOCUMENT_POSITION_FOLLOWING || h === element).pop();
  field.addEventListener("input", () => {
    const wanted = plain(field.value.trim());
    found.replaceChildren();
    found.hidden = wanted.length < 2;
    if (found.hidden) return;
    const hits = indexed().filter((entry) => plain(entry.words).includes(wanted)).sort((a, b) => a.weight - b.weight);
    found.append(made("li", hits.length === 0 ? "Nothing found." : `${hits.length} place${hits.length > 1 ? "s" : ""}`));
    for (const { element, words } of hits.slice(0, 30)) {
      const item = made("li");
      const link = made("a", headingOf(element)?.textContent.replace(/#$/, "").trim() ?? "Beginning");
      link.href = "#" + (element.id || element.closest("[id]")?.id || "");
      link.append(around(words, wanted));
      link.addEventListener("click", (event) => {
        event.preventDefault();
        for (let details = element.closest("details"); details; details = details.parentElement.closest("details")) details.open = true;
        element.scrollIntoView({ block: "center" });
        element.tabIndex = -1;
        element.focus({ preventScroll: true });
        if (!wide.matches) contents.open = false;
      });
      item.append(link);
      found.append(item);
    }
  });
  addEventListener("keydown", (event) => {
    if (event.key === "/" && !/INPUT|TEXTAREA|SELECT/.test(document.activeElement.tagName)) {
      event.preventDefault();
      contents.open = true;
      field.focus();
    }
    if (event.key === "Escape") hide();
  });

  // ---- preview of what a reference names
  const card = made("div", "", "popover");
  card.hidden = true;
  card.setAttribute("role", "tooltip");
  document.body.append(card);
  let timer = 0;
  const hide = () => { clearTimeout(timer); card.hidden = true; };
  const preview = (link) => {
    const target = document.getElementById(decodeURIComponent(link.hash.slice(1)));
    // a copy of controls would take the place of the controls themselves
    if (!target || target.contains(link) || target.matches(".explorer")) return;
    const shown = target.closest("figure, div.equation, [role=doc-bibliography] li, [role=doc-endnotes] li, .decision") ?? target;
    const parts = [shown.cloneNode(true)];
    const next = (shown.closest("summary") ?? shown).nextElementSibling;
    if (/^H\d$/.test(shown.tagName) && next?.tagName === "P") parts.push(next.cloneNode(true));
    card.replaceChildren(...parts);
    for (const element of [card, ...all("[id]", card)]) element.removeAttribute("id");
    all("img", card).forEach((image) => { image.loading = "eager"; });
    card.hidden = false;
    const box = link.getBoundingClientRect();
    const left = Math.min(box.left, innerWidth - card.offsetWidth - 16);
    const below = box.bottom + card.offsetHeight + 12 < innerHeight;
    card.style.left = `${Math.max(8, left) + scrollX}px`;
    card.style.top = `${(below ? box.bottom + 6 : Math.max(4, box.top - card.offsetHeight - 6)) + scrollY}px`;
  };
  const reference = (event) => event.target.closest?.('main a[href^="#"]:not(.anchor)');
  main.addEventListener("pointerover", (event) => {
    const link = reference(event);
    if (!link || event.pointerType === "touch") return;
    clearTimeout(timer);
    timer = setTimeout(() => preview(link), 250);
  });
  main.addEventListener("pointerout", (event) => { if (reference(event)) hide(); });
  main.addEventListener("focusin", (event) => { const link = reference(event); if (link && link.matches(":focus-visible")) preview(link); });
  main.addEventListener("focusout", hide);
  main.addEventListener("click", hide);

  // ---- what an address names is unfolded
  const reveal = () => {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    for (let details = target?.closest("details"); details; details = details.parentElement.closest("details")) details.open = true;
  };
  addEventListener("hashchange", reveal);
  reveal();

  // ---- commands to copy; pages from a file have no clipboard of their own in every browser
  const copy = async (words) => {
    try { await navigator.clipboard.writeText(words); return true; } catch { /* the older way below */ }
    const area = made("textarea", words);
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  };
  main.addEventListener("click", async (event) => {
    const button = event.target.closest("button.copy");
    if (!button) return;
    button.textContent = await copy(one("code", button.parentElement).textContent) ? "copied" : "not copied";
    setTimeout(() => { button.textContent = "copy"; }, 1500);
  });

  // ---- tables: sorted by a column, filtered by their attributes and words
  for (const form of all("form.filters")) {
    const table = document.getElementById(form.dataset.of);
    const body = one("tbody", table);
    const rows = all("tr", body);
    const output = one("output", form);
    const filter = () => {
      const wanted = plain(one("input[type=search]", form).value.trim());
      let count = 0;
      for (const row of rows) {
        const kept = [...form.elements].every(({ name, type, value, checked }) => !name || (type === "checkbox" ? !checked || row.dataset[name] : !value || row.dataset[name] === value));
        row.hidden = !kept || !plain(row.textContent).includes(wanted);
        count += !row.hidden;
      }
      output.textContent = `${count} ${output.dataset.counted}${count === 1 ? "" : "s"}`;
    };
    form.hidden = false;
    filter();
    form.addEventListener("input", filter);
    form.addEventListener("submit", (event) => event.preventDefault());
    all("thead button", table).forEach((button, k) => button.addEventListener("click", () => {
      const head = button.parentElement;
      const turn = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
      all("th[aria-sort]", table).forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", turn > 0 ? "ascending" : "descending");
      const key = (row) => row.cells[k].dataset.value ?? row.cells[k].textContent.trim();
      const numeric = rows.some((row) => row.cells[k].dataset.value !== undefined);
      // rows without a value come last in both directions
      const empty = (row) => (numeric ? row.cells[k].dataset.value === undefined : key(row) === "");
      const compared = (a, b) => (numeric ? Number(key(a)) - Number(key(b)) : key(a).localeCompare(key(b), "en", { numeric: true }));
      rows.sort((a, b) => empty(a) - empty(b) || turn * compared(a, b));
      body.append(...rows);
    }));
  }
  // a question that leads to a part of a table sets its filter
  main.addEventListener("click", (event) => {
    const link = event.target.closest("a[data-filter]");
    if (!link) return;
    const [name, value] = link.dataset.filter.split("=");
    const form = one("form.filters", document.getElementById(link.hash.slice(1)).parentElement);
    form.elements[name].value = value;
    form.dispatchEvent(new Event("input"));
  });

  // ---- the source of a function is on the page once: wherever it is named again, it is copied
  for (const details of all("details.code:not([id])")) {
    details.addEventListener("toggle", () => {
      const link = one(":scope > a[href^='#code-']", details);
      if (details.open && link) link.replaceWith(...[...document.getElementById(link.hash.slice(1)).children].slice(1).map((child) => child.cloneNode(true)));
    });
  }
})();
