"use strict";
// The parts of the page that are folded.

// Accuracy

function accuracy(rows, data) {
  const draw = ({ scene }) => {
    const here = rows.filter((row) => scene_of(row) === scene);
    const differences = here.filter((row) => row.differences?.pictures).map((row) => [
      data.picture(row, row.differences.pictures.magnitude), `distance of ${row.method} from ` +
        `${row.differences.against}: black is 0, light yellow ${number(row.differences.limit)} px`]);
    return [table_of(here, PAGE.tables.accuracy), figures(differences)];
  };
  return [
    text("Finite elements (FEM) are the truth of the model; the fixed point, where every site sits at its own minimum, " +
      "is that of the optimisation. Root mean squares over all sites but void, in pixels."),
    chosen_view({ scene: ["Scene", options(rows, scene_of)] }, draw),
    el("h3", {}, "The thesis, 2008, at 300 × 300"),
    table_of(data.published.accuracy, PAGE.tables.thesis_accuracy),
  ];
}

const continuum = (rows) => [
  text("A sheet with a round inclusion has a displacement in closed form; finite elements on pixels make stairs of " +
    "the circle. An algebraic error below that of discretisation buys nothing."),
  logPlot([...group_by(rows, "contrast")].map(([contrast, curve]) =>
    series_of({ contrast: `contrast ${contrast}` }, curve, {
      x: (row) => row.width,
      y: (row) => row.discretisation?.rmsd,
      tell: (row) => `${size_of(row)}: ${number(row.discretisation?.rmsd)} px, and ` +
        `${number(row.algebraic?.rmsd)} px algebraic`,
    })), { label: "discretisation", x: { title: "pixels a side", format: count }, y: { title: "px of discretisation" } }),
  table_of(rows, PAGE.tables.continuum),
];

// Where the methods fail


function atlas(rows, data) {
  const tell = (point) => `${number(point.knob)}: ${number(point.error)}${point.failed ? ", failed" : ""}` +
    (point.warnings?.length > 0 ? `; warned of ${point.warnings.join(", ")}` : "");
  const draw = ({ family }) => {
    const row = rows[family];
    const series = row.series.map((one) => series_of({ method: one.name }, one.points,
      { x: (point) => point.knob, y: (point) => point.error, faint: (point) => point.failed, tell }));
    const logarithmic = row.series.every((one) => one.points.every((point) => point.knob > 0));
    return [
      logPlot(series, { label: row.title, x: { title: row.knob, logarithmic }, y: { title: row.measure } }),
      text(el("b", {}, "Why. "), row.mechanism),
      text(el("b", {}, "Warned of. "), row.warnings?.join(", ") || "nothing a run knows tells"),
      text(el("b", {}, "What survives. "), row.survivor),
      table_of(row.series, "name last_good first_failed absence"),
      row.picture && figures([[data.picture(row, row.picture.file), row.picture.caption]]),
    ];
  };
  return [
    text("Each family of scenes varies one parameter from harmless to harmful. The warnings are those that run prints."),
    chosen_view({ family: ["Family", rows.map((row, i) => [String(i), row.title])] }, draw),
    table_of(rows, PAGE.tables.atlas),
  ];
}

// Arithmetic of the devices

/// One line a question, one column a backend on a device.
function probe(rows) {
  const device = (row) => `${row.backend}, ${row.device}`;
  const asked = group_by(rows, (row) => `${row.program === "sweep" ? "sweep" : "its own"}\n${row.question}`);
  const lines = [...asked].map(([name, answers]) => {
    const [program, question] = name.split("\n");
    return { program, question, of: new Map(answers.map((row) => [device(row), row])) };
  });
  const words = (row) => {
    const known = { "as specified": row.as_specified, otherwise: row.otherwise }[row.answer] || row.answer;
    return is_number(row.ulp) ? `${known}, ${number(row.ulp)} ulp` : known;
  };
  const tone = (row) => (row.answer === "as specified" ? "good" : row.agreement_needs_it ? "bad" : "fair");
  const answers = distinct(rows, device).map((name) => ({
    key: (line) => line.of.has(name) ? words(line.of.get(name)) : undefined,
    title: name,
    format: (value, line) => el("span", { class: value ? tone(line.of.get(name)) : "soft" }, value ?? "not asked"),
  }));
  return [
    text("Read from the bits of results, on numbers that tell the cases apart: \"sweep\" in the very programs that " +
      "verify compares, \"its own\" in a small program. Yellow is not what IEEE 754 says, red is what agreement needs."),
    table(lines, [...columns("program question"), ...answers]),
  ];
}

// Machine code for GPUs that are not there

