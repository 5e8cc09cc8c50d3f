// The moving arm: a view from the side that turns, and one from above.

// Width, height and margin of a view, pixels; its angle down, first direction, and turn of a key and of a pixel, rad.
const [WIDTH, HEIGHT, EDGE] = [440, 340, 14];
const [LOOKS_DOWN, FIRST_TURN, KEY_TURN, DRAG_TURN] = [0.3, -0.6, 0.15, 0.01];

// Color, width and opacity of the parts of a view, the farthest first. Points are lines without length, with round ends.
const PARTS = {
  floor: ["rule", 1, 1], shadow: ["soft", 5, 0.25], path: ["first", 1, 0.5], links: ["ink", 4, 1],
  base: ["ink", 14, 1], joints: ["second", 9, 1], tool: ["first", 10, 1],
};
const BASE = [0, 0, 0];

// A view by parallel light.
class ArmView {
  constructor({ frames, floor, grid }, tilt, turn, words) {
    Object.assign(this, { frames, floor, grid, turn, parts: {}, sin: Math.sin(tilt), cos: Math.cos(tilt) });
    const all = [BASE, [0, 0, floor], ...frames.flat()];
    const [low, high] = [Math.min, Math.max].map((most) => most(...all.map(([, , z]) => z)));
    this.middle = (low + high) / 2;
    this.reach = Math.max(grid, ...all.map(([x, y]) => Math.hypot(x, y)));
    const size = [2 * this.reach, (high - low) * this.cos + 2 * this.reach * this.sin];
    this.scale = Math.min((WIDTH - 2 * EDGE) / size[0], (HEIGHT - 2 * EDGE) / size[1]);
    this.svg = svgElement("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `Stick figure of the arm ${words}` });
    for (const [part, [name, width, opacity]] of Object.entries(PARTS)) {
      const line = { style: `stroke: var(--${name})`, "stroke-width": width, "stroke-opacity": String(opacity), "stroke-linecap": "round" };
      this.parts[part] = this.svg.appendChild(svgElement("path", { fill: "none", ...line }));
    }
  }

  at([x, y, z]) {
    const [c, s] = [Math.cos(this.turn), Math.sin(this.turn)];
    const up = (z - this.middle) * this.cos + (c * y - s * x) * this.sin;
    return `${rounded(WIDTH / 2 + this.scale * (c * x + s * y))} ${rounded(HEIGHT / 2 - this.scale * up)}`;
  }

  draw(part, lines) {
    this.parts[part].setAttribute("d", lines.map((points) => `M${points.map((point) => this.at(point)).join("L")}`).join(""));
  }

  // Draws a round floor of squares, and the path of the tool.
  drawStill() {
    const { reach, grid, floor } = this;
    const most = Math.floor(reach / grid);
    this.draw("floor", Array.from({ length: 2 * most + 1 }, (_, k) => (k - most) * grid).flatMap((at) => {
      const half = Math.sqrt(Math.max(0, reach * reach - at * at));
      return [[[at, -half, floor], [at, half, floor]], [[-half, at, floor], [half, at, floor]]];
    }));
    this.draw("path", [this.frames.map((points) => points.at(-1))]);
    this.draw("base", [[BASE, BASE]]);
  }

  drawArm(points, parents) {
    const links = points.map((point, i) => [points[parents[i]] ?? BASE, point]);
    const dots = points.map((point) => [point, point]);
    this.draw("shadow", links.map((ends) => ends.map(([x, y]) => [x, y, this.floor])));
    this.draw("links", links);
    this.draw("joints", dots.slice(0, -1));
    this.draw("tool", dots.slice(-1));
  }
}

function startArm(host, { unit, floor, grid, parents, time, points }) {
  const frames = points.map((flat) => parents.map((_, i) => flat.slice(3 * i, 3 * i + 3).map((x) => x * unit)));
  const view = (...how) => new ArmView({ frames, floor, grid }, ...how);
  const side = view(LOOKS_DOWN, FIRST_TURN, "from the side; left and right keys turn it");
  const views = [side, view(Math.PI / 2, 0, "from above")];
  const button = element("button", { type: "button" });
  const slider = element("input", { type: "range", min: time[0], max: time.at(-1), step: "any", "aria-label": "time of the motion, s" });
  const output = element("output");
  host.append(element("div", { class: "skeleton-bar" }, button, slider, output), element("div", { class: "views" }, ...views.map(({ svg }) => svg)));
  let [now, plays, isSeen, request] = [time[0], !matchMedia("(prefers-reduced-motion: reduce)").matches, false, 0];

  // Shows the arm at a time, between two frames.
  const show = (then) => {
    now = slider.value = then;
    output.textContent = `${then.toFixed(2)} s`;
    const after = Math.max(0, time.findIndex((t) => t >= then));
    const before = Math.max(0, after - 1);
    const part = after > before ? (then - time[before]) / (time[after] - time[before]) : 1;
    const between = frames[after].map((point, i) => point.map((x, k) => part * x + (1 - part) * frames[before][i][k]));
    for (const one of views) one.drawArm(between, parents);
  };
  // Goes on from the picture before; after its end the motion begins again.
  const step = (at, before = at) => {
    const then = now + (at - before) / 1000;
    show(then > time.at(-1) ? time[0] : then);
    request = requestAnimationFrame((next) => step(next, at));
  };
  const play = (wanted) => {
    plays = wanted;
    button.textContent = plays ? "Pause" : "Play";
    cancelAnimationFrame(request);
    if (plays && isSeen) request = requestAnimationFrame((at) => step(at));
  };
  const turn = (angle) => {
    side.turn += angle;
    side.drawStill();
    show(now);
  };
  button.addEventListener("click", () => play(!plays));
  slider.addEventListener("input", () => {
    play(false);
    show(Number(slider.value));
  });
  side.svg.setAttribute("tabindex", "0");
  side.svg.addEventListener("keydown", ({ key }) => turn(KEY_TURN * ((key === "ArrowRight") - (key === "ArrowLeft"))));
  side.svg.addEventListener("pointermove", ({ buttons, movementX }) => buttons && turn(DRAG_TURN * movementX));
  for (const one of views) one.drawStill();
  show(now);
  new IntersectionObserver((entries) => {
    isSeen = entries.at(-1).isIntersecting;
    play(plays);
  }).observe(host);
}

document.querySelectorAll("[data-skeleton]").forEach((host, i) => store.skeletons?.[i] && startArm(host, store.skeletons[i]));
