"use strict";
// The four parts of the page that stand open, and what all parts share. A new column of a table is one line:
// {key, title, format}. `data` has published figures and picture(row, name).

const SCENE = [{ key: "scene", title: "scene" }, { key: (row) => row.width, title: "size", format: (value, row) => size_of(row) }];
const BACKEND = [{ key: "backend", title: "backend" }, { key: "device", title: "device" }];
const SECONDS = { key: "seconds_median", title: "seconds, median", format: seconds };
const RMSD = [
  { key: "rmsd_to_fem_nu0", title: "px to FEM, ν = 0" },
  { key: "rmsd_to_fem", title: "px to FEM, ν of the scene" },
  { key: "rmsd_to_fixed_point", title: "px to the fixed point" },
];

const text = (...parts) => el("p", {}, ...parts);
const fold = (title, ...content) => el("details", {}, el("summary", {}, title), ...content);
const scene_of = (row) => `${row.scene}, ${size_of(row)}`;
const options = (rows, key) => distinct(rows, key).map((value) => [value]);
const sizes_of = (rows) => options(rows.toSorted((a, b) => a.width - b.width), size_of);

/// A series of a chart from rows; a point without x or y is not drawn.
const series_of = (keys, rows, { x, y, tell, faint, dashed }) => ({
  keys,
  dashed,
  points: rows.map((row) => ({ x: x(row), y: y(row), tell: tell(row), faint: faint?.(row) })).sort((a, b) => a.x - b.x),
});

/// Pictures with a caption each, of those that are there: [[uri, caption], ...].
function figures(pictures) {
  const there = pictures.filter(([uri]) => uri);
  const figure = ([uri, caption]) => el("figure", {}, el("img", { src: uri, alt: caption }), el("figcaption", {}, caption));
  return there.length > 0 && el("div", { class: "pictures" }, there.map(figure));
}

// Speed against accuracy

/// How far a field is from what its method approximates: finite elements with the Poisson ratio that it has.
const own_error = (row) => (row.poisson_used ? row.rmsd_to_fem : row.rmsd_to_fem_nu0);
const TRUTHS = [
  ["own", "finite elements, ν as the method has it"],
  ["rmsd_to_fem_nu0", "finite elements, ν = 0"],
  ["rmsd_to_fem", "finite elements, ν of the scene"],
  ["rmsd_to_fixed_point", "the fixed point of the thesis's energy"],
];
const POINTS = [
  { key: "method", title: "method" },
  { key: "effort", title: "effort" },
  { key: "backend", title: "backend" },
  SECONDS,
  { key: own_error, title: "px to FEM, own ν" },
  ...RMSD,
  { key: "asked", title: "px asked" },
  { key: "estimated_error", title: "px estimated" },
  { key: "fine_sweep_equivalents", title: "sweeps of the full image" },
  { key: "status", title: "status", format: verdict },
  { key: "reason", title: "reason" },
  { key: "command", title: "the line that repeats it", format: code },
];
const faster = (key, title) => ({ key: `${key}.ratio`, title, format: times });
const EQUAL = [
  ...SCENE,
  { key: "target", title: "px to FEM at most" },
  { key: "ours.method", title: "our fastest" },
  { key: "ours.backend", title: "backend" },
  { key: "ours.effort", title: "effort" },
  { key: "ours.seconds_median", title: "seconds", format: seconds },
  { key: "ours.rmsd_to_fem_nu0", title: "px reached" },
  faster("direct", "faster than direct FEM"),
  faster("iterative", "than FEM by conjugate gradients"),
  faster("multigrid", "than FEM by multigrid"),
  faster("coarse", "than FEM on a coarse mesh"),
  { key: "nearest", title: "px of our nearest" },
];

