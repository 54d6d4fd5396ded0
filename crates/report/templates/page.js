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
