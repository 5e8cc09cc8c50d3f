// The moving arm: a view from the side that turns, and one from above.

// Size of a view and its margin, pixels.
const [WIDTH, HEIGHT, MARGIN_OF_VIEW] = [440, 340, 14];

// Angle from which the view from the side looks down, its first direction, and the turn of a key and of a pixel; rad.
const [LOOKS_DOWN, FIRST_TURN, KEY_TURN, DRAG_TURN] = [0.3, -0.6, 0.15, 0.01];

// Color, width and opacity of the parts of a view, the farthest first. Points are lines without length and with round ends.
const PARTS = {
  floor: ["rule", 1, 1],
  shadow: ["soft", 5, 0.25],
  path: ["first", 1, 0.5],
  links: ["ink", 4, 1],
  base: ["ink", 14, 1],
  joints: ["second", 9, 1],
  tool: ["first", 10, 1],
};
const BASE = [0, 0, 0];

// A view of an arm by parallel light.
class ArmView {
  constructor({ frames, floor, grid }, tilt, turn, words) {
    Object.assign(this, { frames, floor, grid, turn, parts: {}, sin: Math.sin(tilt), cos: Math.cos(tilt) });
    const all = [BASE, [0, 0, floor], ...frames.flat()];
    const [low, high] = [Math.min, Math.max].map((most) => most(...all.map(([, , z]) => z)));
    this.middle = (low + high) / 2;
    this.reach = Math.max(grid, ...all.map(([x, y]) => Math.hypot(x, y)));
    const tall = (high - low) * this.cos + 2 * this.reach * this.sin;
    this.scale = Math.min((WIDTH / 2 - MARGIN_OF_VIEW) / this.reach, (HEIGHT - 2 * MARGIN_OF_VIEW) / tall);
    this.svg = svgElement("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `Stick figure of the arm ${words}` });
    for (const [part, [name, width, opacity]] of Object.entries(PARTS)) {
      const line = { style: `stroke: var(--${name})`, "stroke-width": width, "stroke-opacity": String(opacity), "stroke-linecap": "round" };
      this.parts[part] = svgElement("path", { fill: "none", ...line });
      this.svg.append(this.parts[part]);
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
  const arm = { frames, floor, grid };
  const [first, last] = [time[0], time.at(-1)];
  const side = new ArmView(arm, LOOKS_DOWN, FIRST_TURN, "from the side; left and right keys turn it");
  const views = [side, new ArmView(arm, Math.PI / 2, 0, "from above")];
  const button = element("button", { type: "button" });
  const slider = element("input", { type: "range", min: first, max: last, step: "any", "aria-label": "time of the motion, s" });
  const output = element("output");
  const hint = element("span", {}, "drag the left view to turn it");
  host.append(element("div", { class: "skeleton-bar" }, button, slider, output, hint), element("div", { class: "views" }, ...views.map(({ svg }) => svg)));
  // The state: time, whether the reader wants motion and sees it, and the next picture of it.
  let [now, plays, isSeen, request] = [first, !matchMedia("(prefers-reduced-motion: reduce)").matches, false, 0];

  // Shows the arm at a time, between two frames.
  const show = (then) => {
    now = slider.value = then;
    output.textContent = `${then.toFixed(2)} s`;
    const after = Math.max(0, time.findIndex((t) => t >= then));
    const before = Math.max(0, after - 1);
    const part = after > before ? (then - time[before]) / (time[after] - time[before]) : 1;
    const between = frames[after].map((point, i) => point.map((x, k) => part * x + (1 - part) * frames[before][i][k]));
    for (const view of views) view.drawArm(between, parents);
  };
  // Goes on from the last picture; after its end the motion begins again.
  const step = (before) => {
    request = requestAnimationFrame((at) => {
      const then = now + (at - (before ?? at)) / 1000;
      show(then > last ? first : then);
      step(at);
    });
  };
  const turn = (angle) => {
    side.turn += angle;
    side.drawStill();
    show(now);
  };
  const play = (wanted) => {
    plays = wanted;
    button.textContent = plays ? "Pause" : "Play";
    cancelAnimationFrame(request);
    if (plays && isSeen) step();
  };
  button.addEventListener("click", () => play(!plays));
  slider.addEventListener("input", () => {
    play(false);
    show(Number(slider.value));
  });
  side.svg.setAttribute("tabindex", "0");
  side.svg.addEventListener("pointerdown", ({ pointerId }) => side.svg.setPointerCapture(pointerId));
  side.svg.addEventListener("pointermove", ({ pointerId, movementX }) => {
    if (side.svg.hasPointerCapture(pointerId)) turn(DRAG_TURN * movementX);
  });
  side.svg.addEventListener("keydown", (event) => {
    const sign = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0;
    if (sign) event.preventDefault();
    turn(sign * KEY_TURN);
  });
  views.forEach((view) => view.drawStill());
  show(first);
  new IntersectionObserver((entries) => {
    isSeen = entries.at(-1).isIntersecting;
    play(plays);
  }).observe(host);
}

document.querySelectorAll("[data-skeleton]").forEach((host, i) => store.skeletons?.[i] && startArm(host, store.skeletons[i]));
