"use strict";
// Reads the results that the page carries and shows them, a machine at a time.

/// Lists of objects travel as {keys, rows}, so that a key is written once.
function unpacked(value) {
  if (Array.isArray(value)) return value.map(unpacked);
  if (value === null || typeof value !== "object") return value;
  const without_null = (entries) => Object.fromEntries(entries.filter(([, item]) => item !== null));
  if (Array.isArray(value.keys) && Array.isArray(value.rows) && Object.keys(value).length === 2)
    return value.rows.map((row) => without_null(row.map((item, i) => [value.keys[i], unpacked(item)])));
  return without_null(Object.entries(value).map(([key, item]) => [key, unpacked(item)]));
}

/// Whatever has no part of its own: every plain value of its rows.
function plain(rows) {
  const keys = [...new Set(rows.flatMap((row) => Object.keys(row).filter((key) => typeof row[key] !== "object")))];
  return table(rows, keys.map((key) => ({ key: (row) => row[key], title: key.replaceAll("_", " ") })));
}

/// What draws a part, by its name in page.json: from its rows, and `data`.
const DRAW = { tradeoff, pictures, agreement, speed, accuracy, continuum, atlas, probe, machine_code, scaling, registration, detection,
  plain, figures };

const minute = (date) => String(date ?? "").slice(0, 16).replace("T", " ");
/// "300 x 300" as 300 × 300.
const with_times = (words) => words.replace(/(\d) x(?=$| \d)/g, "$1 ×");

/// Machines beside each other: a line for each backend of each.
function machines_table(files) {
  const lines = [...group_by(files, "context.machine")].flatMap(([machine, mine]) => {
    const of = (command) => mine.filter((file) => file.command === command).flatMap((file) => file.results);
    // All on one scene, doing the same: the largest square, or what is largest.
    const timed = of("bench").filter((row) => row.valid && row.work === "dense" && row.speed_up_over_scalar)
      .sort((a, b) => (b.scene === "square") - (a.scene === "square") || b.width - a.width);
    return distinct([...of("verify"), ...of("bench")], "backend").map((backend) => {
      const compared = of("verify").filter((row) => row.backend === backend && row.verdict !== "skipped");
      const agree = compared.filter((row) => row.verdict === "agree" || row.verdict === "certified").length;
      const best = timed.find((row) => row.backend === backend && scene_of(row) === scene_of(timed[0]));
      return { machine, backend, compared: compared.length, agree, best };
    });
  });
  return table_of(lines, "machine backend compared agree best best.seconds_median best.speed_up_over_scalar " +
    "best.msites_per_second best.percent_of_ceiling");
}

/// Machine, date, verdict, numbers.
function head(machine, files) {
  const dates = files.map((file) => minute(file.context.date)).filter(Boolean).sort();
  const last_file = files.find((file) => minute(file.context.date) === dates.at(-1));
  const newest = last_file?.context ?? {};
  const [first, last] = [dates[0], dates.at(-1)].map((date) => date?.slice(0, 10));
  const where = [first === last ? dates.at(-1) : `${first} to ${last}`, newest.operating_system, newest.compiler,
    newest.commit && `commit ${newest.commit}`, last_file?.commits_ago > 0 && `${plural(last_file.commits_ago, "commit")} before this page`];
  const list = (notes) => notes.length > 0 && el("ul", {}, notes.map((note) => el("li", {}, with_times(note.sentence))));
  const others = machine.notes.filter((note) => note.state === "good");
  // A graphics card has a name by each of its drivers: the shortest.
  const cards = files.filter((file) => file.command === "devices").flatMap((file) => file.results)
    .filter((row) => row.available && !row.software && !["scalar", "openmp"].includes(row.backend))
    .map((row) => row.device).sort((a, b) => a.length - b.length);
  return [
    el("h1", {}, [...cards.slice(0, 1), machine.name].join(" · ")),
    el("p", { class: "soft" }, where.filter(Boolean).join(" · ")),
    el("div", { class: `verdict ${machine.state}` }, el("p", { class: "sentence" }, with_times(machine.sentence)),
      list(machine.notes.filter((note) => note.state !== "good"))),
    el("div", { class: "numbers" }, machine.figures.map((one) =>
      el("div", { class: one.state }, el("b", {}, with_times(one.value)), el("span", {}, with_times(one.text))))),
    others.length > 0 && fold("What else was found", list(others)),
  ];
}

