"use strict";
// Curves of one trial: panels that share axes, zoomed and read together. No library, no network.
(function () {
  const page = JSON.parse(document.getElementById("data").textContent);
  const LEFT = 64, RIGHT = 10, TOP = 6, BOTTOM = 20, HEIGHT = 150;
  const FILLS = {
    "window": "rgba(240,190,60,0.28)", "epoch": "rgba(240,190,60,0.22)", "hidden": "rgba(120,120,120,0.30)", "left-out": "rgba(213,94,0,0.20)",
    "held-out": "rgba(0,114,178,0.10)", "cut": "rgba(120,120,120,0.16)",
  };
  const HATCHED = { "hidden": 1, "left-out": 1, "cut": 1 };
  const axes = {}, panels = [], clocks = page.clocks.map(instants);

  // ---- data --------------------------------------------------------------------------------------

  function instants(clock) {
    // a bucket's two points stand at a quarter and at three quarters of it
    let count = 0;
    for (const [a, b, step] of clock.runs) count += step === 1 ? b - a : 2 * Math.ceil((b - a) / step);
    const time = new Float64Array(count);
    let k = 0;
    for (const [a, b, step] of clock.runs) {
      if (step === 1) for (let i = a; i < b; i++) time[k++] = clock.start + i / clock.rate;
      else for (let i = a; i < b; i += step) {
        const length = Math.min(step, b - i) - 1;
        time[k++] = clock.start + (i + 0.25 * length) / clock.rate;
        time[k++] = clock.start + (i + 0.75 * length) / clock.rate;
      }
    }
    return time;
  }

  function numbers(trace) {
    const bytes = atob(trace.data), values = new Float64Array(bytes.length / 2);
    for (let i = 0; i < values.length; i++) {
      const n = ((bytes.charCodeAt(2 * i) | (bytes.charCodeAt(2 * i + 1) << 8)) << 16) >> 16;
      values[i] = n === -32768 ? NaN : trace.offset + trace.scale * n;
    }
    return values;
  }

  // first index whose instant is not before t
  function place(time, t) {
    let low = 0, high = time.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (time[middle] < t) low = middle + 1; else high = middle;
    }
    return low;
  }

  // ---- numbers as text ---------------------------------------------------------------------------

  function ticks(low, high, most) {
    const raw = (high - low) / Math.max(1, most), power = Math.pow(10, Math.floor(Math.log10(raw)));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw * 0.9999);
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), found = [];
    for (let k = Math.ceil(low / step - 1e-6); k * step <= high + 1e-6 * step; k++) {
      const text = (k === 0 ? 0 : k * step).toFixed(Math.min(digits, 12));
      found.push([k * step, signed(text)]);
    }
    return found;
  }

  function signed(text) { return text.replace("-", "\u2212"); }

  function reading(value, span) {
    if (!isFinite(value)) return "\u2013";
    const digits = span > 0 ? Math.max(0, Math.min(9, 3 - Math.floor(Math.log10(span)))) : 3;
    const text = value.toFixed(digits);
    return Number(text) === 0 ? text.replace("-", "") : signed(text);
  }

  function timeText(t, span) { return reading(t, 3 * span) + " s"; }

  // ---- panels ------------------------------------------------------------------------------------

  page.panels.forEach(function (given, number) {
    const figure = document.getElementById("panel-" + number), holder = figure.querySelector(".plot");
    const canvas = document.createElement("canvas"), overlay = document.createElement("div");
    const hair = document.createElement("div"), chosen = document.createElement("div");
    const flag = document.createElement("div");
    overlay.className = "overlay"; hair.className = "hair"; chosen.className = "chosen"; flag.className = "flag";
    overlay.append(chosen, hair, flag);
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", given.title + (given.unit ? " in " + given.unit : "") + ": " +
      given.traces.map((t) => t.label).join(", ") + ". Arrow keys move, plus and minus zoom, 0 resets.");
    holder.append(canvas, overlay);
    const panel = {
      figure, canvas, hair, chosen, flag, axis: given.axis, bands: given.bands, seen: false, stale: true,
      traces: given.traces.map((t) => ({
        ...t, time: clocks[t.clock], values: numbers(t), shown: true,
      })),
    };
    legend(panel, figure.querySelector(".legend"));
    panels.push(panel);
    const axis = axes[given.axis] || (axes[given.axis] = {
      ...page.axes[given.axis], panels: [], full: [Infinity, -Infinity], name: given.axis,
    });
    axis.panels.push(panel);
    for (const trace of panel.traces) if (trace.time.length) {
      axis.full[0] = Math.min(axis.full[0], trace.time[0]);
      axis.full[1] = Math.max(axis.full[1], trace.time[trace.time.length - 1]);
    }
    listen(panel, axis);
  });

  function legend(panel, holder) {
    for (const trace of panel.traces) {
      const button = document.createElement("button"), name = document.createElement("span");
      button.type = "button";
      button.setAttribute("aria-pressed", "true");
      button.title = "Show or hide";
      const dash = trace.dash ? ' stroke-dasharray="' + trace.dash + '"' : "";
      button.innerHTML = '<svg width="26" height="10" aria-hidden="true"><line x1="1" x2="25" y1="5" y2="5" ' +
        'stroke-width="2"' + dash + "/></svg>";
      button.querySelector("line").style.stroke = "var(--line-" + trace.colour + ", " + page.colours[trace.colour] + ")";
      name.textContent = trace.label;
      trace.output = document.createElement("output");
      button.append(name, trace.output);
      button.addEventListener("click", function () {
        trace.shown = !trace.shown;
        button.setAttribute("aria-pressed", String(trace.shown));
        draw(panel);
      });
      holder.append(button);
    }
    for (const kind of new Set(panel.bands.map((b) => b[0]))) {
      const sample = document.createElement("span"), swatch = document.createElement("i");
      sample.className = "band";
      swatch.style.background = FILLS[kind];
      sample.append(swatch, page.bands[kind]);
      holder.append(sample);
    }
  }

  // ---- light and dark, as the report --------------------------------------------------------------

  const root = document.documentElement, darkened = matchMedia("(prefers-color-scheme: dark)");

  function theme(name) { return getComputedStyle(root).getPropertyValue(name).trim(); }

  function redraw() {
    for (const panel of panels) panel.stale = true;
    refresh();
  }

  new MutationObserver(redraw).observe(root, { attributes: true, attributeFilter: ["data-theme"] });
  darkened.addEventListener("change", redraw);

  // ---- drawing -----------------------------------------------------------------------------------

  function range(panel, from, to) {
    let low = Infinity, high = -Infinity;
    for (const trace of panel.traces) {
      if (!trace.shown) continue;
      const stop = Math.min(trace.time.length, place(trace.time, to) + 1);
      for (let i = Math.max(0, place(trace.time, from) - 1); i < stop; i++) {
        const v = trace.values[i];
        if (v < low) low = v;
        if (v > high) high = v;
      }
    }
    if (!(high >= low)) return [-1, 1];
    const pad = high > low ? 0.07 * (high - low) : Math.max(1e-9, 0.05 * Math.abs(low));
    return [low - pad, high + pad];
  }

  function draw(panel) {
    const axis = axes[panel.axis], canvas = panel.canvas, [from, to] = axis.view;
    const width = Math.max(200, canvas.parentElement.clientWidth), ratio = Math.max(window.devicePixelRatio || 1, panel.ratio || 1);
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(HEIGHT * ratio)) canvas.height = Math.round(HEIGHT * ratio);
    canvas.style.height = HEIGHT + "px";
    const c = canvas.getContext("2d"), [low, high] = range(panel, from, to);
    panel.x = (t) => LEFT + (width - LEFT - RIGHT) * (t - from) / (to - from);
    panel.t = (x) => from + (to - from) * (x - LEFT) / (width - LEFT - RIGHT);
    panel.span = high - low;
    const y = (v) => TOP + (HEIGHT - TOP - BOTTOM) * (high - v) / (high - low);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = theme("--paper");
    c.fillRect(0, 0, width, HEIGHT);
    c.save();
    c.beginPath();
    c.rect(LEFT, TOP, width - LEFT - RIGHT, HEIGHT - TOP - BOTTOM);
    c.clip();
    for (const [kind, a, b] of panel.bands) {
      if (b < from || a > to) continue;
      const x0 = panel.x(a), w = Math.max(1.2, panel.x(b) - x0);
      c.fillStyle = FILLS[kind];
      c.fillRect(x0, TOP, w, HEIGHT);
      if (HATCHED[kind]) hatch(c, x0, w);
    }
    c.restore();
    grid(c, width, from, to, low, high, y, axis, panel === axis.panels[axis.panels.length - 1]);
    c.save();
    c.beginPath();
    c.rect(LEFT, TOP, width - LEFT - RIGHT, HEIGHT - TOP - BOTTOM);
    c.clip();
    c.lineJoin = "round";
    for (const trace of panel.traces) if (trace.shown) line(c, trace, panel.x, y, from, to);
    c.restore();
    panel.stale = false;
  }

  function hatch(c, x0, w) {
    c.save();
    c.beginPath();
    c.rect(x0, TOP, w, HEIGHT - TOP - BOTTOM);
    c.clip();
    c.strokeStyle = "rgba(128,128,128,0.5)";
    c.lineWidth = 0.7;
    c.setLineDash([]);
    c.beginPath();
    for (let x = x0 - HEIGHT; x < x0 + w; x += 7) { c.moveTo(x, HEIGHT); c.lineTo(x + HEIGHT, 0); }
    c.stroke();
    c.restore();
  }

  function grid(c, width, from, to, low, high, y, axis, last) {
    c.font = "11px system-ui, sans-serif";
    c.lineWidth = 1;
    c.setLineDash([]);
    c.strokeStyle = theme("--grid");
    c.fillStyle = theme("--faint");
    c.textAlign = "right";
    c.textBaseline = "middle";
    for (const [value, label] of ticks(low, high, 6)) {
      const at = Math.round(y(value)) + 0.5;
      if (at < TOP || at > HEIGHT - BOTTOM) continue;
      c.beginPath(); c.moveTo(LEFT, at); c.lineTo(width - RIGHT, at); c.stroke();
      c.fillText(label, LEFT - 6, at);
    }
    c.textAlign = "center";
    c.textBaseline = "top";
    const shown = ticks(from, to, Math.max(2, Math.floor((width - LEFT - RIGHT) / 90)));
    for (const [value, label] of shown) {
      const at = Math.round(LEFT + (width - LEFT - RIGHT) * (value - from) / (to - from)) + 0.5;
      c.beginPath(); c.moveTo(at, TOP); c.lineTo(at, HEIGHT - BOTTOM); c.stroke();
      if (at < width - RIGHT - 50 || !axis.label) c.fillText(label, at, HEIGHT - BOTTOM + 5);
    }
    c.textAlign = "right";
    c.fillText(axis.label, width - RIGHT, HEIGHT - BOTTOM + 5);
    c.strokeStyle = theme("--frame");
    c.strokeRect(LEFT + 0.5, TOP + 0.5, width - LEFT - RIGHT - 1, HEIGHT - TOP - BOTTOM);
  }

  function line(c, trace, x, y, from, to) {
    const time = trace.time, values = trace.values;
    const start = Math.max(0, place(time, from) - 1), stop = Math.min(time.length, place(time, to) + 1);
    c.strokeStyle = theme("--line-" + trace.colour) || page.colours[trace.colour];
    c.lineWidth = trace.width;
    // dashes of a line that goes up and down within a pixel would only be slow
    c.setLineDash(trace.dash && stop - start < 6000 ? trace.dash.split(" ").map(Number) : []);
    c.beginPath();
    let drawing = false;
    for (let i = start; i < stop; i++) {
      const v = values[i];
      if (v !== v) { drawing = false; continue; }
      if (drawing) c.lineTo(x(time[i]), y(v));
      else { c.moveTo(x(time[i]), y(v)); if (i + 1 >= stop || values[i + 1] !== values[i + 1]) c.lineTo(x(time[i]) + 0.8, y(v)); }
      drawing = true;
    }
    c.stroke();
  }

  // ---- view: what all panels of an axis show -----------------------------------------------------

  let waiting = false;
  function refresh() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(function () {
      waiting = false;
      for (const panel of panels) if (panel.seen && panel.stale) draw(panel);
    });
  }

  function show(axis, from, to) {
    const [first, last] = axis.full, whole = last - first || 1, shortest = Math.max(1e-6 * whole, 1e-4);
    let length = Math.min(whole, Math.max(to - from, shortest));
    from = Math.max(first, Math.min(from, last - length));
    axis.view = [from, from + length];
    for (const panel of axis.panels) { panel.stale = true; panel.hair.style.display = panel.flag.style.display = "none"; }
    if (axis.name === "time") {
      document.getElementById("view").textContent =
        reading(from, 3 * length) + " to " + timeText(from + length, length);
    }
    document.documentElement.dataset[axis.name] = axis.view.map((t) => t.toFixed(4)).join(",");
    remember();
    refresh();
  }

  function remember() {
    const parts = Object.values(axes).filter((a) => a.view && (a.view[0] > a.full[0] || a.view[1] < a.full[1]));
    const hash = parts.map((a) => a.name + "=" + a.view.map((t) => t.toFixed(3)).join(",")).join("&");
    try { history.replaceState(null, "", hash ? "#" + hash : location.pathname + location.search); } catch (e) { /* a page opened from a mail */ }
  }

  function recall(address) {
    for (const part of address.slice(1).split("&")) {
      const [name, view] = part.split("="), ends = (view || "").split(",").map(Number);
      if (axes[name] && ends.length === 2 && ends[1] > ends[0]) show(axes[name], ends[0], ends[1]);
    }
  }

  function zoom(axis, factor, centre) {
    const [from, to] = axis.view, at = centre === undefined ? 0.5 * (from + to) : centre;
    show(axis, at - factor * (at - from), at + factor * (to - at));
  }

  function pan(axis, part) {
    const length = axis.view[1] - axis.view[0];
    show(axis, axis.view[0] + part * length, axis.view[1] + part * length);
  }

  function jump(axis, direction) {
    if (!axis || !axis.windows.length) return;
    const length = axis.view[1] - axis.view[0], whole = axis.full[1] - axis.full[0];
    const starts = axis.windows.map((w) => w[1]);
    let k = axis.window;
    // where the reader has gone elsewhere, from there
    if (k === undefined || length >= 0.999 * whole || starts[k] < axis.view[0] || starts[k] > axis.view[1]) {
      const middle = length >= 0.999 * whole ? axis.full[0] : 0.5 * (axis.view[0] + axis.view[1]);
      k = direction > 0 ? starts.findIndex((s) => s > middle) : starts.filter((s) => s < middle).length - 1;
    } else k += direction;
    k = Math.max(0, Math.min(starts.length - 1, k));
    const [, a, b] = axis.windows[k], unit = Math.max(b - a, 0.02);
    show(axis, a - 1.0 * unit, b + 4.0 * unit);
    axis.window = k;
  }

  // ---- mouse, touch, keys ------------------------------------------------------------------------

  function read(axis, t) {
    for (const panel of axis.panels) {
      const x = panel.x ? panel.x(t) : 0;
      for (const trace of panel.traces) {
        let i = place(trace.time, t);
        if (i > 0 && (i === trace.time.length || t - trace.time[i - 1] < trace.time[i] - t)) i--;
        trace.output.textContent = reading(trace.values[i], panel.span);
      }
      panel.hair.style.display = panel.flag.style.display = "block";
      panel.hair.style.left = x + "px";
      panel.flag.style.left = x + "px";
      const inside = panel.bands.filter((b) => b[1] <= t && t <= b[2] && b[3]).map((b) => b[3]);
      panel.flag.textContent = [timeText(t, axis.view[1] - axis.view[0]), ...inside].join(" \u00b7 ");
      panel.flag.classList.toggle("left", x > 0.6 * panel.canvas.clientWidth);
    }
    axis.cursor = t;
  }

  function unread(axis) {
    for (const panel of axis.panels) {
      panel.hair.style.display = panel.flag.style.display = "none";
      for (const trace of panel.traces) trace.output.textContent = "";
    }
    axis.cursor = undefined;
  }

  function listen(panel, axis) {
    const canvas = panel.canvas;
    let start = null;
    const at = (event) => Math.min(Math.max(event.clientX - canvas.getBoundingClientRect().left, LEFT), canvas.clientWidth - RIGHT);
    canvas.addEventListener("pointerdown", function (event) {
      if (event.button !== 0) return;
      start = at(event);
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", function (event) {
      const x = at(event);
      read(axis, panel.t(x));
      if (start !== null && Math.abs(x - start) > 3) {
        for (const other of axis.panels) {
          other.chosen.style.display = "block";
          other.chosen.style.left = Math.min(x, start) + "px";
          other.chosen.style.width = Math.abs(x - start) + "px";
        }
      }
    });
    const finish = function (event) {
      for (const other of axis.panels) other.chosen.style.display = "none";
      if (start !== null && event.type === "pointerup") {
        const x = at(event), a = panel.t(Math.min(x, start)), b = panel.t(Math.max(x, start));
        if (Math.abs(x - start) > 5) show(axis, a, b);
      }
      start = null;
    };
    canvas.addEventListener("pointerup", finish);
    canvas.addEventListener("pointercancel", finish);
    canvas.addEventListener("pointerleave", function () { if (start === null) unread(axis); });
    canvas.addEventListener("dblclick", function () { show(axis, axis.full[0], axis.full[1]); });
    canvas.addEventListener("keydown", function (event) { if (keys(axis, event)) event.preventDefault(); });
    canvas.addEventListener("blur", function () { unread(axis); });
  }

  function keys(axis, event) {
    if (!axis || event.ctrlKey || event.metaKey || event.altKey) return false;
    const [from, to] = axis.view, centre = axis.cursor;
    if (event.shiftKey && (event.key === "ArrowLeft" || event.key === "ArrowRight")) {
      const step = (event.key === "ArrowLeft" ? -1 : 1) * (to - from) / 400;
      read(axis, Math.min(to, Math.max(from, (centre === undefined ? 0.5 * (from + to) : centre) + step)));
    } else if (event.key === "ArrowLeft") pan(axis, -0.2);
    else if (event.key === "ArrowRight") pan(axis, 0.2);
    else if (event.key === "+" || event.key === "=") zoom(axis, 0.5, centre);
    else if (event.key === "-" || event.key === "\u2212") zoom(axis, 2.0, centre);
    else if (event.key === "0" || event.key === "Escape") show(axis, axis.full[0], axis.full[1]);
    else if (event.key === "n") jump(axis, 1);
    else if (event.key === "p") jump(axis, -1);
    else return false;
    return true;
  }

  const main = axes.time || Object.values(axes)[0];
  const actions = {
    previous: () => jump(main, -1), next: () => jump(main, 1), in: () => zoom(main, 0.5), out: () => zoom(main, 2.0),
    all: () => { for (const axis of Object.values(axes)) show(axis, axis.full[0], axis.full[1]); },
  };
  for (const button of document.querySelectorAll("[data-do]")) {
    button.addEventListener("click", actions[button.dataset.do]);
  }
  document.addEventListener("keydown", function (event) {
    if (event.target === document.body && main && !event.shiftKey && !/^Arrow/.test(event.key) && keys(main, event)) event.preventDefault();
  });

  const address = location.hash;
  for (const axis of Object.values(axes)) show(axis, axis.full[0], axis.full[1]);
  recall(address);
  window.addEventListener("hashchange", () => recall(location.hash));
  const observer = new IntersectionObserver(function (entries) {
    for (const entry of entries) {
      const panel = panels.find((p) => p.figure === entry.target);
      panel.seen = entry.isIntersecting;
    }
    refresh();
  }, { rootMargin: "300px" });
  for (const panel of panels) observer.observe(panel.figure);
  window.addEventListener("resize", redraw);
  window.addEventListener("beforeprint", function () {
    for (const panel of panels) { panel.ratio = 2; draw(panel); }
  });
  document.documentElement.dataset.panels = panels.length;
  document.documentElement.dataset.points = panels.reduce((n, p) => n + p.traces.reduce((m, t) => m + t.values.length, 0), 0);
})();
