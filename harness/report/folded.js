"use strict";
// The parts of the page that are folded.

// Accuracy

const ACCURACY = [
  ...SCENE,
  { key: "method", title: "method" },
  { key: "variant", title: "variant" },
  { key: "backend", title: "backend" },
  { key: "poisson_used", title: "ν" },
  ...RMSD,
  { key: "rmsd_interface_to_fem", title: "px at interfaces" },
  { key: "mean_energy", title: "mean energy" },
  { key: "iterations", title: "iterations", format: count },
  SECONDS,
  { key: "arithmetic.resynchronised.steps_differing", title: "steps unlike double's", format: count },
  { key: "arithmetic.resynchronised.beyond_bound", title: "beyond the bound", format: count },
  { key: "status", title: "status", format: verdict },
  { key: "reason", title: "reason" },
  { key: "note", title: "note" },
];
const THESIS_ACCURACY = [
  { key: "table", title: "table" },
  { key: "scene", title: "scene" },
  { key: "method", title: "thesis's" },
  { key: "rmsd", title: "px to FEM" },
  { key: "mean_energy", title: "mean energy" },
  { key: "iterations", title: "iterations", format: count },
  { key: "seconds", title: "seconds", format: seconds },
];
const CONVERGED_TO = [["rmsd_to_fem", "finite elements"], ["rmsd_to_fixed_point", "fixed point"]];

function convergence(rows) {
  const series = rows.flatMap((row) => CONVERGED_TO.map(([key, truth]) => {
    const steps = row.convergence.iterations_per_level.map((iterations, i) => ({ iterations, px: row.convergence[key]?.[i] }));
    return series_of({ scene: row.scene, "distance to": truth }, steps, {
      x: (step) => step.iterations,
      y: (step) => step.px,
      tell: (step) => `${step.iterations} iterations a level: ${number(step.px)} px`,
    });
  }));
  return [el("h3", {}, "What more iterations bring"),
    logPlot(series, { label: "convergence", x: { title: "iterations a level" }, y: { title: "px" } })];
}

function accuracy(rows, data) {
  const curves = rows.filter((row) => row.convergence?.iterations_per_level?.length > 1);
  const draw = ({ scene }) => {
    const here = rows.filter((row) => scene_of(row) === scene);
    const differences = here.filter((row) => row.differences?.pictures).map((row) => [
      data.picture(row, row.differences.pictures.magnitude),
      `distance of ${row.method} from ${row.differences.against}: black is 0, light yellow ${number(row.differences.limit)} px`]);
    return [table(here, ACCURACY), figures(differences)];
  };
  return [
    text("Finite elements (FEM) are the truth of the model; the fixed point, where every site sits at its own minimum, is that " +
      "of the optimisation; double is that of the arithmetic. Root mean squares over all sites, in pixels."),
    chosen_view({ scene: ["Scene", options(rows, scene_of)] }, draw),
    curves.length > 0 && convergence(curves),
    el("h3", {}, "The thesis, 2008, at 300 × 300"),
    table(data.published.accuracy, THESIS_ACCURACY),
  ];
}

const CONTINUUM = [
  { key: "contrast", title: "contrast" },
  ...SCENE.slice(1),
  { key: "discretisation.rmsd", title: "discretisation, px" },
  { key: "order", title: "order" },
  { key: "algebraic.rmsd", title: "algebraic, px" },
  { key: "rounding.rmsd", title: "float32, px" },
  { key: "total.rmsd", title: "in all, px" },
  { key: "total.largest", title: "largest, px" },
  { key: "backend", title: "backend" },
  { key: "method", title: "method" },
];
const continuum = (rows) => [
  text("A sheet with a round inclusion has a displacement in closed form; finite elements on pixels make stairs of the " +
    "circle. An algebraic error below that of discretisation buys nothing."),
  logPlot([...group_by(rows, "contrast")].map(([contrast, curve]) => series_of({ contrast: `contrast ${contrast}` }, curve, {
    x: (row) => row.width,
    y: (row) => row.discretisation?.rmsd,
    tell: (row) => `${size_of(row)}: ${number(row.discretisation?.rmsd)} px, and ${number(row.algebraic?.rmsd)} px algebraic`,
  })), { label: "discretisation", x: { title: "pixels a side", format: count }, y: { title: "px of discretisation" } }),
  table(rows, CONTINUUM),
];

