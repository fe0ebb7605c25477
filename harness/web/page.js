// Runs everything once and shows it as it comes. For tests, after # in the address: plant=NAME plants a fault in the
// shaders, missing=NAME does without webgl2, an extension or webgpu.

const asked = new URLSearchParams(location.hash.slice(1));
const element = (id) => document.getElementById(id);

/** The document's other threads of work go on. */
const pause = () => new Promise((resolve) => setTimeout(resolve, 0));

function conclude(state, sentence) {
  element("verdict").className = "verdict " + state;
  element("sentence").textContent = sentence;
}

/** All rows so far, and what differs in them. */
function show_rows(rows) {
  element("rows").replaceChildren(table(rows, [
    { key: (row) => row.scene + (row.method === "icm" ? "" : ", " + row.method), title: "Scene" },
    { key: size_of, title: "Size" }, { key: "backend", title: "Backend" }, { key: "mode", title: "Mode" }, { key: "sweeps", title: "Sweeps, steps", format: count },
    { key: "sites_compared", title: "Sites compared", format: count },
    { key: "sites_differing", title: "Differing", format: count },
    { key: (row) => (row.verdict === "agree" ? row.tier : row.verdict), title: "Verdict", format: verdict }]));
  element("differences").replaceChildren(...rows.filter((row) => row.first_difference || row.counts_differing || row.reason).map((row) => {
    const first = row.first_difference;
    return el("p", {}, row.scene + ", " + row.backend + ", " + row.mode + ": " + (row.reason || "") +
      (row.counts_differing ? " " + count(row.counts_differing) + " sums or cells that kept least differ;" : "") +
      (first ? " first difference on level " + first.level + (first.step ? ", step " + first.iteration + ", " + first.step :
        ", iteration " + first.iteration) + ", x = " + first.x + ", y = " + first.y +
        (row.depth > 1 ? ", z = " + first.z : "") + ": CPU (" + first.expected.join(", ") + "), GPU (" + first.found.join(", ") + ") px" : ""));
  }));
}

function show_arithmetic(rows) {
  const words = (row) => ({ "as specified": row.as_specified, otherwise: row.otherwise, neither: "neither of the two",
    untold: "cannot tell" }[row.answer] || row.otherwise + " in " + row.other + " of " + row.telling);
  element("arithmetic").replaceChildren(table(rows, [
    { key: "program", title: "Program" }, { key: "question", title: "Asked" }, { key: words, title: "Answer" },
    { key: "telling", title: "Telling cases", format: count }]));
}

function draw(title, width, height, shade) {
  const canvas = el("canvas", { class: "picture", width, height });
  const pixels = new ImageData(width, height);
  for (let i = 0; i < width * height; ++i) {
    pixels.data.set(shade(i), 4 * i);
  }
  canvas.getContext("2d").putImageData(pixels, 0, 0);
  element("pictures").append(el("figure", {}, canvas, el("figcaption", {}, title)));
}

function show_fields(row) {
  const { scalar: [x, y], gpu } = row.fields;
  const cpu_size = (i) => Math.hypot(x[i], y[i]);
  const gpu_size = (i) => Math.hypot(gpu[4 * i], gpu[4 * i + 1]);
  let largest = 0;
  x.forEach((_, i) => { largest = Math.max(largest, cpu_size(i)); });
  const heat = (size) => [255 * Math.min(1, 1.6 * size), 255 * size * size, 255 * (0.25 + 0.5 * size * (1 - size)), 255];
  element("pictures").replaceChildren();
  draw("CPU, to " + largest.toFixed(1) + " px", row.width, row.height, (i) => heat(cpu_size(i) / largest));
  draw("GPU", row.width, row.height, (i) => heat(gpu_size(i) / largest));
  draw("differing sites", row.width, row.height, (i) =>
    (x[i] === gpu[4 * i] && y[i] === gpu[4 * i + 1] ? [30, 90, 60, 255] : [230, 60, 40, 255]));
}

/** What `hdmbench report` reads. */
function keep(rows, gpus, arithmetic) {
  const agent = navigator.userAgent.replace(/^Mozilla\/5.0 /, "");
  const results = {
    schema: 1, command: "verify",
    context: {
      ...page_data.context, machine: "browser: " + (gpus.length > 0 ? gpus[0].device : agent), cpu: "unknown to a page",
      cores: navigator.hardwareConcurrency || 0, operating_system: agent, date: new Date().toISOString().slice(0, 19) + "Z"
    },
    results: rows.map(({ fields, exact, ...row }) => row), arithmetic
  };
  const text = JSON.stringify(results);
  element("results").textContent = text;
  element("save").disabled = rows.length === 0;
  element("save").onclick = () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
    link.download = "hdmbench-browser.json";
    link.click();
  };
}

