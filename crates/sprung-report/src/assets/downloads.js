// Downloads: each figure as SVG or PNG, each table as CSV. Nothing is loaded from elsewhere.

// Parts of a figure that are controls.
const CONTROLS = "figcaption, .hint, .reset, .downloads, .skeleton-bar, .u-over, .u-under, .u-legend, output";

// Space around a saved figure, pixels.
const MARGIN = 10;

const rounded = (x) => String(Math.round(10 * x) / 10);

// Returns an element of an SVG document.
function svgElement(tag, attributes, text = null) {
  const made = document.createElementNS(swatch("measured").namespaceURI, tag);
  for (const [name, value] of Object.entries(attributes)) {
    made.setAttribute(name, typeof value === "number" ? rounded(value) : value);
  }
  if (text !== null) made.textContent = text;
  return made;
}

const isVisible = (paint) => paint !== "transparent" && !/^rgba\(.*, 0\)$/.test(paint);

// Copies what the page shows of a figure into an SVG document.
class Drawing {
  constructor(figure) {
    const box = figure.getBoundingClientRect();
    const caption = figure.querySelector("figcaption")?.getBoundingClientRect();
    this.left = box.left - MARGIN;
    this.top = box.top - MARGIN;
    this.width = box.width + 2 * MARGIN;
    this.height = (caption && caption.height > 0 ? caption.top : box.bottom) - box.top + 2 * MARGIN;
    const size = { width: this.width, height: this.height };
    this.svg = svgElement("svg", { ...size, viewBox: `0 0 ${rounded(this.width)} ${rounded(this.height)}` });
    this.add("rect", { ...size, fill: color("paper") });
    for (const child of figure.childNodes) this.copy(child);
    // An overview names its horizontal axis beside its legend.
    const axis = figure.matches(".overview") && figure.querySelector(".x-label");
    const place = { x: this.width - MARGIN, y: MARGIN + 12, "text-anchor": "end", "font-size": "12px" };
    if (axis) this.add("text", { ...place, fill: color("soft"), "font-family": getComputedStyle(axis).fontFamily }, axis.textContent);
  }

  add(tag, attributes, text = null) {
    this.svg.append(svgElement(tag, attributes, text));
  }

  copy(node) {
    if (node.nodeType === Node.TEXT_NODE) this.text(node);
    if (node.nodeType !== Node.ELEMENT_NODE || node.matches(CONTROLS)) return;
    const style = getComputedStyle(node);
    if (style.display === "none" || style.visibility === "hidden") return;
    if (node.matches(".uplot")) {
      const panel = figures.flatMap((figure) => figure.panels).find(({ plot }) => plot?.root === node);
      if (panel) this.plot(panel);
      return;
    }
    if (node.tagName.toLowerCase() === "svg") {
      this.picture(node);
      return;
    }
    this.paint(node, style);
    for (const child of node.childNodes) this.copy(child);
  }

  // Copies the background of an element: a bar, a mark, a rule.
  paint(node, style) {
    const box = node.getBoundingClientRect();
    const [x, y] = [box.left - this.left, box.top - this.top];
    const [right, bottom] = [x + box.width, y + box.height];
    const middle = { x: x + box.width / 2, y: y + box.height / 2 };
    const polygon = (points, fill) => this.add("polygon", { points: points.map((p) => p.map(rounded).join()).join(" "), fill });
    if (node.matches(".cut.low")) polygon([[right, y], [right, bottom], [x, middle.y]], style.borderRightColor);
    else if (node.matches(".cut.high")) polygon([[x, y], [x, bottom], [right, middle.y]], style.borderLeftColor);
    else if (style.backgroundImage !== "none" && node.matches(".lanes")) {
      this.add("line", { x1: middle.x, x2: middle.x, y1: y, y2: bottom, stroke: color("soft"), "stroke-width": "1" });
    } else if (isVisible(style.backgroundColor) && box.width > 0) {
      const fill = style.backgroundColor;
      if (style.transform !== "none") polygon([[middle.x, y], [right, middle.y], [middle.x, bottom], [x, middle.y]], fill);
      else this.add("rect", { x, y, width: box.width, height: box.height, rx: style.borderRadius === "50%" ? box.width / 2 : 0, fill });
    }
  }

