// The plots of the page.
const root = document.documentElement;
const STYLES = {
  measured: { width: 1.8, dash: [] },
  first: { width: 1.3, dash: [] },
  second: { width: 1.4, dash: [7, 4] },
  third: { width: 1.4, dash: [8, 3, 2, 3] },
  error: { width: 1.1, dash: [] },
  reference: { width: 1.2, dash: [2, 3] },
  cloud: { width: 0, dash: [] },
};
// Paper shows far more detail than a screen, so plots are drawn larger and then reduced.
const PRINT_SCALE = 3;

const HINT = matchMedia("(pointer: coarse)").matches
  ? "draw sideways to zoom, tap twice to reset"
  : "drag or keys + − ← → to zoom, double-click or 0 to reset";

const figures = [];
let store = { axes: [], curves: [], figures: [] };
let scale = 1;
let expected = 0;

const color = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim();

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

function swatch(style) {
  const { width, dash } = STYLES[style];
  const box = document.createElement("template");
  if (style === "cloud") {
    box.innerHTML = `<svg aria-hidden="true"><circle cx="13" cy="4" r="2" style="fill: var(--cloud)"/></svg>`;
    return box.content.firstChild;
  }
  box.innerHTML = `<svg aria-hidden="true"><line x2="26" y1="4" y2="4" stroke-width="${width + 0.4}"
    stroke-dasharray="${dash.join(" ")}" style="stroke: var(--${style})"/></svg>`;
  return box.content.firstChild;
}

const minus = (text) => text.replaceAll("-", "\u2212");
const readout = (value) => (value == null ? "\u2013" : minus(String(Number(value.toPrecision(5)))));

// Returns at least two tick values: multiples of the largest step of 1, 2 or 5 that has two of them in the range, or the
// ends of a symmetric range.
function fewTicks(low, high, most) {
  const power = 10 ** Math.ceil(Math.log10(high - low || 1));
  for (const unit of [1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01]) {
    const step = unit * power;
    const [first, last] = [Math.ceil(low / step - 1e-9), Math.floor(high / step + 1e-9)];
    if (last - first < 1) continue;
    const all = Array.from({ length: last - first + 1 }, (_, k) => (first + k) * step);
    return all.length <= most ? all : [all[0], all.at(-1)];
  }
  return [low, high];
}

// Ticks of a logarithmic axis: 1, 2 and 5 in each decade.
function decades(low, high) {
  const all = [];
  for (let power = Math.floor(Math.log10(low)); 10 ** power <= high; power++) {
    for (const unit of [1, 2, 5]) {
      const at = Number((unit * 10 ** power).toPrecision(3));
      if (at >= low && at <= high) all.push(at);
    }
  }
  return all;
}

// All tick labels of an axis share their number of decimals or their exponent.
function tickLabels(splits, step) {
  const largest = Math.max(...splits.map(Math.abs));
  const far = largest >= 1e6 || (largest > 0 && largest < 1e-3);
  const power = far ? Math.floor(Math.log10(largest)) : 0;
  const unit = step / 10 ** power;
  let decimals = 0;
  while (decimals < 9 && Math.abs(unit * 10 ** decimals - Math.round(unit * 10 ** decimals)) > 1e-6) decimals++;
  return splits.map((value) => {
    if (value === 0) return "0";
    const text = (value / 10 ** power).toFixed(decimals);
    return minus(far ? `${text}e${power}` : text);
  });
}

// A curve is 32-bit floats in Base64; a value that is no number is a gap.
const curve = (() => {
  const known = new Map();
  return (index) => {
    if (!known.has(index)) {
      const bytes = Uint8Array.from(atob(store.curves[index]), (c) => c.charCodeAt(0));
      known.set(index, Array.from(new Float32Array(bytes.buffer), (v) => (Number.isFinite(v) ? v : null)));
    }
    return known.get(index);
  };
})();

// A panel with errors has a second coordinate system with the differences from its first curve.
function panelsOf(data) {
  return data.panels.flatMap((panel) => {
    const { length } = store.axes[panel.axis];
    // A constant curve is stored as one value.
    const all = (values) => (values.length === 1 ? Array(length).fill(values[0]) : values);
    const series = panel.series.map((s) => ({ ...s, values: all(curve(s.curve)) }));
    const single = { ...panel, series };
    if (panel.errors === null) return [single];
    const [measured, ...models] = series;
    const difference = (values) => values.map((v, i) => {
      const truth = measured.values[i];
      return v === null || truth === null ? null : truth - v;
    });
    const errors = models.map((s) => ({ ...s, values: difference(s.values) }));
    const isStrip = data.layout === "overview";
    return [single, { ...panel, y_label: panel.errors, note: "", series: errors, isStrip }];
  });
}