/** "All of N comparisons …" */
function judge(rows) {
  const of = (verdict) => rows.filter((row) => row.verdict === verdict).length;
  const sites = count(rows.reduce((sum, row) => sum + row.sites_compared, 0));
  if (rows.length === 0) {
    conclude("unsure", "Nothing was compared: these scenes need what this browser lacks.");
  } else if (of("mistrusted") > 0) {
    conclude("unsure", "Nothing can be said: the CPU's own results are not what they should be.");
  } else if (of("disagree") > 0) {
    const exact = rows.filter((row) => row.exact);
    conclude("bad", of("disagree") + " of " + rows.length + " comparisons differ" + (exact.length === 0 ? "." :
      exact.some((row) => row.verdict === "disagree") ? ", on an exact scene too: this GPU or its driver computes something else." :
        "; the exact scenes agree: this GPU rounds otherwise."));
  } else {
    conclude("good", "The same bits: " + of("agree") + " of " + rows.length + " comparisons, " + sites + " sites.");
  }
}

/** The ways to this browser's GPU; what is not there is said. `codes` are WGSL. */
async function open_gpus(codes, missing) {
  const gpus = [];
  const lacks = [];
  for (const open of [() => new FragmentGpu(element("gpu"), missing), () => ComputeGpu.open(codes, missing)]) {
    try {
      gpus.push(await open());
    } catch (error) {
      lacks.push(error.message);
    }
  }
  if (gpus.length === 0) { throw new Error(lacks.join("; ")); }
  element("device").textContent = gpus.map((gpu) => gpu.backend + ": " + gpu.device + ", " + gpu.driver).join("; ");
  element("lacks").textContent = lacks.map((lack) => "Not compared: " + lack + ".").join(" ");
  return gpus;
}

/** What is replaced in all shaders, and by what, by its name. */
const plants = {
  tie: ["best = change < lowest ?", "best = change <= lowest ?"], // the last candidate among equals
  sign: ["displacement + straight * residual;", "displacement - straight * residual;"],
  stress: ["by_cofactor = one - mu;", "by_cofactor = one + mu;"],
  order: ["(a * b + c * d) + e;", "(a * b + e) + c * d;"],
  constant: ["return value * real_told(31);", "return value;"], // is one that a compiler sees
  word: ["for (int i = 1;", "loop (int i = 1;"] // is not C
};

function plant(name) {
  page_data.probe = page_data.probe.replace(...plants[name]);
  const planted = (text) => text.replace(...plants[name]);
  page_data.scenes.filter((scene) => scene.shader).forEach((scene) => { scene.shader = planted(scene.shader); });
  page_data.compute.forEach((program) => {
    program.texts = planted(program.texts);
    program.wgsl = planted(program.wgsl);
  });
}

async function run() {
  const rows = [];
  const arithmetic = [];
  let gpus = [];
  try {
    if (asked.has("plant")) { plant(asked.get("plant")); }
    const codes = Object.fromEntries(page_data.compute.map(({ name, texts, wgsl }) =>
      [name, new Wgsl(texts).translation() + wgsl]));
    gpus = await open_gpus(codes, asked.getAll("missing"));
    for (const gpu of gpus) { arithmetic.push(...await ask(gpu, page_data.arithmetic)); }
    show_arithmetic(arithmetic);
    const module = await WebAssembly.compile(bytes_of(page_data.scalar));
    const scalar = new Scalar(await WebAssembly.instantiate(module, {}));
    const without = page_data.scenes.filter((scene) => !scene.levels && !gpus.some((gpu) => gpu.module_of));
    if (without.length > 0) {
      element("lacks").textContent += " The elastic energy needs WebGPU: " + count(without.length) + " of " +
        count(page_data.scenes.length) + " scenes are not compared.";
    }
    const parts = (scene) => (scene.levels ? scene.levels.length : 4);
    const total = 2 * gpus.length * page_data.scenes.reduce((sum, scene) => sum + parts(scene), 0);
    for (const scene of page_data.scenes) {
      (scene.levels || []).forEach((level) => { level.arrays = floats(level.arrays); });
      // The elastic energy has no fragment shader for browsers.
      const able = gpus.filter((gpu) => scene.levels || gpu.module_of);
      for (const [gpu, mode] of able.flatMap((gpu) => [[gpu, "resync"], [gpu, "free"]])) {
        const go_on = async () => {
          element("progress").value += (scene.levels ? 1 : parts(scene)) / total;
          await pause();
        };
        rows.push(scene.levels ? await follow(scalar, gpu, scene, mode, go_on) : await follow_elastic(gpu, scene, mode, go_on));
        rows[rows.length - 1].exact = scene.exact;
        show_rows(rows);
      }
      if (rows.length > 0 && rows[rows.length - 1].fields) { show_fields(rows[rows.length - 1]); }
    }
    judge(rows);
  } catch (error) {
    conclude("unsure", "Nothing can be compared: " + error.message);
  }
  element("progress").value = 1;
  keep(rows, gpus, arithmetic);
  document.documentElement.dataset.done = "yes";
}

run();