/// One line a text, one column a target: its programs, those with fused operations, and the most that one takes.
function machine_code(rows) {
  const lines = [...group_by(rows.filter((row) => row.text), (row) => `${row.text}, ${row.axes} axes`)]
    .map(([text, programs]) => ({ text, of: group_by(programs, "target") }));
  const words = (programs) => {
    const most = (key) => Math.max(...programs.map((row) => row[key] ?? 0));
    const fused = programs.filter((row) => row.verdict !== "no fused operation").length;
    return `${fused ? `${fused} of ` : ""}${plural(programs.length, "program")}${fused ? " not so" : ""}, ` +
      `${count(most("instructions"))} instructions, ${most("registers") || "?"} registers, ${most("local_bytes")} bytes`;
  };
  const targets = distinct(rows, "target").map((name) => ({
    key: (line) => line.of.has(name) ? words(line.of.get(name)) : undefined,
    title: name,
    format: (value, line) => el("span", {
      class: !value ? "soft" : line.of.get(name).every((row) => row.fused === 0) ? "good" : "bad",
    }, value ?? "not there"),
  }));
  return [
    text("What compilers for GPUs make of every program, without the GPU. Green: no multiplication is fused with a sum, so the " +
      "bits are the specification's as far as arithmetic goes. Then the most that one of the programs takes."),
    table(lines, [...columns("text"), ...targets]),
    table_of(rows, PAGE.tables.machine_code),
  ];
}

// Several ranks

function median(values) {
  const sorted = (values ?? []).toSorted((a, b) => a - b), middle = sorted.length >> 1;
  return sorted.length === 0 ? undefined : sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
}

function scaling(all) {
  const rows = all.filter((row) => row.seconds?.length > 0); // files of old have rows that nobody measured
  const runs = group_by(rows, (row) => `${row.energy}, ${size_of(row)}, ${row.scaling}`);
  const y = (row) => median(row.seconds);
  const series = [...runs].map(([run, curve]) => series_of({ run }, curve,
    { x: (row) => row.ranks, y, tell: (row) => `${plural(row.ranks, "rank")}: ${seconds(y(row))}` }));
  return [
    text("One image on several processes, with the bits of one."),
    logPlot(series, {
      label: "ranks",
      x: { title: "ranks", format: count },
      y: { title: "seconds of a whole solution", format: seconds },
    }),
    table_of(rows, "scene size energy backend scaling ranks median_seconds messages bytes"),
  ];
}

// Registration and hidden stiffness

const is_about_stiffness = (row) =>
  row.algorithm === "Algorithm 7" || is_number(row.score) || is_number(row.as_much_by_chance);

/// The tables of a part: [title, which rows, the names of their fields or what draws them].
const tables = (...parts) => (rows, data) => parts.map(([title, belongs, what]) => {
  const some = rows.filter(belongs);
  return some.length > 0 && [title && el("h3", {}, title),
    typeof what === "string" ? table_of(some, what) : what(some, data), named_pictures(some, data)];
});

/// The pictures that a row names: [{caption, file}, ...].
const named_pictures = (rows, data) => rows.filter((row) => row.pictures?.length > 0).map((row) => [
  el("h3", {}, [scene_of(row), row.algorithm].filter(Boolean).join(", ")),
  figures(row.pictures.map(({ file, caption }) => [data.picture(row, file), caption])),
]);

const KNOBS = ["What the parameters do", (row) => row.knob, "algorithm knob value cases region tissue outliers folded " +
  "not_converged area found mistaken distance seconds"];

const registration = tables(
  ["", (row) => row.before && row.after, "scene size algorithm energy backend device seconds before.correlation " +
    "after.correlation before.mutual_information after.mutual_information largest_displacement folds converged looks"],
  ["Against planted truth", (row) => row.planted,
    "scene size planted amplitude noise method tissue tissue_95 region dice folds seconds"],
  KNOBS);

/// Something is hidden where the contrast is not 1; a threshold of the score finds some of it, and raises alarms
/// elsewhere.
function roc_of(name, rows) {
  const hidden = rows.filter((row) => row.contrast !== 1), none = rows.filter((row) => row.contrast === 1);
  const share = (some, holds) => (some.length > 0 ? some.filter(holds).length / some.length : undefined);
  const thresholds = [Infinity, ...rows.map((row) => row.score).sort((a, b) => b - a)];
  const points = thresholds.map((score) => {
    const x = share(none, (row) => row.score >= score), y = share(hidden, (row) => row.score >= score);
    return { x, y, tell: `${percent(y)} found, ${percent(x)} false alarms` };
  });
  const by_chance = (row) => row.score > row.by_chance;
  const area = points.slice(1).reduce((sum, { x, y }, i) => sum + ((x - points[i].x) * (y + points[i].y)) / 2, 0);
  return { keys: { series: name }, points, series: name, cases: rows.length, area, alarms: share(none, by_chance),
    shares_found: share(hidden, by_chance), distance: median(hidden.map((row) => row.distance)) };
}

function roc(rows) {
  const name = (row) => `${row.scene}, ${size_of(row)}, noise ${number(row.noise)}${row.spread ? ", spread" : ""}` +
    (row.pictures === true ? ", from pictures" : "");
  const series = [...group_by(rows, name)].map(([of, some]) => roc_of(of, some));
  const linear = { logarithmic: false, ends: [0, 1] };
  return [
    logPlot(series, { label: "receiver operating characteristic",
      x: { ...linear, title: "found where nothing is hidden" }, y: { ...linear, title: "found where something is" } }),
    table_of(series, "series cases area shares_found alarms distance"),
  ];
}

const detection = tables(
  ["", (row) => is_number(row.as_much_by_chance), "scene size backend device seconds x y position_deviation radius " +
    "contrast largest as_much_by_chance simulations unexplained_before unexplained"],
  ["Does chance find as much?", (row) => is_number(row.score), roc],
  KNOBS);