const countPanels = (data) => data.panels.reduce((sum, panel) => sum + (panel.errors === null ? 1 : 2), 0);

function yRange(_plot, low, high) {
  if (low == null || high == null) return [0, 1];
  if (low === high) return [low - (0.1 * Math.abs(low) || 1), high + (0.1 * Math.abs(high) || 1)];
  // Tick labels cannot show smaller differences.
  const room = 0.07 * Math.max(high - low, 1e-4 * Math.max(Math.abs(low), Math.abs(high)));
  return [low - room, high + room];
}

// The difference from a measured curve has zero in the middle.
function stripRange(_plot, low, high) {
  const most = Math.max(Math.abs(low ?? 0), Math.abs(high ?? 0)) || 1;
  return [-1.2 * most, 1.2 * most];
}

function wholeRange(data) {
  const axes = data.panels.map((panel) => store.axes[panel.axis]);
  const low = Math.min(...axes.filter((x) => x.length).map((x) => x[0]));
  const high = Math.max(...axes.filter((x) => x.length).map((x) => x[x.length - 1]));
  if (!(low <= high)) return [0, 1];
  return low < high ? [low, high] : [low - 0.5, high + 0.5];
}

function zoom(figure, range) {
  figure.range = range;
  figure.reset.hidden = range === null;
  figure.hint.hidden = range !== null;
  const [min, max] = range ?? figure.whole;
  for (const { plot } of figure.panels) plot.setScale("x", { min, max });
}

function showValues(figure, panel) {
  const index = panel.plot.cursor.idx;
  panel.outputs.forEach((output, i) => {
    output.textContent = index == null ? "" : readout(panel.plot.data[i + 1][index]);
  });
  const x = index == null ? null : panel.plot.data[0][index];
  if (x != null) figure.position.textContent = `${figure.data.x_label}: ${readout(x)}`;
  else if (figure.panels[0] === panel) figure.position.textContent = "";
}

// A sideways touch acts like the mouse; a vertical touch scrolls.
function listenToTouch(figure, over) {
  let start = null;
  let lastTap = 0;
  const pass = (type, event) => {
    const { clientX, clientY } = event;
    over.dispatchEvent(new MouseEvent(type, { bubbles: true, clientX, clientY, movementX: 1 }));
  };
  over.addEventListener("pointerdown", (event) => {
    if (event.pointerType !== "touch" || !event.isPrimary) return;
    start = event;
    pass("mousemove", event);
    pass("mousedown", event);
  });
  over.addEventListener("pointermove", (event) => {
    if (start && event.pointerId === start.pointerId) pass("mousemove", event);
  });
  over.addEventListener("pointerup", (event) => {
    if (!start || event.pointerId !== start.pointerId) return;
    const tapped = Math.abs(event.clientX - start.clientX) < 8;
    pass("mouseup", tapped ? start : event);
    start = null;
    if (tapped && event.timeStamp - lastTap < 350) zoom(figure, null);
    lastTap = tapped ? event.timeStamp : 0;
  });
  over.addEventListener("pointercancel", () => {
    if (start) {
      pass("mousemove", start);
      pass("mouseup", start);
    }
    start = null;
  });
}

// Keys zoom about the middle, move and reset.
const KEYS = { "+": [0.25, -0.25], "=": [0.25, -0.25], "-": [-0.5, 0.5], ArrowLeft: [-0.2, -0.2], ArrowRight: [0.2, 0.2] };

function listenToKeys(figure, panel) {
  panel.box.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const isReset = event.key === "0" || event.key === "Escape";
    const move = KEYS[event.key];
    if (!isReset && !move) return;
    event.preventDefault();
    if (isReset) return zoom(figure, null);
    // Keys move by parts of the axis as it is drawn.
    const [to, from] = figure.data.logarithmic ? [Math.log10, (x) => 10 ** x] : [Number, Number];
    const [low, high] = (figure.range ?? figure.whole).map(to);
    const [first, last] = figure.whole.map(to);
    const width = high - low;
    const size = Math.min(width * (1 + move[1] - move[0]), last - first);
    const start = Math.max(first, Math.min(low + move[0] * width, last - size));
    zoom(figure, size < last - first ? [start, start + size].map(from) : null);
  });
}

