// Figures to try: what a wrong torque does to the fit, the simulated leg, the specification curve, and the printed cells.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("page-data").textContent);
  const NS = "http://www.w3.org/2000/svg";
  const svg = (tag, attributes = {}, words) => {
    const element = document.createElementNS(NS, tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    if (words !== undefined) element.textContent = words;
    return element;
  };
  const html = (tag, attributes = {}, ...children) => {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    element.append(...children);
    return element;
  };
  const shown = (value, digits = 3) => {
    if (!Number.isFinite(value)) return "–";
    const size = Math.abs(value);
    const decimals = size === 0 ? 0 : Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
    return value.toFixed(Math.min(decimals, 6)).replace("-", "−");
  };

  // ---- a plot with axes: lines and points of data in their units

  const [LEFT, RIGHT, TOP, BOTTOM] = [68, 12, 10, 40];
  const WIDTH = matchMedia("(max-width: 32rem)").matches ? 340 : 640; // letters of one size on all screens
  function plot(width, height, label) {
    const element = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label, class: "plot" });
    const area = { x: [0, 1], y: [0, 1] };
    const x = (value) => LEFT + ((value - area.x[0]) / (area.x[1] - area.x[0])) * (width - LEFT - RIGHT);
    const y = (value) => height - BOTTOM - ((value - area.y[0]) / (area.y[1] - area.y[0])) * (height - TOP - BOTTOM);
    const ticks = ([low, high], count) => {
      const raw = (high - low) / count;
      const power = 10 ** Math.floor(Math.log10(raw));
      const step = [1, 2, 5, 10].map((k) => k * power).find((k) => k >= raw);
      const found = [];
      for (let value = Math.ceil(low / step) * step; value <= high + 1e-9 * step; value += step) found.push(Math.abs(value) < 1e-9 * step ? 0 : value);
      return [found, Math.max(0, -Math.floor(Math.log10(step) + 1e-9))];
    };
    const axes = (xs, ys, across, up) => {
      Object.assign(area, { x: xs, y: ys });
      element.replaceChildren();
      const [atX, digitsX] = ticks(xs, WIDTH / 107);
      const [atY, digitsY] = ticks(ys, 5);
      for (const value of atX) {
        element.append(svg("line", { x1: x(value), x2: x(value), y1: TOP, y2: height - BOTTOM, class: "grid" }));
        element.append(svg("text", { x: x(value), y: height - BOTTOM + 15, "text-anchor": "middle" }, value.toFixed(digitsX).replace("-", "−")));
      }
      for (const value of atY) {
        element.append(svg("line", { x1: LEFT, x2: width - RIGHT, y1: y(value), y2: y(value), class: "grid" }));
        element.append(svg("text", { x: LEFT - 6, y: y(value) + 4, "text-anchor": "end" }, value.toFixed(digitsY).replace("-", "−")));
      }
      element.append(svg("text", { x: (LEFT + width - RIGHT) / 2, y: height - 6, "text-anchor": "middle" }, across));
      element.append(svg("text", { x: 14, y: (TOP + height - BOTTOM) / 2, "text-anchor": "middle", transform: `rotate(-90 14 ${(TOP + height - BOTTOM) / 2})` }, up));
    };
    const line = (xs, ys, kind) => {
      const clip = ([low, high], value) => Math.min(Math.max(value, low - (high - low)), high + (high - low));
      const points = xs.map((value, k) => `${x(value).toFixed(1)},${y(clip(area.y, ys[k])).toFixed(1)}`).join(" ");
      element.append(svg("polyline", { points, class: kind }));
    };
    return { element, axes, line, x, y, area };
  }

  // ---- controls

  function slider(name, { low, high, step, value, unit = "", digits = 3 }, changed) {
    const input = html("input", { type: "range", min: low, max: high, step, value });
    const output = html("output");
    const label = html("label", {}, html("span", {}, name), input, output);
    let exact = value; // a value that is set does not move to the next step
    const show = () => { output.textContent = `${shown(exact, digits)}${unit}`; };
    input.addEventListener("input", () => { exact = Number(input.value); show(); changed(); });
    show();
    return { label, get value() { return exact; }, set value(next) { input.value = exact = next; show(); } };
  }
  function choice(name, options, changed) {
    const group = html("fieldset", { class: "choice" }, html("legend", {}, name));
    const id = `choice-${Math.random().toString(36).slice(2)}`;
    let chosen = Object.keys(options)[0];
    for (const [key, words] of Object.entries(options)) {
      const input = html("input", { type: "radio", name: id, value: key });
      input.checked = key === chosen;
      input.addEventListener("change", () => { chosen = key; changed(); });
      group.append(html("label", {}, input, words));
    }
    return { group, get value() { return chosen; } };
  }
  function legend(entries) {
    const list = html("p", { class: "key" });
    for (const [kind, words] of entries) list.append(html("span", { class: kind }, words));
    return list;
  }
  function framed(mount, words, controls, ...content) {
    mount.append(html("p", { class: "title" }, mount.dataset.title), html("p", {}, words), html("div", { class: "controls" }, ...controls), ...content);
    mount.hidden = false;
  }

  function leastSquares(columns, target) {
    const n = columns.length;
    const rows = columns.map((a) => [...columns.map((b) => a.reduce((sum, value, k) => sum + value * b[k], 0)), a.reduce((sum, value, k) => sum + value * target[k], 0)]);
    for (let k = 0; k < n; k++) {
      for (let i = 0; i < n; i++) {
        if (i === k) continue;
        const factor = rows[i][k] / rows[k][k];
        for (let j = k; j <= n; j++) rows[i][j] -= factor * rows[k][j];
      }
    }
    return rows.map((row, k) => row[n] / row[k]);
  }
  const vaf = (measured, predicted) => {
    let [error, power] = [0, 0];
    measured.forEach((value, k) => { error += (value - predicted[k]) ** 2; power += value ** 2; });
    return 100 * (1 - error / power);
  };

  // ---- a wrong torque, fitted perfectly

  function apparent(mount, { leg, joint }) {
    const rate = 2000;
    const time = Array.from({ length: 0.3 * rate }, (_, k) => k / rate);
    const velocity = Float64Array.from(time, (t) => (t > 0.02 && t < 0.12 ? 0.15 * (1 - Math.cos((2 * Math.PI * (t - 0.02)) / 0.1)) : 0));
    const picture = plot(WIDTH, 260, "Torque by the chosen equation, and the fitted model, during one pulse of the belt");
    const table = html("table", { class: "returned" });
    const update = () => {
      const own = { ...joint, K: K.value };
      const { angle, speed } = swing(leg, own, rate, velocity, 0);
      const acceleration = Float64Array.from(speed, (_, k) => (k === 0 || k + 1 === speed.length ? 0 : 0.5 * rate * (speed[k + 1] - speed[k - 1])));
      const belt = Float64Array.from(velocity, (_, k) => (k === 0 || k + 1 === velocity.length ? 0 : 0.5 * rate * (velocity[k + 1] - velocity[k - 1])));
      const used = leg.mass * (1 + mass.value / 100);
      const sign = equation.value === "printed" ? -1 : 1;
      const torque = time.map((_, k) => {
        const along = belt[k] + leg.com * acceleration[k];
        return -(used * leg.com * along + sign * (leg.inertia * acceleration[k] - used * leg.gravity * leg.com * angle[k]));
      });
      const inside = time.map((t, k) => k).filter((k) => time[k] > 0.02 && time[k] < 0.28);
      const pick = (values) => inside.map((k) => values[k]);
      const found = leastSquares([acceleration, speed, angle].map(pick), pick(torque));
      const fitted = time.map((_, k) => found[0] * acceleration[k] + found[1] * speed[k] + found[2] * angle[k]);
      const most = Math.max(...torque.map(Math.abs), ...fitted.map(Math.abs)) * 1.1 || 1;
      picture.axes([0, 0.3], [-most, most], "Time (s)", "Torque (N·m)");
      picture.line(time, torque, "measured");
      picture.line(time, fitted, "model dashed");
      const quality = vaf(pick(torque), pick(fitted));
      const row = (name, unit, truth, value) => {
        const off = Math.abs(value - truth) > 0.02 * Math.abs(truth) + 1e-4;
        return html("tr", {}, html("th", { scope: "row" }, html("i", {}, name), ` (${unit})`), html("td", { class: "n" }, shown(truth)), html("td", { class: off ? "n wrong" : "n right" }, shown(value), html("b", { role: "img", "aria-label": off ? "wrong" : "as true" }, off ? "✗" : "✓")));
      };
      table.replaceChildren(
        html("thead", {}, html("tr", {}, html("td"), ...["true", "returned"].map((words) => html("th", { scope: "col" }, words)))),
        html("tbody", {}, row("I", "N·m·s²/rad", own.I, found[0]), row("B", "N·m·s/rad", own.B, found[1]), row("K", "N·m/rad", own.K, found[2]),
          html("tr", {}, html("th", { scope: "row" }, "VAF of the torque"), html("td"), html("td", { class: "n" }, `${quality.toFixed(2)} %`))),
      );
    };
    const equation = choice("Signs of the torque equation", { printed: "as printed, eq (3-8)", consistent: "consistent" }, update);
    const mass = slider("Error of the leg's mass in the analysis", { low: -40, high: 40, step: 1, value: 0, unit: " %", digits: 2 }, update);
    const K = slider("True stiffness of the joint", { low: 3, high: 30, step: 0.1, value: joint.K, unit: " N·m/rad" }, update);
    framed(mount, "A simulated linear joint without noise. Choose a wrong sign or a wrong mass: the returned I, B and K change, and the fit stays perfect.", [equation.group, mass.label, K.label],
      picture.element, legend([["measured", "torque by the chosen equation"], ["model dashed", "fitted I θ″ + B θ′ + K θ"]]), table);
    update();
  }

  // ---- the simulated leg against the recorded one

  function unpacked({ offset, scale, text }) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    return Float64Array.from(new Int16Array(bytes.buffer), (value) => offset + scale * value);
  }

  function forward(mount, { leg, rate, standing, velocity, angle, windows, sets, truth, condition }) {
    const foot = unpacked(velocity);
    const recorded = unpacked(angle);
    const whole = plot(WIDTH, 190, `Recorded and simulated angle of the leg in the whole trial ${condition}`);
    const near = plot(WIDTH, 230, "The same from one pulse to the next");
    const table = html("table", { class: "returned" });
    const soft = sets.find((own) => own.C || own.D) ?? null;
    const joint = () => ({ I: I.value, B: B.value, K: K.value, ...(soft && softening.value ? { C: (softening.value / 100) * soft.C, D: (softening.value / 100) * soft.D, half: soft.half } : {}) });
    const limits = (...traces) => {
      const values = traces.flatMap((trace) => trace.filter(Number.isFinite));
      const [low, high] = [Math.min(...values), Math.max(...values)];
      const margin = 0.06 * (high - low) || 0.01;
      return [low - margin, high + margin];
    };
    let simulated = recorded;
    const zoomed = () => {
      const [start] = windows[pulse.value - 1];
      const next = windows[pulse.value]?.[0] ?? start + (windows[1] ? windows[1][0] - windows[0][0] : 3 * rate);
      const [from, to] = [Math.max(0, start - Math.round(0.2 * rate)), Math.min(recorded.length, next)];
      const time = Array.from({ length: to - from }, (_, k) => (from + k) / rate);
      const [measured, model] = [recorded.subarray(from, to), simulated.subarray(from, to)].map((part) => [...part]);
      near.axes([time[0], time.at(-1)], limits(measured, model), "Time (s)", "Angle from rest (rad)");
      near.line(time, measured, "measured");
      near.line(time.filter((_, k) => Number.isFinite(model[k])), model.filter(Number.isFinite), "model dashed");
    };
    const update = () => {
      simulated = swing(leg, joint(), rate, foot, standing).angle.map((theta) => theta - standing);
      const every = Math.max(1, Math.floor(recorded.length / 2500));
      const kept = [...recorded.keys()].filter((k) => k % every === 0);
      const upright = kept.filter((k) => Number.isFinite(simulated[k]));
      const of = (trace, places) => places.map((k) => trace[k]);
      whole.axes([0, recorded.length / rate], limits(of(recorded, kept), of(simulated, upright)), "Time (s)", "Angle from rest (rad)");
      whole.line(kept.map((k) => k / rate), of(recorded, kept), "measured");
      whole.line(upright.map((k) => k / rate), of(simulated, upright), "model dashed");
      zoomed();
      const predicted = simulated.map((theta) => (Number.isFinite(theta) ? theta : 0));
      const pulses = windows.map(([start, stop]) => vaf(recorded.subarray(start, stop), predicted.subarray(start, stop)));
      const row = (name, value) => html("tr", {}, html("th", { scope: "row" }, name), html("td", { class: "n" }, value));
      table.replaceChildren(html("tbody", {},
        row("VAF of the angle during the pulses, mean", `${shown(pulses.reduce((sum, value) => sum + value, 0) / pulses.length, 4)} %`),
        row("VAF of the angle in the whole trial", `${shown(vaf(recorded, predicted), 4)} %`),
        ...(upright.length < kept.length ? [row("The leg falls after", `${shown(upright.at(-1) / rate)} s`)] : [])));
    };
    const own = () => { from.value = ""; update(); };
    const true_ = (q) => (truth ? `, true ${shown(truth[q])}` : "");
    const first = sets[0];
    const I = slider(`Inertia I${true_("I")}`, { low: -0.02, high: 0.08, step: 0.0005, value: first.I, unit: " N·m·s²/rad" }, own);
    const B = slider(`Damping B${true_("B")}`, { low: -0.05, high: 0.4, step: 0.001, value: first.B, unit: " N·m·s/rad" }, own);
    const K = slider(`Stiffness K${true_("K")}`, { low: 2.5, high: 25, step: 0.05, value: first.K, unit: " N·m/rad" }, own);
    const softening = slider("Softening (100 %: as fitted)", { low: 0, high: 150, step: 1, value: first.C || first.D ? 100 : 0, unit: " %" }, own);
    const pulse = slider("Pulse in the second plot", { low: 1, high: windows.length, step: 1, value: Math.min(2, windows.length), digits: 1 }, zoomed);
    const from = html("select", {}, ...sets.map((set) => html("option", { value: set.name }, set.name)), html("option", { value: "" }, "own values"));
    from.addEventListener("change", () => {
      const set = sets.find(({ name }) => name === from.value);
      if (!set) return;
      for (const [control, q] of [[I, "I"], [B, "B"], [K, "K"]]) control.value = set[q];
      softening.value = set.C || set.D ? 100 : 0;
      update();
    });
    framed(mount, `The foot moves as recorded in ${condition}, and the leg follows on the joint that you choose. During the pulses, many joints predict the angle. Between the pulses the leg swings freely, and only the right stiffness and softening reproduce the timing of the swing.${truth ? " The true values hold for small movements." : ""}`,
      [html("label", {}, html("span", {}, "Parameters"), from), I.label, B.label, K.label, ...(soft ? [softening.label] : []), pulse.label],
      whole.element, near.element, legend([["measured", "recorded"], ["model dashed", "simulated"]]), table);
    update();
  }

  // ---- specification curve, to point at

  function specification(mount, { steps, rows, quoted, truth, limits }) {
    const picture = plot(WIDTH, 300, "Stiffness by every combination of choices, sorted");
    const about = html("dl", { class: "chosen" });
    const [low, high] = limits;
    const clipped = (value) => Math.min(Math.max(value, low), high);
    const marks = [];
    const select = html("select", {}, ...["one colour", ...steps].map((words, k) => html("option", { value: k - 1 }, words)));
    const point = html("input", { type: "range", min: 0, max: rows.length - 1, step: 1, value: Math.max(0, rows.findLastIndex((row) => row.role)), "aria-label": "Combination, in the order of K" });
    const colours = ["c0", "c1", "c2", "c3", "c4", "c5"];
    const key = html("p", { class: "key" });
    const draw = () => {
      picture.axes([0, rows.length + 1], [low - 0.05 * (high - low), high + 0.05 * (high - low)], "Combination, sorted by K", "K (N·m/rad)");
      if (truth !== null) picture.line([0, rows.length + 1], [truth, truth], "truth");
      if (quoted !== null) picture.line([0, rows.length + 1], [quoted.K, quoted.K], "quoted");
      const step = Number(select.value);
      const options = step < 0 ? [] : [...new Set(rows.map((row) => row.options[step]))].sort();
      marks.length = 0;
      rows.forEach((row, k) => {
        const kind = row.role ? "role" : step < 0 ? "c0" : colours[options.indexOf(row.options[step]) % colours.length];
        const mark = svg("circle", { cx: picture.x(k + 1), cy: picture.y(clipped(row.K)), r: row.role ? 5.5 : 2.6, class: kind });
        marks.push(mark);
        picture.element.append(mark);
      });
      key.replaceChildren(...options.map((words, k) => html("span", { class: `dot ${colours[k % colours.length]}` }, words)), html("span", { class: "dot role" }, [...new Set(rows.map((row) => row.role).filter(Boolean))].join("; ")), ...(quoted === null ? [] : [html("span", { class: "quoted" }, `recommended estimate (${quoted.by}): K ${shown(quoted.K)} N·m/rad`)]), ...(truth === null ? [] : [html("span", { class: "truth" }, `true K ${shown(truth)} N·m/rad`)]));
      show();
    };
    const show = () => {
      const k = Number(point.value);
      const row = rows[k];
      marks.forEach((mark, i) => mark.classList.toggle("on", i === k));
      const item = (name, value) => html("div", {}, html("dt", {}, name), html("dd", {}, value));
      about.replaceChildren(
        item("K", `${shown(row.K)} N·m/rad`), item("B", `${shown(row.B)} N·m·s/rad`), item("VAF", Number.isFinite(row.VAF) ? `${shown(row.VAF)} %` : "–"),
        ...steps.map((name, i) => item(name, row.options[i])), ...(row.role ? [item("This is", row.role)] : []),
      );
    };
    picture.element.addEventListener("pointermove", (event) => {
      const box = picture.element.getBoundingClientRect();
      const at = ((event.clientX - box.left) / box.width) * WIDTH;
      const k = Math.round(((at - LEFT) / (WIDTH - LEFT - RIGHT)) * (rows.length + 1)) - 1;
      if (k >= 0 && k < rows.length) { point.value = k; show(); }
    });
    point.addEventListener("input", show);
    select.addEventListener("change", draw);
    framed(mount, "Point at the curve, or move the slider, to read the choices behind a value. Values beyond the axis are drawn at its edge.", [html("label", {}, html("span", {}, "Colour by"), select), html("label", {}, html("span", {}, "Combination"), point)],
      picture.element, key, about);
    draw();
  }

  // ---- printed cells: one tab stop per table, arrow keys from cell to cell

  function printed(block) {
    const about = block.querySelector(".cell-about");
    const show = (cell) => {
      const table = cell.closest("table");
      const column = table.tHead.rows[0].cells[cell.cellIndex].textContent;
      const place = `${table.caption.textContent}, ${cell.parentElement.cells[0].textContent}, ${column}`;
      const pairs = [["cell", place], ...cell.dataset.about.split("\n").map((line) => [line.slice(0, line.indexOf(": ")), line.slice(line.indexOf(": ") + 2)])];
      about.replaceChildren(...pairs.map(([name, value]) => html("div", {}, html("dt", {}, name), html("dd", {}, value))));
      about.hidden = false;
      block.querySelector("td.on")?.classList.remove("on");
      cell.classList.add("on");
    };
    const select = (cell) => {
      for (const other of cell.closest("table").querySelectorAll("td[tabindex]")) other.tabIndex = other === cell ? 0 : -1;
      cell.focus();
      show(cell);
    };
    for (const table of block.querySelectorAll("table.cells")) {
      const cells = [...table.querySelectorAll("td[title]")];
      table.setAttribute("role", "grid");
      table.closest(".wide").removeAttribute("tabindex");
      cells.forEach((cell, k) => {
        cell.dataset.about = cell.title;
        cell.removeAttribute("title");
        cell.tabIndex = k === 0 ? 0 : -1;
        cell.addEventListener("pointerenter", () => show(cell));
        cell.addEventListener("click", () => select(cell));
        cell.addEventListener("focus", () => show(cell));
      });
      table.addEventListener("keydown", (event) => {
        const [down, across] = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[event.key] ?? [0, 0];
        const cell = event.target.closest("td[tabindex]");
        if (!cell || (!down && !across)) return;
        event.preventDefault();
        const rows = [...table.tBodies[0].rows];
        const next = rows[rows.indexOf(cell.parentElement) + down]?.cells[cell.cellIndex + across];
        if (next?.dataset.about) select(next);
      });
    }
  }
  document.querySelectorAll(".printed-cells").forEach(printed);

  const kinds = { apparent, forward, specification };
  for (const mount of document.querySelectorAll(".explorer[data-explore]")) {
    const kind = mount.dataset.explore;
    kinds[kind](mount, data[kind]);
  }
})();