const id_of = (title) => title.toLowerCase().replace(/[^a-z]+/g, "-");

/// What is folded is made when it is opened first.
function part_of(section, rows, data) {
  const draw = () => (section.columns ? table_of(rows, section.columns) : DRAW[section.draw](rows, data));
  if (section.open) return el("section", { id: id_of(section.title) }, el("h2", {}, section.title), draw());
  let made = false;
  const content = el("div");
  const open = () => {
    if (!made) content.append(...nodes(draw()));
    made = true;
  };
  return el("details", { class: "part", id: id_of(section.title), ontoggle: open },
    el("summary", {}, section.title, el("span", { class: "soft" }, plural(rows.length, "row"))), content);
}

/// "Not measured here: ..." with the lines that would.
function missing_line(sections) {
  const words = sections.map((section, i) => [i > 0 && ", ", section.title.toLowerCase(), " (", code(section.run), ")"]);
  return sections.length > 0 && el("p", { class: "soft" }, "Not measured here: ", words, ". Each takes --json FILE.");
}

function show(all, machine) {
  const files = all.files.filter((file) => file.context.machine === machine.name);
  const file_of = new Map(files.flatMap((file) => file.results.map((row) => [row, file])));
  const data = {
    published: all.published,
    picture: (row, name) => name && all.pictures[file_of.get(row).folder + name],
  };
  const known = new Set(PAGE.sections.flatMap((section) => section.commands));
  const unknown = distinct(files, "command").filter((command) => !known.has(command));
  const sections = [...PAGE.sections, ...unknown.map((command) => ({ title: command, commands: [command], draw: "plain" }))];
  const rows_of = ({ commands, about_stiffness: about }) =>
    files.filter((file) => commands.includes(file.command)).flatMap((file) => file.results)
      .filter((row) => about === undefined || is_about_stiffness(row) === about);
  const there = sections.filter((section) => rows_of(section).length > 0);
  const folders = new Set(files.map((file) => file.folder));
  const loose = Object.entries(all.pictures)
    .filter(([name]) => !all.named.includes(name) && folders.has(name.slice(0, name.indexOf("/") + 1)))
    .map(([name, uri]) => [uri, name.split("/").at(-1)]);
  const parts = there.map((section) => part_of(section, rows_of(section), data));
  if (loose.length > 0) parts.push(part_of({ title: "More pictures", draw: "figures" }, loose, data));
  parts.push(part_of({ title: "Reproduce", columns: PAGE.tables.files }, files, data));
  const links = parts.map((part) => el("a", { href: `#${part.id}` }, part.querySelector("h2, summary").firstChild.textContent));
  return nodes([
    head(machine, files),
    el("nav", { "aria-label": "Parts of the page" }, links),
    all.machines.length > 1 && el("section", { id: "machines" }, el("h2", {}, "Machines side by side"), machines_table(all.files)),
    parts,
    missing_line(sections.filter((section) => !there.includes(section))),
  ]);
}

function open_target() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (target?.tagName === "DETAILS") target.open = true;
  target?.scrollIntoView();
}

function start() {
  const all = JSON.parse(document.getElementById("data").textContent);
  for (const file of all.files) file.results = unpacked(file.results);
  const content = el("div");
  const draw = (name) => content.replaceChildren(...show(all, all.machines.find((machine) => machine.name === name)));
  const machines = all.machines.map((machine) => [machine.name]);
  document.getElementById("page").replaceChildren(
    el("p", { class: "soft" }, "hdmbench: one image deformation on CPUs and GPUs: same bits, speed, accuracy ",
      machines.length > 1 && choice("Machine", machines, draw)),
    content);
  draw(all.machines[0].name);
  window.addEventListener("hashchange", open_target);
  open_target();
}
start();