function tradeoff(rows) {
  const points = rows.filter((row) => row.kind !== "equal accuracy");
  const equal = rows.filter((row) => row.kind === "equal accuracy");
  const scenes = options(points, "scene").sort(([a], [b]) => (b === "brain") - (a === "brain"));
  const rank = (row) => (row.rival ? 1 : row.poisson_used === undefined ? 2 : 0); // what is nearest to the truth first
  const draw = ({ scene, size, truth }) => {
    const here = points.filter((row) => row.scene === scene && size_of(row) === size).sort((a, b) => rank(a) - rank(b));
    const curves = group_by(here, (row) => `${row.method}\n${row.backend}\n${row.poisson_used}`);
    const series = [...curves.values()].map((curve) => series_of({ method: curve[0].method, backend: curve[0].backend }, curve, {
      x: (row) => row.seconds_median,
      y: (row) => (truth === "own" ? own_error(row) : row[truth]),
      faint: (row) => row.valid === false || row.status !== "ok",
      tell: (row) => `${row.effort}${row.device ? `, ${row.device}` : ""}: ${seconds(row.seconds_median)}, ` +
        `${number(own_error(row))} px from finite elements. ${row.reason || row.command || ""}`,
    }));
    return [
      logPlot(series, {
        label: `speed against accuracy, ${scene}`, front: true, height: 440,
        x: { title: "seconds of a whole solution", format: seconds },
        y: { title: "px to the truth, RMS over all sites" },
      }),
      fold(`All ${plural(here.length, "point")} of ${scene}, ${size}`, table(here, POINTS)),
    ];
  };
  return [
    chosen_view({ scene: ["Scene", scenes], size: ["Size", sizes_of(points)], truth: ["Distance to", TRUTHS] }, draw),
    text("Lower left is better. The line is the front: nothing measured is both faster and nearer. " +
      "A pale dot is a result that is not scalar's to the bit, or that failed."),
    equal.length > 0 && fold("How many times faster than finite elements, at equal accuracy", table(equal, EQUAL)),
  ];
}

// Before and after

/// Two pictures in one place, and a slider for how much of the second is seen.
function before_and_after(before, after, name) {
  const over = el("img", { src: after, alt: `${name}, after`, class: "over" });
  const both = el("div", {}, el("img", { src: before, alt: `${name}, before` }), over);
  const set = (value) => {
    over.style.clipPath = `inset(0 0 0 ${value}%)`;
    both.style.setProperty("--at", `${value}%`);
  };
  const slider = el("input", { type: "range", min: 0, max: 100, value: 50, "aria-label": "before and after",
    oninput: () => set(slider.value) });
  set(50);
  return el("figure", { class: "slider" }, both, slider,
    el("figcaption", {}, "left of the line before, right of it after: move the slider"));
}

const RUN = [
  ...SCENE,
  ...BACKEND,
  { key: "method", title: "method" },
  { key: "energy", title: "energy" },
  { key: "seconds", title: "seconds", format: seconds },
  { key: "iterations", title: "iterations" },
  { key: "mean_energy", title: "mean energy" },
  { key: "largest_displacement", title: "largest displacement, px" },
  { key: "spacing", title: "mm a pixel" },
  { key: "plan.asked_px", title: "px asked" },
  { key: "plan.estimated_px", title: "px estimated" },
  { key: (row) => row.warnings?.length, title: "warnings" },
  { key: "field", title: "field", format: code },
];
const WARNINGS = [
  { key: "scene", title: "scene" },
  { key: "kind", title: "kind" },
  { key: "sites", title: "sites", format: count },
  { key: "message", title: "what" },
  { key: "advice", title: "what to do" },
];

function pictures(rows, data) {
  const shown = rows.filter((row) => data.picture(row, row.pictures?.after));
  const warnings = rows.flatMap((row) => (row.warnings ?? []).map((warning) => ({ scene: row.scene, ...warning })));
  const draw = ({ run }) => {
    const row = shown[run];
    const of = (name) => data.picture(row, row.pictures[name]);
    const others = figures([[of("grid"), "the grid, deformed"], [of("magnitude"), "how far each pixel moved; black is 0"]]);
    const first = of("before") ? before_and_after(of("before"), of("after"), row.scene) : figures([[of("after"), "after"]]);
    return el("div", { class: "pictures" }, first, ...(others ? others.children : []));
  };
  return [
    shown.length > 0 && chosen_view({ run: ["Scene", shown.map((row, i) => [String(i), row.title || scene_of(row)])] }, draw),
    table(rows, RUN),
    warnings.length > 0 && fold(`${plural(warnings.length, "warning")} of these runs`, table(warnings, WARNINGS)),
  ];
}

