// Sections that fold, tables that become cards, printing, and the start of the page.

// A longer text takes two places of a card.
const LONG_CELL = 11;

// A table that is wider than its place becomes one card per row.
function fitTable(scroll) {
  const table = scroll.querySelector("table");
  if (!table || scroll.clientWidth === 0) return;
  if (!("labelled" in table.dataset)) {
    const headings = [...table.querySelectorAll("thead th")].map((th) => th.textContent);
    for (const row of table.tBodies[0].rows) {
      [...row.cells].forEach((cell, i) => {
        if (cell.tagName !== "TD") return;
        cell.dataset.label = headings[i];
        cell.classList.toggle("long", cell.textContent.length > LONG_CELL);
      });
    }
    table.dataset.labelled = "";
  }
  table.classList.remove("cards", "small");
  const isTooWide = () => table.offsetWidth > scroll.clientWidth + 1;
  if (isTooWide()) table.classList.add("small");
  if (isTooWide()) table.classList.add("cards");
}

function startTables() {
  const scrolls = [...document.querySelectorAll(".scroll")].filter((box) => box.querySelector("table"));
  const widths = new Map();
  const fit = (some) => {
    for (const scroll of some) {
      // Only another width matters: cards change the height.
      if (widths.get(scroll) === scroll.clientWidth) continue;
      widths.set(scroll, scroll.clientWidth);
      fitTable(scroll);
    }
  };
  // A change of the page inside the observer would call it again.
  const observer = new ResizeObserver((entries) => {
    setTimeout(() => fit(entries.map(({ target }) => target)));
  });
  fit(scrolls);
  for (const scroll of scrolls) observer.observe(scroll);
}

const folds = () => [...document.querySelectorAll("details.fold, details.band")];

// Opens the section that the address names, or all sections.
function openNamed() {
  const name = decodeURIComponent(location.hash.slice(1));
  if (name === "all") {
    for (const fold of folds()) fold.open = true;
    drawOpen();
    return;
  }
  const target = name && document.getElementById(name);
  const closed = target ? [target.closest("details.fold"), target.closest("details.meaning")].filter(Boolean) : [];
  if (!closed.length) return;
  for (const fold of closed) fold.open = true;
  target.scrollIntoView();
}

let openedForPaper = [];

// Paper shows the sections that matter, and those that the reader has opened.
function print(on) {
  if (on === "printing" in root.dataset) return;
  if (on) {
    openedForPaper = folds().filter((fold) => !fold.open && fold.matches(".screen, .band"));
    for (const fold of openedForPaper) fold.open = true;
    root.dataset.printing = "";
  } else {
    for (const fold of openedForPaper) fold.open = false;
    delete root.dataset.printing;
  }
  for (const scroll of document.querySelectorAll(".scroll")) fitTable(scroll);
  scale = on ? PRINT_SCALE : 1;
  drawAgain();
  if (on) drawOpen();
}

addEventListener("error", ({ message }) => {
  const notice = document.getElementById("script-error");
  notice.textContent = `A script of this page failed, some plots may be missing: ${message}`;
  notice.hidden = false;
});
const wide = matchMedia("(min-width: 90rem)");
const foldContents = () => document.querySelector(".toc details")?.toggleAttribute("open", wide.matches);
wide.addEventListener("change", foldContents);
foldContents();
startPlots();
startTables();
startDownloads();
addEventListener("hashchange", openNamed);
openNamed();
addEventListener("beforeprint", () => print(true));
addEventListener("afterprint", () => print(false));
