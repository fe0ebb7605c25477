"use strict";
// What the page calls the fields of rows, and the four parts that stand open. `data` has published figures and
// picture(row, name).

/// The formats of page.json: text or an element of (value, row).
const FORMATS = {
  seconds, times, percent, verdict, code, ceiling: unit("%"), megabytes: unit("MB", 1e-6), minute: (value) => minute(value),
  size: (value, row) => size_of(row), failing: (value, row) => `${value} of ${row.series.length}`,
  caught: (value, row) => el("span", { class: row.as_expected ? "good" : "bad" }, value),
  unclean: (value) => el("span", { class: value > 0 ? "bad" : "good" }, count(value)),
};
/// Fields that are worked out of a row.
const KEYS = {
  size: (row) => row.width, own_error: (row) => own_error(row), warned: (row) => row.warnings?.length,
  warned_of: (row) => row.warnings?.join(", "), updates: (row) => row.updates?.join(", "),
  first: ({ first_difference: at }) => at && `level ${at.level}, iteration ${at.iteration}, x = ${at.x}, y = ${at.y}`,
  failing: (row) => row.series?.filter((one) => is_number(one.first_failed)).length,
  caught: (row) => (row.not_planted ? "not planted" : row.caught ? "caught" : "let through"),
  seen: (row) => row.scenes?.filter((scene) => scene.verdict === "disagree").map((scene) => scene.scene).join(", "),
  unclean: (row) => row.unclean?.length, hash: (row) => row.levels?.at(-1)?.hash,
  median_seconds: (row) => median(row.seconds), looks: (row) => row.iterations?.length,
  rows: (file) => file.results.length, replaced: (file) => file.replaced || undefined,
  best: (row) => row.best && `${scene_of(row.best)}, ${row.best.method}`,
};
/// The columns of a table by the names of their fields, with spaces between. A new one is a name in its list in page.json,
/// and a line in its fields where a title or a format is wanted.
const columns = (names) => names.split(" ").map((name) => {
  const [title, format] = PAGE.fields[name] ?? [name.replaceAll("_", " ")];
  return { key: KEYS[name] ?? name, title, format: FORMATS[format] };
});
const table_of = (rows, names) => table(rows, columns(names));

const text = (...parts) => el("p", {}, ...parts);
const fold = (title, ...content) => el("details", {}, el("summary", {}, title), ...content);
const scene_of = (row) => [row.scene, size_of(row), row.law].filter(Boolean).join(", ");
const options = (rows, key) => distinct(rows, key).map((value) => [value]);

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
const own_error = (row) => (row.poisson_used ? row.rmsd_to_fem : row.rmsd_to_fem_nu0 ?? row.rmsd_to_fem);
const TRUTHS = [
  ["own", "finite elements, ν as the method has it"],
  ["rmsd_to_fem_nu0", "finite elements, ν = 0"],
  ["rmsd_to_fem", "finite elements, ν of the scene"],
  ["rmsd_to_fixed_point", "the fixed point of the thesis's energy"],
];

/// Six methods that a chart begins with: those that come nearest to the truth, the thesis's own, and its rivals.
const name_of_method = (row) => (row.variant ? `${row.method}, ${row.variant}` : row.method);
const first_methods = (rows) => {
  const ours = [...group_by(rows.filter((row) => !row.rival && is_number(own_error(row))), name_of_method)]
    .map(([method, some]) => [method, Math.min(...some.map(own_error))]).sort(([, a], [, b]) => a - b);
  return distinct([...ours.slice(0, 3).map(([method]) => method), "icm", "fem-cg", "fem-coarse", "newton", "xpbd", ...distinct(rows, name_of_method)]
    .filter((method) => rows.some((row) => name_of_method(row) === method)), (method) => method).slice(0, 6);
};
/// The device of a backend in these rows, without what stands behind a slash or in brackets, for a legend.
const device_of = (rows) => (backend) => {
  const device = rows.find((row) => row.backend === backend && row.device)?.device;
  return device ? `${device.replace(/\((R|TM)\)/g, "").split(/\/| \(/)[0]}:` : backend?.startsWith("thesis") ? "published:" : "";
};