// Agreement

const TIERS = ["none", "certified", "bitwise", "exact"];
const TIER_WORDS = [
  ["exact", "exact: same bits where nothing is ever rounded"],
  ["bitwise", "bitwise: same bits"],
  ["certified", "certified: each difference within a derived bound"],
  ["mistrusted", "mistrusted: could not have shown a difference"],
  ["disagree", "disagrees"],
  ["skipped", "skipped"],
];
const place_of = (first) => first && `level ${first.level}, iteration ${first.iteration}, x = ${first.x}, y = ${first.y}`;
const VERIFY = [
  ...SCENE,
  { key: "method", title: "method" },
  { key: "mode", title: "mode" },
  { key: "backend", title: "backend" },
  { key: "verdict", title: "verdict", format: verdict },
  { key: "tier", title: "tier" },
  { key: "sites_compared", title: "sites compared", format: count },
  { key: "sites_differing", title: "differ", format: count },
  { key: "certified_ties", title: "certified", format: count },
  { key: "uncertified", title: "not certified", format: count },
  { key: "counts_differing", title: "wrong counts", format: count },
  { key: "not_finite", title: "not finite", format: count },
  { key: "iterations", title: "iterations", format: count },
  { key: "max_abs_difference", title: "largest difference, px" },
  { key: (row) => place_of(row.first_difference), title: "first difference" },
  { key: "reason", title: "reason" },
  { key: "ranks", title: "ranks" },
  { key: "device", title: "device" },
];

/// What a cell says of its rows, and its colour: the worst of those that ran.
function worst_of(rows) {
  const ran = rows.filter((row) => row.verdict !== "skipped");
  if (ran.length === 0) return { words: "skipped", tone: "skipped" };
  const agrees = (row) => row.verdict === "certified" || (row.verdict === "agree" && !(row.sites_differing > 0));
  const wrong = ran.filter((row) => !agrees(row));
  if (wrong.some((row) => row.verdict !== "mistrusted")) return { words: `✗ ${wrong.length} of ${ran.length}`, tone: "disagree" };
  if (wrong.length > 0) return { words: `? ${wrong.length} of ${ran.length}`, tone: "mistrusted" };
  const tier = TIERS[Math.min(...ran.map((row) => TIERS.indexOf(row.tier)))] ?? "none";
  return { words: `${tier === "certified" ? "≈" : "✓"} ${ran.length}`, tone: tier };
}

/// The lines that repeat the comparisons of a cell. Results of before do not say them.
function repeat_lines(rows) {
  return distinct(rows, (row) => row.repeat ??
    `hdmbench verify ${row.scene} --size ${row.width}x${row.height} --methods ${row.method} --backends ${row.backend}`);
}

function agreement(rows, data) {
  const backends = distinct(rows, "backend"), scenes = distinct(rows, "scene");
  const below = el("div", { class: "picked" }, text("A cell has the number of comparisons; click on one to see them."));
  const pick = (mine) => below.replaceChildren(
    el("h3", {}, `${mine[0].backend} on ${mine[0].scene}`),
    el("pre", {}, repeat_lines(mine).join("\n")),
    table(mine, VERIFY));
  const cell = (scene, backend) => {
    const mine = rows.filter((row) => row.scene === scene && row.backend === backend);
    if (mine.length === 0) return el("td", {}, NONE);
    const { words, tone } = worst_of(mine);
    return el("td", { class: `tier ${tone}` },
      el("button", { type: "button", "data-cell": `${scene} ${backend}`, onclick: () => pick(mine) }, words));
  };
  const line = (scene) => el("tr", {}, el("th", { scope: "row" }, scene), backends.map((backend) => cell(scene, backend)));
  return [
    el("div", { class: "scroll" }, el("table", { class: "matrix" },
      el("thead", {}, el("tr", {}, el("th", {}, "scene"), backends.map((backend) => el("th", { scope: "col" }, backend)))),
      el("tbody", {}, scenes.map(line)))),
    el("p", { class: "key" }, TIER_WORDS.map(([tone, words]) =>
      [el("span", { class: `tier ${tone}` }, "\u00a0\u00a0\u00a0"), ` ${words} `])),
    below,
    fold(`All ${plural(rows.length, "comparison")}`, table(rows, VERIFY)),
  ];
}

