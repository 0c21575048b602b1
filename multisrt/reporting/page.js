"use strict";
// Tables sort by a click on a heading; a second click turns them round.
for (const table of document.querySelectorAll("table.sorts")) {
  const heads = [...table.tHead.rows[0].cells];
  const body = table.tBodies[0];
  heads.forEach((head, column) => {
    head.querySelector("button").addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      const rows = [...body.rows];
      rows.sort((a, b) => (down ? -1 : 1) * compared(a.cells[column], b.cells[column]));
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      body.append(...rows);
    });
  });
}
function compared(a, b) {
  const x = a.dataset.sort, y = b.dataset.sort;
  if (x !== undefined && y !== undefined) return Number(x) === Number(y) ? 0 : Number(x) - Number(y);
  return a.textContent.localeCompare(b.textContent, "en", { numeric: true });
}
// What is folded in is printed, too.
const folded = new Set();
addEventListener("beforeprint", () => {
  for (const part of document.querySelectorAll("details:not([open])")) {
    folded.add(part);
    part.open = true;
  }
});
addEventListener("afterprint", () => {
  for (const part of folded) part.open = false;
  folded.clear();
});
// A link to something that is folded in unfolds it.
function unfold() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  const part = target && target.closest("details");
  if (part) part.open = true;
}
addEventListener("hashchange", unfold);
unfold();
// What scrolls sideways says where more is, and is in the order of the Tab key only if it scrolls.
const scrolls = document.querySelectorAll(".scroll");
function cue(part) {
  const hidden = part.scrollWidth - part.clientWidth;
  part.classList.toggle("more-left", part.scrollLeft > 1);
  part.classList.toggle("more-right", part.scrollLeft < hidden - 1);
  if (!part.closest("nav")) part.tabIndex = hidden > 1 ? 0 : -1;
  const more = cues.get(part);
  if (more) {
    more.hidden = hidden <= 1;
    more.style.visibility = part.scrollLeft < hidden - 1 ? "visible" : "hidden";
  }
}
// Above a table that is wider than the screen stands that there is more of it.
const cues = new Map();
for (const part of document.querySelectorAll(".scroll.table")) {
  const more = document.createElement("p");
  more.className = "cue";
  more.textContent = "more columns \u2192";
  more.hidden = true;
  more.ariaHidden = "true";
  part.before(more);
  cues.set(part, more);
}
const sized = new ResizeObserver((found) => found.forEach((entry) => cue(entry.target.closest(".scroll"))));
for (const part of scrolls) {
  part.addEventListener("scroll", () => cue(part), { passive: true });
  sized.observe(part);
  if (part.firstElementChild) sized.observe(part.firstElementChild);
}
// The command that repeats a run is copied by a button beside its spec.
function commandOf(spec) {
  const imported = spec.dataset.import ? ` --import ${spec.dataset.import}` : "";
  return `multisrt explore --spec ${spec.getAttribute("href")}${imported} --view --out again`;
}
for (const spec of document.querySelectorAll(".runs a[href^='specs/']")) {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = "copy command";
  button.title = commandOf(spec);
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(commandOf(spec));
      button.textContent = "copied";
    } catch {
      // Without access to the clipboard the command is shown.
      button.textContent = commandOf(spec);
    }
  });
  spec.after(" ", button);
}