  // Copies a text, line by line.
  text(node) {
    const words = [...node.data.matchAll(/\S+/g)];
    if (!words.length) return;
    const style = getComputedStyle(node.parentElement);
    const range = document.createRange();
    const lines = [];
    for (const word of words) {
      range.setStart(node, word.index);
      range.setEnd(node, word.index + word[0].length);
      const box = range.getBoundingClientRect();
      const line = lines.at(-1);
      if (line && Math.abs(line.box.top - box.top) < 2) line.text += ` ${word[0]}`;
      else lines.push({ box, text: word[0] });
    }
    for (const { box, text } of lines) {
      if (box.width === 0) continue;
      this.add("text", {
        x: box.left - this.left,
        y: box.top - this.top + 0.78 * box.height,
        fill: style.color,
        "font-size": style.fontSize,
        "font-weight": style.fontWeight,
        "font-family": style.fontFamily,
      }, text);
    }
  }

  picture(node) {
    const box = node.getBoundingClientRect();
    const copy = node.cloneNode(true);
    const originals = [...node.querySelectorAll("*")];
    [...copy.querySelectorAll("*")].forEach((part, i) => {
      part.setAttribute("stroke", getComputedStyle(originals[i]).stroke);
      part.removeAttribute("style");
    });
    const place = { x: box.left - this.left, y: box.top - this.top, width: box.width, height: box.height };
    for (const [name, value] of Object.entries(place)) copy.setAttribute(name, rounded(value));
    this.svg.append(copy);
  }

  // Copies axes and curves of a plot.
  plot({ plot, data }) {
    const place = plot.over.getBoundingClientRect();
    const [left, top] = [place.left - this.left, place.top - this.top];
    const [right, bottom] = [left + place.width, top + place.height];
    const x = (value) => left + plot.valToPos(value, "x");
    const y = (value) => top + plot.valToPos(value, "y");
    const label = { fill: color("axis"), "font-size": "11px", "font-family": getComputedStyle(document.body).fontFamily };
    const grid = { stroke: color("grid"), "stroke-width": "1" };
    const [across, up] = plot.axes;
    const ticks = (axis) => (axis._splits ?? []).map((value, i) => [value, axis._values?.[i] ?? ""]);
    for (const [value, text] of ticks(across)) {
      this.add("line", { x1: x(value), x2: x(value), y1: top, y2: bottom, ...grid });
      if (text) this.add("text", { x: x(value), y: bottom + 16, "text-anchor": "middle", ...label }, text);
    }
    for (const [value, text] of ticks(up)) {
      this.add("line", { x1: left, x2: right, y1: y(value), y2: y(value), ...grid });
      this.add("text", { x: left - 8, y: y(value) + 4, "text-anchor": "end", ...label }, text);
    }
    // An inner svg element cuts off what lies outside of it.
    const area = svgElement("svg", { x: left, y: top, width: place.width, height: place.height });
    this.svg.append(area);
    data.series.forEach(({ style }, i) => {
      if (!plot.series[i + 1].show) return;
      const { width, dash } = STYLES[style];
      if (style === "cloud") {
        plot.data[i + 1].forEach((value, k) => {
          if (value === null) return;
          const at = { cx: rounded(x(plot.data[0][k]) - left), cy: rounded(y(value) - top) };
          area.append(svgElement("circle", { ...at, r: 1.5, fill: color(style) }));
        });
        return;
      }
      // A curve beside points has values at a part of them only.
      const spans = plot.series[i + 1].spanGaps;
      let pen = "M";
      const path = plot.data[i + 1].map((value, k) => {
        if (value === null) {
          if (!spans) pen = "M";
          return "";
        }
        const step = `${pen}${rounded(x(plot.data[0][k]) - left)} ${rounded(y(value) - top)}`;
        pen = "L";
        return step;
      });
      const line = { d: path.join(""), fill: "none", stroke: color(style), "stroke-width": String(width) };
      area.append(svgElement("path", { ...line, "stroke-dasharray": dash.join(" ") || "none" }));
    });
    for (const { at, text } of data.marks) {
      this.add("line", { x1: x(at), x2: x(at), y1: top, y2: bottom, stroke: color("second"), "stroke-dasharray": "4 3" });
      this.add("text", { x: x(at) + 4, y: top + 12, ...label }, text);
    }
    for (const { style, value, high } of outside(plot, data)) {
      const [tip, base] = high ? [top, top + 4] : [bottom, bottom - 4];
      const at = x(value);
      this.add("polygon", { points: `${rounded(at)},${rounded(tip)} ${rounded(at - 4)},${rounded(base)} ${rounded(at + 4)},${rounded(base)}`, fill: color(style) });
    }
  }
}

