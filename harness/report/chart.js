"use strict";
// Charts as SVG: points and lines on logarithmic axes, or on linear ones.

const COLOURS = 10; // --colour-0 ... of page.css
/// After ten of them the same ones, nearer to the colour of the text.
const colour_of = (index) => {
  const colour = `var(--colour-${index % COLOURS})`;
  return index < COLOURS ? colour : `color-mix(in oklab, ${colour} 50%, var(--ink))`;
};
const SHAPES = ["M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0", "M-3.6-3.6h7.2v7.2h-7.2z", "M0-5L4.6 3.4h-9.2z", "M0-5.2L5.2 0 0 5.2-5.2 0z",
  "M0 5L4.6-3.4h-9.2z", "M-1.6-5h3.2v3.4h3.4v3.2h-3.4v3.4h-3.2v-3.4h-3.4v-3.2h3.4z", "M-5-1.8h10v3.6h-10z", "M-1.8-5h3.6v10h-3.6z"];

/// Numbers for the ticks between two ends: powers of ten, with 2 and 5 where there are few; or round steps.
function ticks(low, high, logarithmic) {
  if (!logarithmic) {
    const step = 10 ** Math.floor(Math.log10((high - low) / 4 || 1));
    const wide = [1, 2, 5, 10].map((m) => m * step).find((width) => (high - low) / width <= 6);
    const first = Math.ceil(low / wide - 1e-9);
    return Array.from({ length: Math.floor(high / wide + 1e-9) - first + 1 }, (_, i) => Number(((first + i) * wide).toPrecision(12)));
  }
  const decades = Math.log10(high / low);
  const within = decades < 2.2 ? [1, 2, 5] : [1];
  const every = Math.ceil(decades / 7);
  const all = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high) + 1e-9; ++power)
    if (power % every === 0) for (const m of within) all.push(m * 10 ** power);
  return all.filter((value) => value >= low * 0.9999 && value <= high * 1.0001);
}

/// 0.001, 1e-5, 2 000
const tick_text = (value) => (value !== 0 && Math.abs(value) < 1e-3 ? value.toExponential(0) : number(value));

function axis(values, name, { logarithmic = true, length, ends }) {
  let [low, high] = ends ?? [Math.min(...values), Math.max(...values)];
  if (logarithmic) [low, high] = low === high ? [low / 2, high * 2] : [low / 1.25, high * 1.25];
  else if (!ends) [low, high] = [low - (high - low) * 0.04 - (low === high), high + (high - low) * 0.04 + (low === high)];
  const f = logarithmic ? Math.log : (value) => value;
  return { name, ticks: ticks(low, high, logarithmic), at: (value) => (length * (f(value) - f(low))) / (f(high) - f(low)) };
}