function axisOptions(size, last, logarithmic) {
  const grid = size !== "stack";
  // Low panels have few labels, and no labels of time.
  const low = size === "dense" || size === "strip";
  const common = {
    stroke: color("axis"),
    font: `${Math.round(11 * scale)}px ${getComputedStyle(document.body).fontFamily}`,
    grid: { stroke: color("grid"), width: scale },
    ticks: { stroke: color("grid"), width: scale, size: 4 * scale },
    gap: 4 * scale,
  };
  const named = size === "stack" ? last : !low;
  return [
    {
      ...common,
      ...(logarithmic ? { splits: (_plot, _axis, min, max) => decades(min, max), filter: (_plot, splits) => splits } : {}),
      space: (grid ? 40 : 64) * scale,
      size: (named ? 24 : 6) * scale,
      values: (_plot, splits, _axis, _space, step) => {
        if (!named) return splits.map(() => "");
        return logarithmic ? splits.map(String) : tickLabels(splits, step);
      },
    },
    {
      ...common,
      ...(low ? { splits: (_plot, _axis, min, max) => fewTicks(min, max, size === "strip" ? 2 : 4) } : {}),
      space: 26 * scale,
      size: (_plot, labels) => {
        const longest = Math.max(0, ...(labels ?? []).map((label) => label.length));
        return Math.max(grid ? 54 : 66, 7 * longest + 12) * scale;
      },
      values: (_plot, splits, _axis, _space, step) => tickLabels(splits, low ? splits[1] - splits[0] : step),
    },
  ];
}

// Returns where curves that the scale ignores lie outside, at most one place per few pixels.
function outside(plot, data) {
  const { min, max } = plot.scales.y;
  const [from, to] = [plot.scales.x.min, plot.scales.x.max];
  return data.series.flatMap(({ style, clipped }, i) => {
    if (!clipped || !plot.series[i + 1].show) return [];
    const last = { true: -Infinity, false: -Infinity };
    const places = [];
    plot.data[i + 1].forEach((y, k) => {
      const value = plot.data[0][k];
      if (y === null || (y <= max && y >= min) || value < from || value > to) return;
      const high = y > max;
      const at = plot.valToPos(value, "x");
      if (at - last[high] < 12 * scale) return;
      last[high] = at;
      places.push({ style, value, high });
    });
    return places;
  });
}

// Triangles at the edge show these places.
function markOutside(plot, data) {
  const { ctx, bbox } = plot;
  const size = 4 * scale * devicePixelRatio;
  for (const { style, value, high } of outside(plot, data)) {
    const x = plot.valToPos(value, "x", true);
    const [tip, base] = high
      ? [bbox.top, bbox.top + size]
      : [bbox.top + bbox.height, bbox.top + bbox.height - size];
    ctx.fillStyle = color(style);
    ctx.beginPath();
    ctx.moveTo(x, tip);
    ctx.lineTo(x - size, base);
    ctx.lineTo(x + size, base);
    ctx.fill();
  }
}

