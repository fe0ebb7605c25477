"use strict";
// What the page is built of: elements, numbers in words, tables. All text goes in as text, never as HTML.

/// el("p", {class: "note", onclick: f}, "text", child): attributes that are undefined or false are left out.
function el(name, attributes, ...children) {
  const space = { svg: 1, g: 1, path: 1, line: 1, rect: 1, text: 1, circle: 1, polyline: 1 }[name];
  const node = space ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes ?? {})) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value !== undefined && value !== false && value !== null) node.setAttribute(key, value === true ? "" : value);
  }
  node.append(...nodes(children));
  return node;
}
/// Nested lists as one, without what is not there.
const nodes = (list) => [list].flat(9).filter((one) => one !== undefined && one !== null && one !== false && one !== "");

const has_value = (value) => value !== undefined && value !== null && value !== "" && value.length !== 0;
const is_number = (value) => typeof value === "number" && Number.isFinite(value);
const NONE = "–";

/// Three significant digits: 0.0412, 1.27, 1 056; an exponent only where zeros would be many.
function number(value, digits = 3) {
  if (!is_number(value)) return value === undefined || value === null ? NONE : String(value);
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e15)) return value.toExponential(digits - 1);
  if (size >= 10 ** (digits - 1) || Number.isInteger(value)) return count(Math.round(value));
  return String(Number(value.toPrecision(digits)));
}
/// Digits in groups of three.
const count = (value) =>
  is_number(value) ? String(value).replace(/\B(?=(\d{3})+$)/g, "\u202f") : number(value);
const unit = (name, factor = 1) => (value) => (is_number(value) ? `${number(value * factor)}\u00a0${name}` : NONE);
function seconds(value) {
  const [name, factor] = value === 0 || value >= 1 ? ["s", 1] : value >= 1e-3 ? ["ms", 1e3] : ["µs", 1e6];
  return unit(name, factor)(value);
}
const times = (value) => (is_number(value) ? `${number(value)}\u00a0×` : NONE);
const percent = unit("%", 100);
const yes_no = (value) => (value === true ? "yes" : value === false ? "no" : NONE);
const any_text = (value) =>
  typeof value === "boolean" ? yes_no(value) : is_number(value) ? number(value) : has_value(value) ? String(value) : NONE;
const code = (value) => (value ? el("code", {}, value) : NONE);
/// 300 × 300, or 64 × 64 × 64 of a volume.
const size_of = (row) =>
  row.width === undefined ? NONE : [row.width, row.height, ...(row.depth > 1 ? [row.depth] : [])].join("\u00a0×\u00a0");
/// Verdicts and outcomes, coloured.
const TONES = { agree: "good", passed: "good", exact: "good", bitwise: "good", ok: "good", certified: "fair", disagree: "bad",
  failed: "bad", error: "bad", crashed: "bad", refused: "bad", mistrusted: "fair", diverged: "bad" };
const verdict = (value) => (value ? el("span", { class: TONES[value] ?? "soft" }, String(value)) : NONE);
const plural = (number_of, noun) => `${count(number_of)} ${noun}${number_of === 1 ? "" : "s"}`;

/// What a column shows of a row: `key` is the name of a field ("total.rmsd" goes inside) or a function of the row.
const value_of = (row, key) =>
  typeof key === "function" ? key(row) : key.split(".").reduce((value, part) => value?.[part], row);

const distinct = (rows, key) => [...new Set(rows.map((row) => value_of(row, key)))].filter((value) => value !== undefined);
function group_by(rows, key) {
  const groups = new Map();
  for (const row of rows) {
    const name = value_of(row, key);
    groups.has(name) ? groups.get(name).push(row) : groups.set(name, [row]);
  }
  return groups;
}

const csv_word = (value) => {
  const text = value === undefined || value === null ? "" : typeof value === "object" ? JSON.stringify(value) : String(value);
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};
/// The figures as they were measured, not as they are rounded for the page.
const csv_of = (rows, columns) =>
  [columns.map((column) => column.title), ...rows.map((row) => columns.map((column) => value_of(row, column.key)))]
    .map((line) => line.map(csv_word).join(",") + "\n").join("");