// Speed over sizes

const SPEED = [
  ...SCENE,
  { key: "backend", title: "backend" },
  { key: "method", title: "method" },
  { key: "effort", title: "iterations a level" },
  { ...SECONDS, title: "seconds" },
  { key: "speed_up_over_scalar", title: "over scalar", format: times },
  { key: "speed_up_over_dense", title: "over dense", format: times },
  { key: "msites_per_second", title: "million sites/s" },
  { key: "percent_of_ceiling", title: "of the ceiling", format: unit("%") },
  { key: "binding", title: "bound by" },
  { key: "bytes_per_site", title: "bytes a site" },
  { key: "threads", title: "threads" },
  { key: "setup_seconds", title: "set-up", format: seconds },
  { key: "peak_memory_bytes", title: "memory", format: unit("MB", 1e-6) },
  { key: "reason", title: "not verified because" },
  { key: "device", title: "device" },
];
const published_rows = ({ table: of, scene, size, gpu_seconds, cpu_seconds, speed_up }) => [
  { name: "GPU", seconds_median: gpu_seconds, speed_up_over_scalar: speed_up },
  { name: "CPU", seconds_median: cpu_seconds, speed_up_over_scalar: 1 },
].map(({ name, ...figures }) => (
  { ...figures, thesis: true, scene, width: size, height: size, backend: `thesis, 2008, ${name}`, method: `table ${of}` }));

function speed(rows, data) {
  const all = [...rows, ...data.published.timings.flatMap(published_rows)];
  const scenes = [...group_by(rows, "scene")].sort(([, a], [, b]) => b.length - a.length).map(([scene]) => [scene]);
  const work = (row) => (row.thesis ? "published" : row.work || (row.method?.includes("active") ? "active" : row.method));
  const draw = ({ scene }) => {
    const here = all.filter((row) => row.scene === scene)
      .sort((a, b) => a.width - b.width || a.seconds_median - b.seconds_median);
    const curves = group_by(here, (row) => `${row.backend}\n${work(row)}\n${row.threads}`);
    const series = [...curves.values()].map((curve) => series_of({ backend: curve[0].backend, sites: work(curve[0]) }, curve, {
      x: (row) => Math.sqrt(row.width * row.height),
      y: (row) => row.seconds_median,
      faint: (row) => row.valid === false,
      dashed: curve[0].thesis,
      tell: (row) => `${row.method}, ${size_of(row)}: ${seconds(row.seconds_median)}` +
        (row.speed_up_over_scalar ? `, ${times(row.speed_up_over_scalar)} over scalar` : "") + (row.reason ? `; ${row.reason}` : ""),
    }));
    return [
      logPlot(series, {
        label: `seconds over size, ${scene}`,
        x: { title: "pixels a side", format: (value) => count(Math.round(value)) },
        y: { title: "seconds of a whole solution", format: seconds },
      }),
      table(here, SPEED),
    ];
  };
  return [
    chosen_view({ scene: ["Scene", scenes] }, draw),
    text("Medians. Dense visits every site in every sweep; active leaves out what cannot change, with the same bits. " +
      "The thesis's speed-ups are over its own program for a Core 2 Duo; a time that was not verified has no speed-up."),
  ];
}
