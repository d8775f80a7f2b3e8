const FEW = 12; // sets whose names are drawn in three dimensions

/* Three dimensions, seen from a direction that the reader chooses. One painter, two pens: canvas on the screen, SVG on paper. */
function solid(figure) {
  figure.replaceChildren();
  const [lower, upper] = data.space;
  const size = upper.map((v, k) => v - lower[k]);
  const alike = new Set(data.units).size === 1;
  const unit = alike ? size.map(() => Math.max(...size)) : size;
  const width = Math.max(figure.clientWidth, 240), height = Math.min(width * 0.8, Math.max(300, 0.72 * window.innerHeight));
  const canvas = document.createElement("canvas");
  const fine = window.devicePixelRatio || 1;
  canvas.width = width * fine;
  canvas.height = height * fine;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", `The tube over ${data.axes.join(", ")}. Drag, or use the arrow keys, to turn it`);
  figure.appendChild(canvas);
  const paper = make(figure, "svg", { class: "paper", viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" });
  let turn = -0.6, tilt = 0.5, last = [0, null];

  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  let colours = {};
  function scheme() { for (const name of ["unsafe", "tube", "target", "region", "quiet", "ink"]) colours[name] = colour(name); }
  scheme();

  /* A point of the room on the picture, and how near it is. */
  let cos = [1, 1], sin = [0, 0], zoom = 1;
  function seen(p) {
    const [a, b, c] = p.map((v, k) => (v - (lower[k] + upper[k]) / 2) / unit[k]);
    const x = a * cos[0] - b * sin[0], away = a * sin[0] + b * cos[0];
    return [width / 2 + x * zoom, height / 2 - (c * cos[1] + away * sin[1]) * zoom, c * sin[1] - away * cos[1]];
  }
  const corners = (low, high) => [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((d) => ((k >> d) & 1 ? high[d] : low[d])));
  const SIDES = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];

  function canvasPen() {
    const context = canvas.getContext("2d");
    context.setTransform(fine, 0, 0, fine, 0, 0);
    context.clearRect(0, 0, width, height);
    context.lineJoin = "round";
    return {
      shape(list, name, fill, stroke, closed = true) {
        context.beginPath();
        list.forEach((p, k) => (k ? context.lineTo(p[0], p[1]) : context.moveTo(p[0], p[1])));
        if (closed) context.closePath();
        if (fill) { context.globalAlpha = fill; context.fillStyle = colours[name]; context.fill(); }
        if (stroke) { context.globalAlpha = stroke; context.strokeStyle = colours[name]; context.stroke(); }
        context.globalAlpha = 1;
      },
      text(p, told) { context.font = "12px system-ui, sans-serif"; context.textAlign = "center"; context.fillStyle = colours.ink; context.fillText(told, p[0], p[1]); },
    };
  }
  function paperPen() {
    paper.replaceChildren();
    return {
      shape(list, name, fill, stroke, closed = true) {
        const style = `fill:${fill ? `var(--${name})` : "none"};fill-opacity:${fill};stroke:${stroke ? `var(--${name})` : "none"};stroke-opacity:${stroke}`;
        make(paper, closed ? "polygon" : "polyline", { points: list.map((p) => `${p[0].toFixed(1)},${p[1].toFixed(1)}`).join(" "), style });
      },
      text(p, told) { make(paper, "text", { x: p[0], y: p[1], "text-anchor": "middle" }, told); },
    };
  }

  /* A convex body: the faces that look at the reader, on what is behind them. */
  function bodyOf(pen, list, faces, name, fill, stroke) {
    const flat = list.map(seen);
    const centre = flat.reduce((s, p) => s.map((v, k) => v + p[k]), [0, 0, 0]).map((v) => v / flat.length);
    for (const face of faces) {
      const f = face.map((k) => flat[k]);
      const mean = f.reduce((s, p) => s + p[2], 0) / f.length;
      if (mean > centre[2] - 1e-9) pen.shape(f, name, fill, stroke);
    }
  }
  const depth = (list) => list.reduce((s, p) => s + seen(p)[2], 0) / list.length;

  function paint(pen, t, run) {
    cos = [Math.cos(turn), Math.cos(tilt)];
    sin = [Math.sin(turn), Math.sin(tilt)];
    const [a, b, c] = size.map((v, k) => v / unit[k]);
    const wide = Math.hypot(a, b); // the room fits however it is turned
    zoom = Math.min((width - 90) / wide, (height - 50) / (c * Math.abs(cos[1]) + wide * Math.abs(sin[1])));
    const room = corners(lower, upper).map(seen);
    for (const side of SIDES) {
      const mean = side.reduce((s, k) => s + room[k][2], 0) / 4;
      if (mean < 0) pen.shape(side.map((k) => room[k]), "quiet", 0.04, 0.35);
    }
    const things = [], names = [];
    for (const set of data.sets) {
      if (!unsafe(set, t)) continue;
      const by = set.knots ? displaced(set.knots, t) : [0, 0, 0];
      const moved = set.solid.corners.map((p) => p.map((v, k) => v + by[k]));
      things.push([depth(moved), () => bodyOf(pen, moved, set.solid.faces, "unsafe", 0.32, 0.7)]);
      if (set.shell) {
        const shell = set.shell.corners.map((p) => p.map((v, k) => v + by[k]));
        things.push([depth(shell), () => bodyOf(pen, shell, set.shell.faces, "unsafe", 0.06, 0)]);
      }
      if (data.sets.length <= FEW) names.push([moved, set.name]);
    }
    const first = corners(data.start[0], data.start[1]);
    things.push([depth(first), () => bodyOf(pen, first, SIDES, "tube", 0, 0.8)]);
    for (const region of data.regions) if (data.regions.length <= FEW) names.push([region.solid.corners, region.name]);
    for (const region of data.regions) things.push([depth(region.solid.corners), () => bodyOf(pen, region.solid.corners, region.solid.faces, "region", 0.06, 0.7)]);
    for (let k = 0; k < 40; k++) {
      const when = (k / 40) * data.t_c;
      if (when > t) break;
      const list = corners(at(data.low, when), at(data.high, when));
      things.push([depth(list), () => bodyOf(pen, list, SIDES, "tube", 0.05, 0.12)]);
    }
    const [low, high] = [at(data.low, t), at(data.high, t)];
    const box = corners(low, high);
    things.push([depth(box), () => bodyOf(pen, box, SIDES, "tube", 0.3, 1)]);
    if (data.target) {
      const by = data.target.knots ? displaced(data.target.knots, t) : [0, 0, 0];
      const goal = corners(...data.target.span.map((edge) => edge.map((v, k) => v + by[k])));
      things.push([depth(goal), () => bodyOf(pen, goal, SIDES, "target", 0.05, 0.9)]);
    }
    things.sort((a, b) => a[0] - b[0]);
    for (const [, draw] of things) draw();
    const line = data.low.map((row, k) => seen(middle(row, data.high[k])));
    pen.shape(line, "tube", 0, 0.6, false);
    if (run) {
      pen.shape(run.trace.map((row) => seen(row.x)), "ink", 0, 0.9, false);
      const [px, py] = seen(run.x);
      pen.shape([0, 1, 2, 3, 4, 5, 6, 7].map((k) => [px + 6 * Math.cos((k * Math.PI) / 4), py + 6 * Math.sin((k * Math.PI) / 4)]), run.status ? "unsafe" : "ink", 1, 0);
    }
    const kept = [];
    for (const [list, name] of names) {
      const [x, y] = list.map(seen).reduce((s, p) => [s[0] + p[0], s[1] + p[1]], [0, 0]).map((v) => v / list.length);
      const half = 4 * name.length + 2;
      if (kept.some(([p, q, h]) => Math.abs(p - x) < h + half && Math.abs(q - y) < 16) || x < half || x > width - half) continue;
      kept.push([x, y, half]);
      pen.text([x, y], name);
    }
    const ends = [[upper[0], lower[1], lower[2]], [lower[0], upper[1], lower[2]], [lower[0], lower[1], upper[2]]];
    ends.forEach((p, k) => {
      const [a, b] = seen(p), [c, d] = seen(lower), away = Math.hypot(a - c, b - d) || 1;
      const x = Math.min(Math.max(a + (14 * (a - c)) / away, 40), width - 40), y = Math.min(Math.max(b + (14 * (b - d)) / away, 14), height - 6);
      pen.text([x, y], data.axes[k]);
    });
  }

  let asked = false;
  function again() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; paint(canvasPen(), ...last); });
  }
  const turned = (a, b) => { turn += a; tilt = Math.min(Math.max(tilt + b, -1.5), 1.5); again(); };
  let from = null;
  canvas.addEventListener("pointerdown", (event) => { from = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointermove", (event) => {
    if (!from) return;
    turned((event.clientX - from[0]) * 0.008, (event.clientY - from[1]) * 0.008);
    from = [event.clientX, event.clientY];
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { from = null; });
  canvas.addEventListener("keydown", (event) => {
    const way = { ArrowLeft: [-0.08, 0], ArrowRight: [0.08, 0], ArrowUp: [0, 0.08], ArrowDown: [0, -0.08] }[event.key];
    if (way) { event.preventDefault(); turned(...way); }
  });
  const print = () => paint(paperPen(), ...last);
  window.addEventListener("beforeprint", print);
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const recolour = () => { scheme(); again(); };
  dark.addEventListener("change", recolour);
  const show = (t, run) => { last = [t, run]; again(); };
  show.end = () => { window.removeEventListener("beforeprint", print); dark.removeEventListener("change", recolour); };
  return show;
}