// Where the methods fail

const failing = (row) => row.series?.filter((one) => is_number(one.first_failed)).length;
const ATLAS = [
  { key: "title", title: "what is varied" },
  { key: "energy", title: "energy" },
  { key: "knob", title: "parameter" },
  { key: "measure", title: "measure" },
  { key: failing, title: "methods that fail", format: (value, row) => `${value} of ${row.series.length}` },
  { key: (row) => row.warnings?.join(", "), title: "warned of" },
];
const ATLAS_SERIES = [
  { key: "name", title: "method" },
  { key: "last_good", title: "last that is good" },
  { key: "first_failed", title: "first that fails" },
  { key: "absence", title: "no result" },
];

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
      table(row.series, ATLAS_SERIES),
      row.picture && figures([[data.picture(row, row.picture.file), row.picture.caption]]),
    ];
  };
  return [
    text("Each family of scenes varies one parameter from harmless to harmful. The warnings are those that run prints."),
    chosen_view({ family: ["Family", rows.map((row, i) => [String(i), row.title])] }, draw),
    table(rows, ATLAS),
  ];
}

// Devices and their arithmetic

const DEVICES = [
  { key: "backend", title: "backend" },
  { key: "available", title: "there" },
  { key: "device", title: "device" },
  { key: "driver", title: "driver" },
  { key: "software", title: "the CPU in disguise" },
  { key: (row) => row.updates?.join(", "), title: "updates" },
  { key: "reason", title: "reason" },
  { key: "description", title: "what it is" },
];
const IMPLEMENTATIONS = [
  { key: "implementation", title: "driver" },
  ...BACKEND,
  { key: "outcome", title: "outcome", format: verdict },
  { key: "tier", title: "tier" },
  { key: "comparisons", title: "comparisons", format: count },
  { key: "sites_compared", title: "sites compared", format: count },
  { key: "sites_differing", title: "differ", format: count },
  { key: "seconds", title: "seconds", format: seconds },
  { key: "reason", title: "reason" },
  { key: "repeat", title: "the line that repeats it", format: code },
];

/// One line a question, one column a backend on a device.
function probe(rows) {
  const device = (row) => `${row.backend}, ${row.device}`;
  const asked = [...group_by(rows, (row) => `${row.program === "sweep" ? "sweep" : "its own"}\n${row.question}`)];
  const lines = asked.map(([name, answers]) => {
    const [program, question] = name.split("\n");
    return { program, question, of: new Map(answers.map((row) => [device(row), row])) };
  });
  const words = (row) => {
    const known = { "as specified": row.as_specified, otherwise: row.otherwise }[row.answer] || row.answer;
    return is_number(row.ulp) ? `${known}, ${number(row.ulp)} ulp` : known;
  };
  const tone = (row) => (row.answer === "as specified" ? "good" : row.agreement_needs_it ? "bad" : "fair");
  const columns = distinct(rows, device).map((name) => ({
    key: (line) => line.of.has(name) ? words(line.of.get(name)) : undefined,
    title: name,
    format: (value, line) => el("span", { class: value ? tone(line.of.get(name)) : "soft" }, value ?? "not asked"),
  }));
  return [
    text("Read from the bits of results, on numbers that tell the cases apart: \"sweep\" in the very programs that verify " +
      "compares, \"its own\" in a small program. Yellow is not what IEEE 754 says, red is what agreement needs."),
    table(lines, [{ key: "program", title: "program" }, { key: "question", title: "question" }, ...columns]),
  ];
}

// What the checks are worth