function tradeoff(rows) {
  const points = rows.filter((row) => row.kind !== "equal accuracy");
  const equal = rows.filter((row) => row.kind === "equal accuracy");
  const scenes = options(points, scene_of).sort(([a], [b]) => b.startsWith("brain") - a.startsWith("brain"));
  const rank = (row) => (row.rival ? 1 : row.poisson_used === undefined ? 2 : 0); // what is nearest to the truth first
  const draw = ({ scene, truth }) => {
    const here = points.filter((row) => scene_of(row) === scene).sort((a, b) => rank(a) - rank(b));
    const curves = group_by(here, (row) => `${name_of_method(row)}\n${row.backend}\n${row.poisson_used}`);
    const series = [...curves.values()].map((curve) => series_of({ method: name_of_method(curve[0]), backend: curve[0].backend }, curve, {
      x: (row) => row.seconds_median,
      y: (row) => (truth === "own" ? own_error(row) : row[truth]),
      faint: (row) => row.valid === false || row.status !== "ok",
      tell: (row) => `${row.effort}${row.device ? `, ${row.device}` : ""}: ${seconds(row.seconds_median)}, ` +
        `${number(own_error(row))} px from finite elements. ${row.reason || row.command || ""}`,
    }));
    const direct = here.filter((row) => ["fem", "newton"].includes(row.method)).sort((a, b) => a.seconds_median - b.seconds_median)[0];
    return [
      logPlot(series, {
        label: `speed against accuracy, ${scene}`, front: true, height: 440,
        marks: direct ? [{ x: direct.seconds_median, text: `direct finite elements, ${seconds(direct.seconds_median)}` }] : [],
        first: { method: first_methods(here) }, groups: { backend: device_of(here) },
        x: { title: "seconds of a whole solution", format: seconds },
        y: { title: "px to the truth, RMS over all sites but void" },
      }),
      fold(`All ${plural(here.length, "point")} of ${scene}`, table_of(here, PAGE.tables.points)),
    ];
  };
  return [
    chosen_view({ scene: ["Scene", scenes], truth: ["Distance to", TRUTHS] }, draw),
    text("Lower left is better. The line is the front: nothing measured is both faster and nearer. " +
      "A pale dot is a result that is not scalar's to the bit, or that failed."),
    equal.length > 0 && fold("How many times faster than finite elements, at equal accuracy", table_of(equal, PAGE.tables.equal)),
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

/// Slices of a volume across each axis, with a slider each, before or after its deformation. `uri` is one picture of all
/// slices across z, those of before first, row by row; `row.slices` has their sides, and where one is shown first.
function volume_viewer(uri, row) {
  const sides_of = (one) => [one.width, one.height, one.depth];
  const sides = sides_of(row.slices);
  let pixels, is_after = true;
  const gray = ([x, y, z]) => {
    const tile = z + (is_after ? sides[2] : 0), columns = pixels.width / sides[0];
    const line = Math.floor(tile / columns) * sides[1] + y;
    return pixels.data[4 * (line * pixels.width + (tile % columns) * sides[0] + x)];
  };
  const views = [2, 1, 0].map((axis) => {
    const [across, down] = [0, 1, 2].filter((other) => other !== axis);
    const name = `slice across ${"xyz"[axis]}`;
    const canvas = el("canvas", { width: sides[across], height: sides[down], role: "img", "aria-label": name });
    const caption = el("figcaption");
    const draw = () => {
      const slice = new ImageData(sides[across], sides[down]);
      for (let i = 0; i < sides[across] * sides[down]; ++i) {
        const site = [];
        site[axis] = Number(slider.value);
        site[across] = i % sides[across];
        const line = Math.floor(i / sides[across]);
        site[down] = down === 2 ? sides[2] - 1 - line : line; // z leads up, as heads stand
        const value = gray(site);
        slice.data.set([value, value, value, 255], 4 * i);
      }
      canvas.getContext("2d").putImageData(slice, 0, 0);
      caption.textContent = `${name}: ${Number(slider.value) + 1} of ${sides[axis]}`;
    };
    const first = Math.round((row.slices.at[axis] * (sides[axis] - 1)) / (sides_of(row)[axis] - 1));
    const slider = el("input", { type: "range", min: 0, max: sides[axis] - 1, value: first, "aria-label": name, oninput: draw });
    return { draw, figure: el("figure", { class: "slider" }, canvas, slider, caption) };
  });
  const draw_all = () => pixels && views.forEach((view) => view.draw());
  const image = el("img", { src: uri, onload: () => {
    const context = el("canvas", { width: image.width, height: image.height }).getContext("2d");
    context.drawImage(image, 0, 0);
    pixels = context.getImageData(0, 0, image.width, image.height);
    draw_all();
  } });
  return el("div", {},
    el("p", { class: "choices" }, choice("Deformation", [["after"], ["before"]], (moment) => { is_after = moment === "after"; draw_all(); })),
    el("div", { class: "pictures" }, views.map((view) => view.figure)));
}

function pictures(rows, data) {
  const sites = (row) => row.width * row.height * (row.depth ?? 1);
  const shown = rows.filter((row) => data.picture(row, row.pictures?.after)).sort((a, b) => sites(b) - sites(a));
  const warnings = rows.flatMap((row) => (row.warnings ?? []).map((warning) => ({ scene: row.scene, ...warning })));
  const draw = ({ run }) => {
    const row = shown[run];
    const of = (name) => data.picture(row, row.pictures[name]);
    const grid = row.depth > 1 ? "the grid of each slice, deformed in its plane" : "the grid, deformed";
    const others = figures([[of("grid"), grid], [of("magnitude"), "how far each site moved; black is 0"]]);
    const first = of("before") ? before_and_after(of("before"), of("after"), row.scene) : figures([[of("after"), "after"]]);
    const all = (...parts) => el("div", { class: row.depth > 1 ? "pictures strips" : "pictures" }, parts, ...(others ? others.children : []));
    return row.slices && of("slices") ? [volume_viewer(of("slices"), row), all()] : all(first);
  };
  return [
    shown.length > 0 && chosen_view({ run: ["Scene", shown.map((row, i) => [String(i), row.title || scene_of(row)])] }, draw),
    table_of(rows, PAGE.tables.run),
    warnings.length > 0 &&
      fold(`${plural(warnings.length, "warning")} of these runs`, table_of(warnings, "scene kind sites message advice")),
  ];
}

// Agreement

const TIERS = ["none", "certified", "bitwise", "exact"];
const TIER_WORDS = {
  exact: "exact: same bits where nothing is ever rounded", bitwise: "bitwise: same bits",
  certified: "certified: each difference within a derived bound", mistrusted: "mistrusted: could not have shown a difference",
  disagree: "disagrees", skipped: "skipped",
};

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
const repeat_lines = (rows) => distinct(rows, (row) => row.repeat ??
  `hdmbench verify ${row.scene} --size ${row.width}x${row.height} --methods ${row.method} --backends ${row.backend}`);

function agreement(rows) {
  const backends = distinct(rows, "backend"), scenes = distinct(rows, "scene");
  const below = el("div", { class: "picked" }, text("A cell has the number of comparisons; click on one to see them."));
  const pick = (mine) => below.replaceChildren(
    el("h3", {}, `${mine[0].backend} on ${mine[0].scene}`),
    el("pre", {}, repeat_lines(mine).join("\n")),
    table_of(mine, PAGE.tables.verify));
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
    el("p", { class: "key" }, Object.entries(TIER_WORDS).map(([tone, words]) =>
      [el("span", { class: `tier ${tone}` }, "\u00a0\u00a0\u00a0"), ` ${words} `])),
    below,
    fold(`All ${plural(rows.length, "comparison")}`, table_of(rows, PAGE.tables.verify)),
  ];
}

// Speed over sizes

const published_rows = ({ table: of, scene, size, gpu_seconds, cpu_seconds, speed_up }) => [
  { name: "GPU", seconds_median: gpu_seconds, speed_up_over_scalar: speed_up },
  { name: "CPU", seconds_median: cpu_seconds, speed_up_over_scalar: 1 },
].map(({ name, ...figures }) => (
  { ...figures, thesis: true, scene, width: size, height: size, backend: `thesis, 2008, ${name}`, method: `table ${of}` }));

function speed(rows, data) {
  const all = [...rows, ...data.published.timings.flatMap(published_rows)];
  // Each energy has its own chart, and the thesis's timings belong to its own.
  const chart_of = (row) => row.scene + (row.energy === "elastic" ? ", elastic" : "");
  const scenes = [...group_by(rows, chart_of)].sort(([, a], [, b]) => b.length - a.length).map(([scene]) => [scene]);
  const work = (row) => (row.thesis ? "published" : row.work || (row.method?.includes("active") ? "active" : row.method));
  const draw = ({ scene }) => {
    const of_scene = all.filter((row) => chart_of(row) === scene);
    const was_timed = (row) => row.seconds_median > 0;
    const missing = distinct(of_scene.filter((row) => !was_timed(row))
      .map((row) => ({ words: row.backend + (row.reason ? ` (${row.reason})` : "") })), "words");
    const here = of_scene.filter(was_timed)
      .sort((a, b) => a.width - b.width || a.seconds_median - b.seconds_median);
    const curves = group_by(here, (row) => `${row.backend}\n${work(row)}\n${row.threads}`);
    const series = [...curves.values()].map((curve) => series_of({ backend: curve[0].backend, sites: work(curve[0]) }, curve, {
      x: (row) => (row.depth > 1 ? Math.cbrt(row.width * row.height * row.depth) : Math.sqrt(row.width * row.height)),
      y: (row) => row.seconds_median,
      faint: (row) => row.valid === false,
      dashed: curve[0].thesis,
      tell: (row) => `${row.method}, ${size_of(row)}: ${seconds(row.seconds_median)}` +
        (row.speed_up_over_scalar ? `, ${times(row.speed_up_over_scalar)} over dense scalar` : "") + (row.reason ? `; ${row.reason}` : ""),
    }));
    return [
      logPlot(series, {
        label: `seconds over size, ${scene}`, groups: { backend: device_of(here) },
        x: { title: "sites a side", measured: true, format: (value) => count(Math.round(value)) },
        y: { title: "seconds of a whole solution", format: seconds },
      }),
      table_of(here, PAGE.tables.speed),
      ...(missing.length > 0 ? [text(`Not timed: ${missing.join(", ")}.`)] : []),
    ];
  };
  return [
    chosen_view({ scene: ["Scene", scenes] }, draw),
    text("Medians. Dense visits every site in every sweep; active leaves out what cannot change, with the same bits. " +
      "The thesis's speed-ups are over its own program for a Core 2 Duo; a time that was not verified has no speed-up."),
  ];
}