const svgOf = (figure) => {
  const index = figure.querySelector("[data-figure]")?.dataset.figure;
  const shown = figures.filter(({ key, isDrawn }) => key === `figure-${index}` && !isDrawn);
  if (shown.length) draw(shown);
  return new XMLSerializer().serializeToString(new Drawing(figure).svg);
};

// Returns a picture of an SVG document in twice its size.
function pngOf(text) {
  const url = URL.createObjectURL(new Blob([text], { type: "image/svg+xml" }));
  const image = new Image();
  const drawn = new Promise((resolve, reject) => {
    image.onload = () => {
      const canvas = element("canvas", { width: 2 * image.width, height: 2 * image.height });
      canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
      canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("no picture"))), "image/png");
    };
    image.onerror = () => reject(new Error("the figure cannot become a picture"));
  });
  image.src = url;
  return drawn.finally(() => URL.revokeObjectURL(url));
}

// Returns a table as CSV: full names, values apart from their errors, group headings as a column.
function csvOf(table) {
  const headings = [...table.querySelectorAll("thead th")].map((th) => th.textContent.trim());
  const rows = [...table.tBodies[0].rows];
  const isHeading = (row) => row.classList.contains("heading");
  const split = headings.map((heading) => / ± \S/.test(heading));
  const cut = (texts) => texts.flatMap((text, i) => {
    if (!split[i]) return [text];
    const [value, ...error] = text.split(" ± ");
    return [value, error.join(" ± ")];
  });
  const name = (cell, i) => {
    const text = cell.title || cell.textContent;
    return (i === 0 ? text.replace(/^θ\d+\u00a0/, "") : text).trim();
  };
  const grouped = rows.some(isHeading);
  let group = "";
  const lines = [[...(grouped ? ["Group"] : []), ...cut(headings)]];
  for (const row of rows) {
    if (isHeading(row)) group = row.textContent.trim();
    else lines.push([...(grouped ? [group] : []), ...cut([...row.cells].map(name))]);
  }
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  // A byte order mark tells spreadsheets that the text is UTF-8.
  return `\ufeff${lines.map((line) => line.map(quoted).join()).join("\r\n")}\r\n`;
}

function save(blob, name) {
  const url = URL.createObjectURL(blob);
  const link = element("a", { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

const slug = (text) => text.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "");

function button(text, title, action) {
  const made = element("button", { type: "button", title }, text);
  made.addEventListener("click", async () => {
    try {
      await action();
    } catch (error) {
      made.textContent = "failed";
      made.title = error.message;
    }
  });
  return made;
}

function startDownloads() {
  const title = slug(document.title) || "report";
  const counts = new Map();
  // A name for a part of a section, unique in the page.
  const name = (node) => {
    const section = node.closest("section, details")?.id || "part";
    counts.set(section, (counts.get(section) ?? 0) + 1);
    const count = counts.get(section);
    return `${title}-${slug(section)}${count > 1 ? `-${count}` : ""}`;
  };
  for (const figure of document.querySelectorAll("main figure:not(.drawing)")) {
    const file = name(figure);
    const svg = button("SVG", "download this figure as SVG", () => save(new Blob([svgOf(figure)], { type: "image/svg+xml" }), `${file}.svg`));
    const png = button("PNG", "download this figure as PNG", async () => save(await pngOf(svgOf(figure)), `${file}.png`));
    figure.querySelector("figcaption").append(element("span", { class: "downloads" }, svg, png));
  }
  for (const scroll of document.querySelectorAll(".scroll")) {
    const table = scroll.querySelector("table");
    if (!table) continue;
    const file = name(table);
    const csv = button("CSV", "download this table as CSV", () => save(new Blob([csvOf(table)], { type: "text/csv" }), `${file}.csv`));
    let caption = scroll.previousElementSibling;
    if (!caption?.matches(".caption")) {
      caption = element("p", { class: "caption" });
      scroll.before(caption);
    }
    caption.append(element("span", { class: "downloads" }, csv));
  }
}