/// A chart of series: [{keys: {backend: "openmp", ...}, points: [{x, y, tell, faint}], dashed}]. The first key chooses the
/// colour, the second the shape, and each key has a legend: a click on an entry switches its series off and on, a double
/// click leaves it alone. `tell` is the text that pointing at a dot shows.
/// x and y: {title, logarithmic, format, ends}; `measured`: ticks of x where points are. `front`: a line joins what no other
/// point beats in both. `marks`: [{x, text}], lines across the chart. `first`: {key: the values that are on at first}.
/// `groups`: {key: names the group of a value, which the legend puts before it}.
function logPlot(series, { x, y, front = false, height = 360, label = "chart", marks = [], first = {}, groups = {} }) {
  const width = 760, left = 78, right = 30, top = 12, bottom = 46;
  const usable = (point) => is_number(point.x) && is_number(point.y) &&
    (x.logarithmic === false || point.x > 0) && (y.logarithmic === false || point.y > 0);
  const drawn = series.map((one) => ({ ...one, points: one.points.filter(usable) })).filter((one) => one.points.length > 0);
  if (drawn.length === 0) return el("p", { class: "soft" }, "There is nothing to draw here.");
  const names = Object.keys(drawn[0].keys);
  const values = Object.fromEntries(names.map((key) => [key, distinct(drawn, (one) => one.keys[key])]));
  const hidden = Object.fromEntries(names.map((key) =>
    [key, new Set(first[key] ? values[key].filter((value) => !first[key].includes(value)) : [])]));
  const look = (one) => ({
    colour: colour_of(values[names[0]].indexOf(one.keys[names[0]])),
    shape: SHAPES[(names[1] ? values[names[1]].indexOf(one.keys[names[1]]) : 0) % SHAPES.length] });
  const svg = el("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label });
  const tip = el("div", { class: "tip", role: "status" });
  let dots = [];

  function draw() {
    const visible = drawn.filter((one) => names.every((key) => !hidden[key].has(one.keys[key])));
    const points = visible.flatMap((one) => one.points);
    const scale = points.length > 0 ? visible : drawn;
    const all = scale.flatMap((one) => one.points);
    const across = axis([...all, ...marks].map((p) => p.x), x.title, { ...x, length: width - left - right });
    const up = axis(all.map((p) => p.y), y.title, { ...y, length: height - top - bottom });
    const px = (point) => left + across.at(point.x);
    const py = (point) => height - bottom - up.at(point.y);
    const format = (one) => one.format ?? tick_text;
    const parts = [];
    for (const value of x.measured ? apart(distinct(all, (p) => p.x), across.at) : across.ticks) {
      const at = left + across.at(value);
      parts.push(el("line", { x1: at, x2: at, y1: top, y2: height - bottom, class: "grid" }),
        el("text", { x: at, y: height - bottom + 18, "text-anchor": "middle" }, format(x)(value)));
    }
    for (const value of up.ticks) {
      const at = height - bottom - up.at(value);
      parts.push(el("line", { x1: left, x2: width - right, y1: at, y2: at, class: "grid" }),
        el("text", { x: left - 8, y: at + 4, "text-anchor": "end" }, format(y)(value)));
    }
    parts.push(el("text", { x: left + (width - left - right) / 2, y: height - 8, "text-anchor": "middle", class: "title" }, x.title),
      el("text", { transform: `translate(14 ${top + (height - top - bottom) / 2}) rotate(-90)`, "text-anchor": "middle",
        class: "title" }, y.title));
    for (const one of visible) {
      if (one.points.length < 2) continue;
      parts.push(el("polyline", { points: one.points.map((p) => `${px(p).toFixed(1)},${py(p).toFixed(1)}`).join(" "),
        class: one.dashed ? "series dashed" : "series", style: `stroke:${look(one).colour}` }));
    }
    for (const mark of marks) {
      const at = px(mark);
      parts.push(el("line", { x1: at, x2: at, y1: top, y2: height - bottom, class: "mark" }),
        el("text", { transform: `translate(${at - 5} ${top + 4}) rotate(-90)`, "text-anchor": "end" }, mark.text));
    }
    if (front) parts.push(el("path", { class: "front", d: front_path(points.filter((p) => !p.faint), px, py, width - right) }));
    dots = visible.flatMap((one) => one.points.map((point) => ({ point, x: px(point), y: py(point), one })));
    for (const dot of dots.filter((other) => other.one.points.length < 80)) // of more a line says enough
      parts.push(el("path", { d: look(dot.one).shape, transform: `translate(${dot.x.toFixed(1)} ${dot.y.toFixed(1)})`,
        class: dot.point.faint ? "dot faint" : "dot", style: `fill:${look(dot.one).colour};stroke:${look(dot.one).colour}` }));
    parts.push(el("circle", { r: 8, class: "pointer", cx: -99, cy: -99 }));
    svg.replaceChildren(...parts);
  }
  function point_at(event) {
    const box = svg.getBoundingClientRect();
    const at = { x: ((event.clientX - box.left) * width) / box.width, y: ((event.clientY - box.top) * width) / box.width };
    const far = (dot) => Math.hypot(dot.x - at.x, dot.y - at.y);
    const near = dots.length > 0 ? dots.reduce((a, b) => (far(b) < far(a) ? b : a)) : undefined;
    if (near && far(near) < 30) tell(near);
  }
  function tell(dot) {
    const ring = svg.querySelector(".pointer");
    ring.setAttribute("cx", dot.x);
    ring.setAttribute("cy", dot.y);
    tip.replaceChildren(el("b", {}, Object.values(dot.one.keys).filter(Boolean).join(", ")), " ", dot.point.tell ?? "");
  }
  const legend = names.filter((key) => values[key].length > 1 || names.length === 1).map((key, index) => {
    const group_of = groups[key] ?? (() => "");
    const grouped = [...group_by(values[key].map((value) => ({ value })), (one) => group_of(one.value))];
    const entries = grouped.flatMap(([, some]) => some).map(({ value }) => {
      const one = drawn.find((other) => other.keys[key] === value);
      const mark = el("svg", { viewBox: "-6 -6 12 12", "aria-hidden": true },
        el("path", { d: key === names[1] ? look(one).shape : SHAPES[0],
          style: key === names[0] ? `fill:${look(one).colour}` : "fill:currentColor" }));
      return el("button", { type: "button", "aria-pressed": String(!hidden[key].has(value)), value,
        onclick: () => { hidden[key].has(value) ? hidden[key].delete(value) : hidden[key].add(value); refresh(); },
        ondblclick: () => { hidden[key] = new Set(values[key].filter((other) => other !== value)); refresh(); },
      }, mark, value || "rivals");
    });
    const refresh = () => {
      entries.forEach((entry) => entry.setAttribute("aria-pressed", String(!hidden[key].has(entry.value))));
      draw();
    };
    const all = el("button", { type: "button", class: "all", onclick: () => {
      hidden[key] = hidden[key].size > 0 ? new Set() : new Set(values[key]);
      refresh();
    } }, "all / none");
    return el("p", { class: "legend", "data-key": key }, names.length > 1 && el("span", { class: "soft" }, `${key} `),
      entries.map((entry, i) => [group_of(entry.value) !== group_of(entries[i - 1]?.value ?? NONE) &&
        el("span", { class: "soft" }, `${group_of(entry.value)} `), entry]),
      values[key].length > 3 && all);
  });
  svg.addEventListener("pointermove", point_at);
  svg.addEventListener("click", point_at);
  draw();
  tip.append(el("span", { class: "soft" },
    "Point at a dot to see its row; a click on a name switches it, a double click leaves it alone."));
  return el("figure", { class: "chart" }, legend, svg, tip);
}

/// Those of the values that lie far enough apart for their numbers to be read.
function apart(values, at) {
  const kept = [];
  for (const value of values.slice().sort((a, b) => a - b))
    if (kept.length === 0 || at(value) - at(kept.at(-1)) > 38) kept.push(value);
  return kept;
}

/// The staircase of the points that no other is both left of and below.
function front_path(points, px, py, end) {
  const sorted = points.slice().sort((a, b) => a.x - b.x || a.y - b.y);
  let path = "", best = Infinity;
  for (const point of sorted) {
    if (point.y >= best) continue;
    best = point.y;
    path += path ? `H${px(point).toFixed(1)}V${py(point).toFixed(1)}` : `M${px(point).toFixed(1)} ${py(point).toFixed(1)}`;
  }
  return path ? `${path}H${end}` : "";
}
