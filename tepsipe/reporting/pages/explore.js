// Figures to try: what a wrong torque does to the fit, and the specification curve.
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

  const [LEFT, RIGHT, TOP, BOTTOM] = [58, 12, 10, 40];
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
      const [atX, digitsX] = ticks(xs, 6);
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
    const show = () => { output.textContent = `${shown(Number(input.value), digits)}${unit}`; };
    input.addEventListener("input", () => { show(); changed(); });
    show();
    return { label, get value() { return Number(input.value); }, set value(next) { input.value = next; show(); } };
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
  function framed(mount, title, words, controls, ...content) {
    mount.append(html("h4", {}, title), html("p", {}, words), html("div", { class: "controls" }, ...controls), ...content);
    mount.hidden = false;
  }

  // ---- the leg on the joint: J θ'' = m g r sin θ - m r cos θ y_f'' - R(θ, θ'); the momentum w = J θ' + m r cos θ v
  // needs the belt's velocity v only

  function swing(leg, joint, rate, velocity, start) {
    const inertia = joint.I + leg.inertia + leg.mass * leg.com ** 2;
    const p = leg.mass * leg.com;
    const rest = start - (p * leg.gravity * Math.sin(start)) / joint.K; // on which the leg stands at its first angle
    const slope = (theta, w, v) => {
      const rateOf = (w - p * Math.cos(theta) * v) / inertia;
      const resistance = joint.B * rateOf + joint.K * (theta - rest);
      return [rateOf, p * leg.gravity * Math.sin(theta) - resistance - p * Math.sin(theta) * rateOf * v];
    };
    const step = 1 / rate;
    const angle = new Float64Array(velocity.length);
    const speed = new Float64Array(velocity.length);
    let theta = start;
    let w = p * Math.cos(start) * velocity[0];
    for (let k = 0; k < velocity.length; k++) {
      angle[k] = theta;
      speed[k] = (w - p * Math.cos(theta) * velocity[k]) / inertia;
      if (k + 1 === velocity.length) break;
      const [v0, v2] = [velocity[k], velocity[k + 1]];
      const v1 = 0.5 * (v0 + v2);
      const [a1, b1] = slope(theta, w, v0);
      const [a2, b2] = slope(theta + 0.5 * step * a1, w + 0.5 * step * b1, v1);
      const [a3, b3] = slope(theta + 0.5 * step * a2, w + 0.5 * step * b2, v1);
      const [a4, b4] = slope(theta + step * a3, w + step * b3, v2);
      theta += (step / 6) * (a1 + 2 * a2 + 2 * a3 + a4);
      w += (step / 6) * (b1 + 2 * b2 + 2 * b3 + b4);
      if (!(Math.abs(theta) < Math.PI)) { angle.fill(NaN, k + 1); break; }
    }
    return { angle, speed };
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
    const picture = plot(640, 260, "Torque by the chosen equation, and the fitted model, during one pulse of the belt");
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
        return html("tr", {}, html("th", { scope: "row" }, html("i", {}, name), ` (${unit})`), html("td", { class: "n" }, shown(truth)), html("td", { class: off ? "n wrong" : "n right" }, shown(value)));
      };
      table.replaceChildren(
        html("thead", {}, html("tr", {}, ...["", "true", "returned"].map((words) => html("th", { scope: "col" }, words)))),
        html("tbody", {}, row("I", "N·m·s²/rad", own.I, found[0]), row("B", "N·m·s/rad", own.B, found[1]), row("K", "N·m/rad", own.K, found[2]),
          html("tr", {}, html("th", { scope: "row" }, "VAF of the torque"), html("td"), html("td", { class: "n" }, `${quality.toFixed(2)} %`))),
      );
    };
    const equation = choice("Signs of the torque equation", { printed: "as printed, eq (3-8)", consistent: "consistent" }, update);
    const mass = slider("Error of the leg's mass in the analysis", { low: -40, high: 40, step: 1, value: 0, unit: " %", digits: 2 }, update);
    const K = slider("True stiffness of the joint", { low: 3, high: 30, step: 0.1, value: joint.K, unit: " N·m/rad" }, update);
    framed(mount, "Try it: a wrong torque, fitted perfectly", "A simulated linear joint without noise. Choose a wrong sign or a wrong mass: the returned I, B and K change, and the fit stays perfect.", [equation.group, mass.label, K.label],
      picture.element, legend([["measured", "torque by the chosen equation"], ["model dashed", "fitted I θ″ + B θ′ + K θ"]]), table);
    update();
  }

  // ---- specification curve, to point at

  function specification(mount, { steps, rows, truth, limits }) {
    const picture = plot(640, 300, "Stiffness by every combination of choices, sorted");
    const about = html("dl", { class: "chosen" });
    const [low, high] = limits;
    const clipped = (value) => Math.min(Math.max(value, low), high);
    const marks = [];
    const select = html("select", {}, ...["one colour", ...steps].map((words, k) => html("option", { value: k - 1 }, words)));
    const point = html("input", { type: "range", min: 0, max: rows.length - 1, step: 1, value: rows.findIndex((row) => row.role === "recommended"), "aria-label": "Combination, in the order of K" });
    const colours = ["c0", "c1", "c2", "c3", "c4", "c5"];
    const key = html("p", { class: "key" });
    const draw = () => {
      picture.axes([0, rows.length + 1], [low - 0.05 * (high - low), high + 0.05 * (high - low)], "Combination, sorted by K", "K (N·m/rad)");
      if (truth !== null) picture.line([0, rows.length + 1], [truth, truth], "truth");
      const step = Number(select.value);
      const options = step < 0 ? [] : [...new Set(rows.map((row) => row.options[step]))].sort();
      marks.length = 0;
      rows.forEach((row, k) => {
        const kind = row.role ? "role" : step < 0 ? "c0" : colours[options.indexOf(row.options[step]) % colours.length];
        const mark = svg("circle", { cx: picture.x(k + 1), cy: picture.y(clipped(row.K)), r: row.role ? 5.5 : 2.6, class: kind });
        marks.push(mark);
        picture.element.append(mark);
      });
      key.replaceChildren(...options.map((words, k) => html("span", { class: `dot ${colours[k % colours.length]}` }, words)), html("span", { class: "dot role" }, "as printed, recommended"), ...(truth === null ? [] : [html("span", { class: "truth" }, `true K ${shown(truth)} N·m/rad`)]));
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
      const at = ((event.clientX - box.left) / box.width) * 640;
      const k = Math.round(((at - LEFT) / (640 - LEFT - RIGHT)) * (rows.length + 1)) - 1;
      if (k >= 0 && k < rows.length) { point.value = k; show(); }
    });
    point.addEventListener("input", show);
    select.addEventListener("change", draw);
    framed(mount, "Try it: every combination of choices", "Point at the curve, or move the slider, to read the choices behind a value. Values beyond the axis stand at its edge.", [html("label", {}, html("span", {}, "Colour by"), select), html("label", {}, html("span", {}, "Combination"), point)],
      picture.element, key, about);
    draw();
  }

  const kinds = { apparent, specification };
  for (const mount of document.querySelectorAll(".explorer[data-explore]")) {
    const kind = mount.dataset.explore;
    kinds[kind](mount, data[kind]);
  }
})();
