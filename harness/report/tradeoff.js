"use strict";
// Switches, legend and marks of the charts of speed against accuracy. Without it the page shows seconds against
// FEM nu 0, and every mark says what it is when the pointer rests on it.
for (const block of document.querySelectorAll(".tradeoff")) {
  const marks = [...block.querySelectorAll(".mark")];
  const chosen = { method: new Set(), backend: new Set() };
  const view = { across: "0", up: "0" };

  const show = (element, shown) => {
    if (shown) element.removeAttribute("display");
    else element.setAttribute("display", "none");
  };
  const place = (mark) => [
    mark.dataset.x.split(" ")[view.across],
    mark.dataset.y.split(" ")[view.up],
  ];

  function draw() {
    for (const mark of marks) {
      const [x, y] = place(mark);
      show(mark, x !== "-");
      if (x !== "-") mark.setAttribute("transform", `translate(${x} ${y})`);
    }
    for (const axis of block.querySelectorAll("[data-across]"))
      show(axis, axis.dataset.across === view.across);
    for (const axis of block.querySelectorAll("[data-up]"))
      show(axis, axis.dataset.up === view.up);
    for (const front of block.querySelectorAll("[data-view]"))
      show(front, front.dataset.view === `${view.across} ${view.up}`);
    for (const svg of block.querySelectorAll(".charts svg")) {
      for (const line of svg.querySelectorAll(".series")) {
        const points = [...svg.querySelectorAll(".mark")]
          .filter((mark) => mark.dataset.series === line.dataset.series)
          .map(place)
          .filter(([x]) => x !== "-");
        line.setAttribute("d", points.map(([x, y], i) => `${i ? "L" : "M"}${x} ${y}`).join(""));
      }
    }
  }

  const isChosen = (element) =>
    ["method", "backend"].every(
      (kind) => chosen[kind].size === 0 || chosen[kind].has(element.dataset[kind]));
  function fade() {
    for (const element of block.querySelectorAll(".mark, .series"))
      element.classList.toggle("faded", !isChosen(element));
    const all = chosen.method.size + chosen.backend.size === 0;
    for (const front of block.querySelectorAll(".front")) front.classList.toggle("faded", !all);
  }

  // A paragraph below the chart repeats the title of the mark, so that its command can be copied.
  function pick(mark) {
    const figure = mark.closest("figure");
    figure.querySelector(".mark.picked")?.classList.remove("picked");
    mark.classList.add("picked");
    const [name, figures, command] = mark.querySelector("title").textContent.split("\n");
    const title = document.createElement("b");
    title.textContent = name;
    const code = document.createElement("code");
    code.textContent = command;
    figure.querySelector(".picked-text").replaceChildren(title, ` ${figures} `, code);
  }

  for (const radio of block.querySelectorAll(".switches input")) {
    radio.addEventListener("change", () => {
      view[radio.dataset.axis] = radio.value;
      draw();
    });
    if (radio.checked) view[radio.dataset.axis] = radio.value; // kept by the browser over a reload
  }
  for (const button of block.querySelectorAll("button[data-kind]")) {
    button.disabled = false;
    button.addEventListener("click", () => {
      const of_kind = chosen[button.dataset.kind];
      const on = !of_kind.has(button.value);
      if (on) of_kind.add(button.value);
      else of_kind.delete(button.value);
      button.setAttribute("aria-pressed", String(on));
      fade();
    });
  }
  for (const mark of marks) {
    mark.addEventListener("pointerenter", () => pick(mark));
    mark.addEventListener("click", () => pick(mark));
  }
  // One stop of the Tab key per chart; the arrows go from mark to mark, from left to right.
  for (const svg of block.querySelectorAll(".charts svg")) {
    svg.setAttribute("tabindex", "0");
    svg.setAttribute("role", "application");
    svg.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      const order = [...svg.querySelectorAll(".mark:not([display])")]
        .filter(isChosen)
        .sort((a, b) => place(a)[0] - place(b)[0]);
      if (order.length === 0) return;
      const now = order.findIndex((mark) => mark.classList.contains("picked"));
      const next = now < 0 ? 0 : (now + step + order.length) % order.length;
      pick(order[next]);
    });
  }
  block.querySelector(".switches").hidden = false;
  draw();
}
