"use strict";
const list = document.getElementById("list"), body = list && list.tBodies[0];
const rows = body ? [...body.querySelectorAll("tr.row")] : [];
const filter = document.getElementById("filter"), count = document.getElementById("count");
const boxes = [...document.querySelectorAll(".controls input[type=checkbox]")];

// Pictures are kept as text until somebody looks: thousands cost nothing.
function toggle(row, open) {
  const next = row.nextElementSibling, shown = next && next.classList.contains("open");
  if (open === undefined) open = !shown;
  if (open === Boolean(shown)) return;
  row.setAttribute("aria-expanded", open);
  if (!open) { next.remove(); return; }
  const tr = document.createElement("tr"), td = tr.insertCell();
  tr.className = "open"; td.className = "details"; td.colSpan = row.cells.length;
  td.innerHTML = document.getElementById("d" + row.dataset.n).textContent;
  row.after(tr);
}
function close(row) { toggle(row, false); }
function apply() {
  const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
  const verdicts = boxes.filter(box => box.checked).map(box => box.value);
  let shown = 0;
  for (const row of rows) {
    const text = row.dataset.text || (row.dataset.text = row.textContent.toLowerCase());
    const keep = words.every(word => text.includes(word)) && verdicts.includes(row.dataset.verdict);
    row.hidden = !keep;
    if (keep) shown++; else close(row);
  }
  count.textContent = shown + " of " + rows.length;
}
function sort(th) {
  const down = th.getAttribute("aria-sort") !== "descending" && th.dataset.number !== undefined
    || th.getAttribute("aria-sort") === "ascending";
  for (const other of th.parentNode.cells) other.removeAttribute("aria-sort");
  th.setAttribute("aria-sort", down ? "descending" : "ascending");
  const at = th.cellIndex, sign = down ? -1 : 1;
  const key = row => {
    const value = row.cells[at].dataset.v;
    return value === undefined ? row.cells[at].textContent : value === "" ? -Infinity : Number(value);
  };
  rows.forEach(close);
  rows.sort((a, b) => {
    const [x, y] = [key(a), key(b)];
    return sign * (typeof x === "number" ? (x === y ? 0 : x < y ? -1 : 1) : x.localeCompare(y));
  });
  body.append(...rows);
}
if (list) {
  for (const th of list.tHead.rows[0].cells) th.firstChild.addEventListener("click", () => sort(th));
  body.addEventListener("click", event => {
    const row = event.target.closest("tr.row");
    if (row) toggle(row);
  });
  document.addEventListener("keydown", event => {
    if (event.key === "/" && event.target !== filter) { filter.focus(); event.preventDefault(); }
    if (event.key === "Escape" && event.target === filter) { filter.value = ""; apply(); filter.blur(); }
    const row = document.activeElement.closest && document.activeElement.closest("tr.row");
    if (!row) return;
    if (event.key === "Enter" || event.key === " ") { toggle(row); event.preventDefault(); }
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step) return;
    const shown = rows.filter(row => !row.hidden), to = shown[shown.indexOf(row) + step];
    if (to) { to.focus(); event.preventDefault(); }
  });
  filter.addEventListener("input", apply);
  boxes.forEach(box => box.addEventListener("change", apply));
  document.getElementById("all").addEventListener("click", () =>
    rows.filter(row => !row.hidden).forEach(row => toggle(row, true)));
  apply();
}