// Vertical lines with words beside them.
function markLines(plot, marks) {
  const { ctx, bbox } = plot;
  const unit = scale * devicePixelRatio;
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = color("second");
  ctx.lineWidth = unit;
  ctx.font = `${Math.round(11 * unit)}px ${getComputedStyle(document.body).fontFamily}`;
  ctx.textBaseline = "top";
  marks.forEach(({ at, text }, i) => {
    const x = plot.valToPos(at, "x", true);
    if (x < bbox.left || x > bbox.left + bbox.width) return;
    ctx.setLineDash([4 * unit, 3 * unit]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    const fits = x + ctx.measureText(text).width + 4 * unit < bbox.left + bbox.width;
    ctx.textAlign = fits ? "left" : "right";
    ctx.fillText(text, x + (fits ? 4 : -4) * unit, bbox.top + (2 + 13 * (i % 3)) * unit);
  });
  ctx.restore();
}

// The number of values on the vertical axis, for tests of the page.
function countTicks(plot, box) {
  box.dataset.ticks = plot.axes[1]._values.filter((text) => text !== "").length;
}

function plotOptions(figure, panel, size, last) {
  const [min, max] = figure.range ?? figure.whole;
  const hasCloud = panel.data.series.some(({ style }) => style === "cloud");
  const lines = panel.data.series.map(({ name, style, clipped }) => ({
    label: name,
    stroke: color(style),
    width: STYLES[style].width * scale,
    dash: STYLES[style].dash.map((length) => length * scale),
    // A curve beside points has values at a part of them only.
    spanGaps: hasCloud,
    ...(style === "cloud" ? { paths: () => null } : {}),
    points: { size: (style === "cloud" ? 3 : 4) * scale, width: scale, show: style === "cloud" || (hasCloud ? false : undefined) },
    auto: !clipped,
  }));
  return {
    ...size,
    padding: [8 * scale, 10 * scale, 0, 0],
    legend: { show: false },
    scales: { x: { time: false, distr: figure.data.logarithmic ? 3 : 1, min, max, range: () => figure.range ?? figure.whole }, y: { range: panel.data.isStrip ? stripRange : yRange } },
    axes: axisOptions(panel.data.isStrip ? "strip" : sizeOf(figure.data), last, figure.data.logarithmic),
    series: [{}, ...lines],
    cursor: {
      y: false,
      drag: { x: true, y: false, setScale: false },
      sync: { key: figure.key, filters: { pub: (type) => type === "mousemove" || type === "mouseleave" } },
      bind: { dblclick: () => () => zoom(figure, null) },
    },
    hooks: {
      draw: [
        (plot) => markOutside(plot, panel.data),
        (plot) => markLines(plot, panel.data.marks),
        (plot) => countTicks(plot, panel.box),
        () => figure.drawn.add(panel.data),
      ],
      setCursor: [() => showValues(figure, panel)],
      setSelect: [
        (plot) => {
          const { left, width } = plot.select;
          plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          if (width > 3) zoom(figure, [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")]);
        },
      ],
    },
  };
}

function legend(panel, named) {
  const box = element("div", { class: named ? "legend" : "legend values" });
  panel.data.series.forEach(({ name, style }, i) => {
    const output = element("output");
    panel.outputs.push(output);
    // A shared legend names the curves; the panel shows only their values at the cursor.
    if (!named) {
      output.style.color = `var(--${style})`;
      output.title = name;
      box.append(output);
      return;
    }
    box.append(toggle(name, style, output, [panel], i));
  });
  return box;
}

// A button that shows or hides a curve in some panels.
function toggle(name, style, output, panels, i) {
  const text = element("span", {}, name);
  const button = element("button", { type: "button", "aria-pressed": "true", title: name }, swatch(style), text, output);
  button.addEventListener("click", () => {
    const show = button.getAttribute("aria-pressed") !== "true";
    // A strip has no measured curve.
    for (const { plot, data } of panels) if (!data.isStrip || i > 0) plot.setSeries(data.isStrip ? i : i + 1, { show });
    button.setAttribute("aria-pressed", String(show));
  });
  return button;
}

const HEIGHTS = { stack: 165, half: 230, grid: 130, overview: 112, dense: 62, strip: 36 };

// An overview with more panels has low ones without labels of time.
const MOST_HIGH_PANELS = 8;

const sizeOf = ({ layout, panels }) => (layout === "overview" && panels.length > MOST_HIGH_PANELS ? "dense" : layout);

function panelSize(figure, panel, last) {
  const size = panel.data.isStrip ? "strip" : sizeOf(figure.data);
  const hasLabels = size === "stack" ? last : size !== "dense" && size !== "strip";
  const height = HEIGHTS[size] + (hasLabels ? 18 : 0);
  panel.box.style.setProperty("--height", `${height}px`);
  return { width: Math.max(panel.box.clientWidth, 120) * scale, height: height * scale };
}

function addPanel(figure, parent, data, last, named) {
  const panel = { data, outputs: [], last };
  const head = element("div", { class: "panel-head" }, element("h3", {}, data.y_label));
  if (data.note) head.append(element("span", { class: "note" }, data.note));
  head.append(legend(panel, named));
  const note = data.note ? ` (${data.note})` : "";
  const label = `${data.y_label}${note} over ${figure.data.x_label}: ${data.series.map((s) => s.name).join(", ")}`;
  panel.box = element("div", { role: "img", tabindex: "0", "aria-label": label });
  listenToKeys(figure, panel);
  figure.panels.push(panel);
  // A strip stands below its curve.
  if (data.isStrip) parent.lastChild.append(panel.box);
  else parent.append(element("div", { class: "panel" }, head, panel.box));
}

function plotPanel(figure, panel) {
  const { data, last } = panel;
  const values = [store.axes[data.axis], ...data.series.map((s) => s.values)];
  panel.plot = new uPlot(plotOptions(figure, panel, panelSize(figure, panel, last), last), values, panel.box);
  listenToTouch(figure, panel.plot.over);
}

function drawFigure(figure) {
  for (const { plot } of figure.panels) plot?.destroy();
  figure.panels = [];
  figure.drawn = new Set();
  figure.isDrawn = true;
  figure.position = element("span");
  const axis = figure.data.layout === "overview" ? `${figure.data.x_label}; ` : "";
  figure.hint = element("span", { class: "hint" }, axis + HINT);
  figure.reset = element("button", { type: "button", class: "reset" }, "show all");
  figure.reset.addEventListener("click", () => zoom(figure, null));
  figure.reset.hidden = figure.range === null;
  figure.hint.hidden = figure.range !== null;
  const bar = element("div", { class: "plot-bar" }, figure.position, figure.hint, figure.reset);
  const panels = element("div", { class: `panels ${sizeOf(figure.data)}` });
  figure.host.replaceChildren(bar);
  const all = panelsOf(figure.data);
  // Small panels that all show the same curves share one legend.
  const whole = all.filter((p) => !p.isStrip);
  const names = whole.map((p) => JSON.stringify(p.series.map((s) => [s.name, s.style])));
  const shared = figure.data.layout !== "stack" && names.length > 1 && new Set(names).size === 1;
  if (shared) {
    const keys = all[0].series.map((s, i) => toggle(s.name, s.style, "", figure.panels, i));
    bar.prepend(element("div", { class: "legend keys" }, ...keys));
  }
  figure.host.append(panels, element("p", { class: "x-label" }, figure.data.x_label));
  for (const data of all) addPanel(figure, panels, data, data === all.at(-1), !shared);
  // The width of a panel depends on the number of panels beside it.
  for (const panel of figure.panels) plotPanel(figure, panel);
}

function complain(host, error) {
  host.dataset.failed = "";
  host.replaceChildren(element("p", { class: "notice", role: "alert" }, `This figure cannot be drawn: ${error.message}`));
}

function draw(some) {
  for (const figure of some) {
    try {
      drawFigure(figure);
    } catch (error) {
      complain(figure.host, error);
    }
  }
  // uPlot draws after the running script has ended.
  setTimeout(() => {
    const good = figures.filter(({ host }) => !("failed" in host.dataset));
    const drawn = good.reduce((sum, figure) => sum + figure.drawn.size, 0);
    root.dataset.plotsDrawn = `${drawn}/${expected}`;
  }, 0);
}

// Draws the figures again that are drawn already.
const drawAgain = () => draw(figures.filter((figure) => figure.isDrawn));

// Draws the figures of the page that have a place and are not drawn yet.
const drawOpen = () => draw(figures.filter((figure) => !figure.isDrawn && figure.host.clientWidth > 0));

function resize(figure) {
  if (scale !== 1) return;
  for (const panel of figure.panels) {
    const size = panelSize(figure, panel, panel.last);
    if (panel.plot && size.width !== panel.plot.width) panel.plot.setSize(size);
  }
}

// Prepares all figures, and draws those near the visible part of the page. Others follow when the
// reader scrolls to them or opens their section.
function startPlots() {
  const hosts = [...document.querySelectorAll("[data-figure]")];
  expected = hosts.length;
  try {
    store = JSON.parse(document.getElementById("figure-data").textContent);
  } catch (error) {
    for (const host of hosts) complain(host, error);
    root.dataset.plotsDrawn = `0/${expected}`;
    return;
  }
  expected = store.figures.reduce((sum, data) => sum + countPanels(data), 0);
  for (const host of hosts) {
    const data = store.figures[Number(host.dataset.figure)];
    const key = `figure-${host.dataset.figure}`;
    figures.push({ host, data, key, whole: wholeRange(data), range: null, panels: [], drawn: new Set(), isDrawn: false });
  }
  const of = (target) => figures.find(({ host }) => host === target);
  const near = ({ host }) => host.clientWidth > 0 && host.getBoundingClientRect().top < innerHeight;
  draw(figures.filter(near));
  const arriving = new IntersectionObserver(
    (entries) => {
      const seen = entries.filter((entry) => entry.isIntersecting).map(({ target }) => of(target));
      const open = seen.filter((figure) => !figure.isDrawn);
      if (open.length) draw(open);
    },
    { rootMargin: "600px" },
  );
  // A change of the page inside the observer would call it again.
  const resizing = new ResizeObserver((entries) => {
    setTimeout(() => {
      for (const { target } of entries) resize(of(target));
    });
  });
  for (const { host } of figures) {
    arriving.observe(host);
    resizing.observe(host);
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAgain);
}