const seen_on = (row) => row.scenes?.filter((scene) => scene.verdict === "disagree").map((scene) => scene.scene).join(", ");
const FAULTS = [
  { key: "fault", title: "fault" },
  { key: "what", title: "what was planted" },
  { key: "backend", title: "backend" },
  { key: "layer", title: "layer" },
  { key: "expected", title: "expected" },
  { key: (row) => (row.not_planted ? "not planted" : row.caught ? "caught" : "let through"), title: "outcome",
    format: (value, row) => el("span", { class: row.as_expected ? "good" : "bad" }, value) },
  { key: seen_on, title: "seen on" },
  { key: "not_planted", title: "not planted because" },
];
const FAILING = [
  { key: "api", title: "interface" },
  { key: "backend", title: "backend" },
  { key: "kind", title: "error" },
  { key: "calls", title: "calls", format: count },
  { key: "failed", title: "made to fail", format: count },
  { key: "clean", title: "ended with a message", format: count },
  { key: "went_on", title: "went on, same bits", format: count },
  { key: "succeeded", title: "no need of it", format: count },
  { key: (row) => row.unclean?.length, title: "unclean",
    format: (value) => el("span", { class: value > 0 ? "bad" : "good" }, count(value)) },
];
const GOLDEN = [
  ...SCENE,
  { key: "method", title: "method" },
  ...BACKEND,
  { key: "verdict", title: "verdict", format: verdict },
  { key: (row) => row.levels?.at(-1)?.hash, title: "hash of the full image", format: code },
  { key: "reason", title: "reason" },
  { key: "inputs_reason", title: "inputs" },
];
const INSTRUCTIONS = [
  { key: "group", title: "group" },
  { key: "shader", title: "shader" },
  { key: "candidates", title: "candidates" },
  { key: "energies", title: "vectors" },
  { key: "instructions", title: "instructions" },
  { key: "instructions_limit", title: "of at most" },
  { key: "texture_instructions", title: "texture" },
  { key: "temporaries", title: "temporaries" },
  { key: "scalar_operations", title: "scalar operations" },
  { key: "refusal", title: "does not fit because" },
  { key: "device", title: "device" },
];

// Several ranks

function median(values) {
  const sorted = (values ?? []).toSorted((a, b) => a - b), middle = sorted.length >> 1;
  return sorted.length === 0 ? undefined : sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
}
const SCALING = [
  ...SCENE,
  { key: "energy", title: "energy" },
  { key: "backend", title: "backend" },
  { key: "scaling", title: "scaling" },
  { key: "ranks", title: "ranks", format: count },
  { key: (row) => median(row.seconds), title: "seconds, median", format: seconds },
  { key: "messages", title: "messages", format: count },
  { key: "bytes", title: "sent", format: unit("MB", 1e-6) },
];

function scaling(all) {
  const rows = all.filter((row) => row.seconds?.length > 0); // files of old have rows that nobody measured
  const y = (row) => median(row.seconds);
  const series = [...group_by(rows, (row) => `${row.energy}, ${size_of(row)}, ${row.scaling}`)].map(([run, curve]) =>
    series_of({ run }, curve, { x: (row) => row.ranks, y, tell: (row) => `${plural(row.ranks, "rank")}: ${seconds(y(row))}` }));
  return [
    text("One image on several processes, with the bits of one."),
    logPlot(series, {
      label: "ranks",
      x: { title: "ranks", format: count },
      y: { title: "seconds of a whole solution", format: seconds },
    }),
    table(rows, SCALING),
  ];
}

// Registration and hidden stiffness

