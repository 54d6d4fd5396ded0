"use strict";
// The table is complete without this script; it sorts and filters what is there.
(() => {
  const table = document.getElementById("table");
  if (!table) return;
  const body = table.tBodies[0];
  const rows = Array.from(body.rows);
  const heads = Array.from(table.tHead.rows[0].cells);
  const key = (row, i) => {
    const cell = row.cells[i];
    if (!cell.classList.contains("number")) return cell.textContent;
    return "v" in cell.dataset ? Number(cell.dataset.v) : NaN;
  };
  const compare = (a, b, up) => {
    if (typeof a === "string") return (up ? 1 : -1) * a.localeCompare(b, "en", { numeric: true });
    // What is missing stays last in both orders.
    if (Number.isNaN(a) || Number.isNaN(b)) return Number.isNaN(a) - Number.isNaN(b);
    return up ? a - b : b - a;
  };
  heads.forEach((head, i) => {
    head.querySelector("button").addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      heads.forEach((h) => h.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const sorted = rows.map((row) => [key(row, i), row]);
      sorted.sort((a, b) => compare(a[0], b[0], up));
      body.append(...sorted.map((pair) => pair[1]));
    });
  });
  const filter = document.getElementById("filter");
  const shown = document.getElementById("shown");
  const texts = rows.map((row) => row.textContent.toLowerCase());
  filter.addEventListener("input", () => {
    const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    let count = 0;
    rows.forEach((row, i) => {
      row.hidden = !words.every((word) => texts[i].includes(word));
      count += !row.hidden;
    });
    shown.textContent = words.length ? count + " of " + rows.length : "";
  });
})();

// Figures are complete without this script; it lights up what is of one method in all of them.
(() => {
  const marks = Array.from(document.querySelectorAll("figure [data-method]"));
  if (!marks.length) return;
  const name = document.createElement("output");
  name.className = "lit-name";
  document.body.append(name);
  const light = (mark) => {
    const method = mark ? mark.dataset.method : "";
    document.body.classList.toggle("lighting", method !== "");
    marks.forEach((other) => other.classList.toggle("lit", other.dataset.method === method));
    const says = mark && mark.querySelector("title");
    name.textContent = says ? says.textContent : method;
  };
  const markAt = (node) => node.closest && node.closest("figure [data-method]");
  document.addEventListener("pointerover", (event) => light(markAt(event.target) || markAt(document.activeElement)));
  document.addEventListener("focusin", (event) => light(markAt(event.target)));
  document.addEventListener("focusout", () => light(null));
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape") light(null);
  });
  // The keyboard comes to a figure once, and arrows go through its methods.
  document.querySelectorAll("figure svg").forEach((figure) => {
    const stops = Array.from(figure.querySelectorAll("[data-method]"));
    if (!stops.length) return;
    figure.setAttribute("role", "group");
    stops.forEach((stop, i) => {
      const says = stop.querySelector("title");
      stop.tabIndex = i ? -1 : 0;
      stop.setAttribute("role", "img");
      stop.setAttribute("aria-label", says ? says.textContent : stop.dataset.method);
    });
    figure.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      const from = stops.indexOf(document.activeElement);
      if (!step || from < 0) return;
      event.preventDefault();
      const to = stops[(from + step + stops.length) % stops.length];
      stops[from].tabIndex = -1;
      to.tabIndex = 0;
      to.focus();
    });
  });
})();