async function copy(text, button) {
  const before = button.textContent;
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = el("textarea", {}); // where a browser gives a file's page no clipboard
    area.value = text;
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  button.textContent = "copied";
  setTimeout(() => (button.textContent = before), 1500);
}

const FEW_ROWS = 12, FEW_COLUMNS = 10; // page.css has the latter, too

/// A table that is sorted by a click on a column's title and copied as CSV. A column is {key, title, format}: `format`
/// makes text or an element of (value, row). A column without a value in any row is left out. Beyond a dozen
/// the rows wait behind a button, and so do columns beyond the tenth.
function table(rows, columns) {
  const shown = columns.filter((column) => rows.some((row) => has_value(value_of(row, column.key))));
  const numeric = shown.map((column) => rows.some((row) => is_number(value_of(row, column.key))));
  let order = rows.slice(), sorted = null, down = false, all = rows.length <= FEW_ROWS + 3;

  const body = el("tbody");
  const more = el("button", { type: "button", onclick: () => { all = true; fill(); } }, `show all ${count(rows.length)} rows`);
  const kind_of = (value) => { const length = String(value).length; return length > 60 ? "prose" : length > 18 && "long"; };
  const cell = (row, column, i) => {
    const value = value_of(row, column.key);
    const text = (column.format ?? any_text)(value, row);
    return el(i === 0 ? "th" : "td", { class: numeric[i] ? "number" : kind_of(value), scope: i === 0 && "row" }, text);
  };
  function fill() {
    body.replaceChildren(...(all ? order : order.slice(0, FEW_ROWS)).map((row) =>
      el("tr", { class: row.thesis && "thesis" }, shown.map((column, i) => cell(row, column, i)))));
    more.hidden = all;
  }
  function sort(index) {
    down = sorted === index ? !down : false;
    sorted = index;
    const of = (row) => value_of(row, shown[index].key);
    const compare = (a, b) => (is_number(a) && is_number(b) ? a - b : String(a).localeCompare(String(b), "en", { numeric: true }));
    order = rows.slice().sort((a, b) =>
      !has_value(of(a)) || !has_value(of(b)) ? has_value(of(b)) - has_value(of(a)) : (down ? -1 : 1) * compare(of(a), of(b)));
    for (const head of heads) head.removeAttribute("aria-sort");
    heads[index].setAttribute("aria-sort", down ? "descending" : "ascending");
    fill();
  }
  const heads = shown.map((column, i) =>
    el("th", { class: numeric[i] && "number", scope: "col" },
      el("button", { type: "button", title: "Sort by this column", onclick: () => sort(i) }, column.title)));
  const csv = el("button", { type: "button", class: "csv", onclick: () => copy(csv_of(order, shown), csv) }, "copy as CSV");
  fill();
  const is_wide = shown.length > FEW_COLUMNS + 1;
  const wider = is_wide && el("button", { type: "button",
    onclick: () => { body.parentElement.className = ""; wider.remove(); } }, `show all ${shown.length} columns`);
  return el("div", { class: "table" },
    el("div", { class: "scroll", tabindex: 0 }, el("table", { class: is_wide && "few" }, el("thead", {}, el("tr", {}, heads)), body)),
    el("p", { class: "tools" }, more, wider, csv));
}

/// A choice of one out of `options` ([value, text], ...), which begins with the first; `change` gets the value.
function choice(label, options, change, first = options[0]?.[0]) {
  const select = el("select", { onchange: () => change(select.value) },
    options.map(([value, text]) => el("option", { value, selected: value === first }, text ?? value)));
  return el("label", { class: "choice" }, label, " ", select);
}
/// Choices and below them what `draw(chosen)` makes of them: `chosen` has a value for every key of `choices`
/// ({key: [label, options]}); a choice of one thing only is not shown.
function chosen_view(choices, draw) {
  const chosen = Object.fromEntries(Object.entries(choices).map(([key, [, options]]) => [key, options[0]?.[0]]));
  const view = el("div");
  const show = () => view.replaceChildren(...nodes(draw(chosen)));
  const bar = Object.entries(choices).filter(([, [, options]]) => options.length > 1)
    .map(([key, [label, options]]) => choice(label, options, (value) => { chosen[key] = value; show(); }));
  show();
  return el("div", {}, bar.length > 0 && el("p", { class: "choices" }, bar), view);
}