const REGISTER = [
  ...SCENE,
  { key: "algorithm", title: "algorithm" },
  { key: "energy", title: "energy" },
  ...BACKEND,
  { key: "seconds", title: "seconds", format: seconds },
  { key: "before.correlation", title: "correlation before" },
  { key: "after.correlation", title: "after" },
  { key: "before.mutual_information", title: "mutual information before" },
  { key: "after.mutual_information", title: "after" },
  { key: "largest_displacement", title: "largest displacement, px" },
  { key: "folds", title: "folded cells", format: count },
  { key: "converged", title: "converged" },
  { key: (row) => row.iterations?.length, title: "iterations" },
];
const RIVALS = [
  ...SCENE,
  { key: "planted", title: "planted" },
  { key: "amplitude", title: "px planted" },
  { key: "noise", title: "noise", format: percent },
  { key: "method", title: "method" },
  { key: "tissue", title: "px in tissue" },
  { key: "tissue_95", title: "95 %" },
  { key: "region", title: "in the region" },
  { key: "dice", title: "Dice" },
  { key: "folds", title: "folds", format: count },
  { key: "seconds", title: "seconds", format: seconds },
];
const PEOPLE = [
  ...SCENE,
  { key: "other", title: "other" },
  { key: "method", title: "method" },
  { key: "dice", title: "Dice" },
  { key: "correlation", title: "correlation" },
  { key: "folds", title: "folds", format: count },
  { key: "seconds", title: "seconds", format: seconds },
];
const KNOBS = [
  { key: "algorithm", title: "algorithm" },
  { key: "knob", title: "parameter" },
  { key: "value", title: "value" },
  { key: "cases", title: "cases" },
  { key: "region", title: "px in the region" },
  { key: "tissue", title: "px in tissue" },
  { key: "outliers", title: "outliers", format: percent },
  { key: "folded", title: "folded" },
  { key: "not_converged", title: "not converged" },
  { key: "area", title: "area under ROC" },
  { key: "found", title: "found" },
  { key: "mistaken", title: "mistaken" },
  { key: "distance", title: "px off" },
  { key: "seconds", title: "seconds", format: seconds },
];
const DETECT = [
  ...SCENE,
  ...BACKEND,
  { key: "seconds", title: "seconds", format: seconds },
  { key: "x", title: "x" },
  { key: "y", title: "y" },
  { key: "position_deviation", title: "±" },
  { key: "radius", title: "radius, px" },
  { key: "contrast", title: "times the label's modulus" },
  { key: "largest", title: "standard deviations" },
  { key: "as_much_by_chance", title: "as much by chance" },
  { key: "simulations", title: "of so many simulations" },
  { key: "unexplained_before", title: "px unexplained before" },
  { key: "unexplained", title: "after" },
  { key: "looks_like", title: "looks like label" },
];
const ROC = [
  { key: "name", title: "series" },
  { key: "cases", title: "cases" },
  { key: "area", title: "area under the curve" },
  { key: "found", title: "found, more than by chance", format: percent },
  { key: "alarms", title: "false alarms", format: percent },
  { key: "distance", title: "px off, median" },
];
const is_about_stiffness = (row) => row.algorithm === "Algorithm 7" || is_number(row.score) || is_number(row.as_much_by_chance);
const titled = (title, rows, draw) => rows.length > 0 && [title && el("h3", {}, title), draw(rows)];

/// The pictures that a row names: [{caption, file}, ...].
const named_pictures = (rows, data) => rows.filter((row) => row.pictures?.length > 0).map((row) => [
  el("h3", {}, [scene_of(row), row.algorithm].filter(Boolean).join(", ")),
  figures(row.pictures.map(({ file, caption }) => [data.picture(row, file), caption])),
]);

const registration = (rows, data) => [
  titled("", rows.filter((row) => row.before && row.after), (some) => [table(some, REGISTER), named_pictures(some, data)]),
  titled("Against planted truth", rows.filter((row) => row.planted), (some) => table(some, RIVALS)),
  titled("Between two people", rows.filter((row) => row.overlaps), (some) => table(some, PEOPLE)),
  titled("What the parameters do", rows.filter((row) => row.knob), (some) => table(some, KNOBS)),
];

/// Something is hidden where the contrast is not 1; a threshold of the score finds some of it, and raises alarms elsewhere.
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
  return { keys: { series: name }, points, name, cases: rows.length, area, found: share(hidden, by_chance),
    alarms: share(none, by_chance), distance: median(hidden.map((row) => row.distance)) };
}

function roc(rows) {
  const name = (row) => `${row.scene}, ${size_of(row)}, noise ${number(row.noise)}${row.spread ? ", spread" : ""}` +
    (row.pictures === true ? ", from pictures" : "");
  const series = [...group_by(rows, name)].map(([of, some]) => roc_of(of, some));
  const linear = { logarithmic: false, ends: [0, 1] };
  return [
    logPlot(series, { label: "receiver operating characteristic",
      x: { ...linear, title: "found where nothing is hidden" }, y: { ...linear, title: "found where something is" } }),
    table(series, ROC),
  ];
}

const detection = (rows, data) => [
  titled("", rows.filter((row) => is_number(row.as_much_by_chance)), (some) => [table(some, DETECT), named_pictures(some, data)]),
  titled("Does chance find as much?", rows.filter((row) => is_number(row.score)), roc),
  titled("What the parameters do", rows.filter((row) => row.knob), (some) => table(some, KNOBS)),
];
