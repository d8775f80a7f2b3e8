const SOLID_LABEL_LIMIT = 12; // sets or regions; a view of more in three dimensions has no names

/* Draw three dimensions from a direction that the reader turns; return a function that shows time t and the running loop.

   `paint` draws with a pen: one on a canvas for the screen, one in SVG for paper. */
function solid(figure) {
  figure.replaceChildren();
  const [lower, upper] = data.space;
  const size = upper.map((v, k) => v - lower[k]);
  const hasOneUnit = new Set(data.units).size === 1;
  const scaleUnit = hasOneUnit ? size.map(() => Math.max(...size)) : size;
  const width = Math.max(figure.clientWidth, 240), height = Math.min(width * 0.8, Math.max(300, 0.72 * window.innerHeight));
  const canvas = document.createElement("canvas");
  const pixelRatio = window.devicePixelRatio || 1;
  canvas.width = width * pixelRatio;
  canvas.height = height * pixelRatio;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", `The tube over ${data.axes.join(", ")}. Drag, or use the arrow keys, to turn it`);
  figure.appendChild(canvas);
  const paper = addSvg(figure, "svg", { class: "paper", viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" });
  let azimuth = -0.6, elevation = 0.5, lastShown = [0, null];

  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  let colours = {};
  function readColours() { for (const name of ["unsafe", "tube", "target", "region", "quiet", "ink"]) colours[name] = colour(name); }
  readColours();

  /* Project a point: its position in the picture, and how near it is. */
  let cos = [1, 1], sin = [0, 0], zoom = 1;
  function project(p) {
    const [a, b, c] = p.map((v, k) => (v - (lower[k] + upper[k]) / 2) / scaleUnit[k]);
    const x = a * cos[0] - b * sin[0], distance = a * sin[0] + b * cos[0];
    return [width / 2 + x * zoom, height / 2 - (c * cos[1] + distance * sin[1]) * zoom, c * sin[1] - distance * cos[1]];
  }
  const corners = (low, high) => [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((d) => ((k >> d) & 1 ? high[d] : low[d])));
  const SIDES = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];

  function canvasPen() {
    const context = canvas.getContext("2d");
    context.setTransform(pixelRatio, 0, 0, pixelRatio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.lineJoin = "round";
    return {
      shape(points, name, fill, stroke, closed = true) {
        context.beginPath();
        points.forEach((p, k) => (k ? context.lineTo(p[0], p[1]) : context.moveTo(p[0], p[1])));
        if (closed) context.closePath();
        if (fill) {
          context.globalAlpha = fill;
          context.fillStyle = colours[name];
          context.fill();
        }
        if (stroke) {
          context.globalAlpha = stroke;
          context.strokeStyle = colours[name];
          context.stroke();
        }
        context.globalAlpha = 1;
      },
      text(p, text) {
        context.font = "12px system-ui, sans-serif";
        context.textAlign = "center";
        context.fillStyle = colours.ink;
        context.fillText(text, p[0], p[1]);
      },
    };
  }
  function paperPen() {
    paper.replaceChildren();
    return {
      shape(points, name, fill, stroke, closed = true) {
        const style = `fill:${fill ? `var(--${name})` : "none"};fill-opacity:${fill};stroke:${stroke ? `var(--${name})` : "none"};stroke-opacity:${stroke}`;
        addSvg(paper, closed ? "polygon" : "polyline", { points: points.map((p) => `${p[0].toFixed(1)},${p[1].toFixed(1)}`).join(" "), style });
      },
      text(p, text) { addSvg(paper, "text", { x: p[0], y: p[1], "text-anchor": "middle" }, text); },
    };
  }

  /* Paint the faces of a convex body that face the reader. */
  function paintBody(pen, points, faces, name, fill, stroke) {
    const projected = points.map(project);
    const centre = projected.reduce((s, p) => s.map((v, k) => v + p[k]), [0, 0, 0]).map((v) => v / projected.length);
    for (const face of faces) {
      const f = face.map((k) => projected[k]);
      const mean = f.reduce((s, p) => s + p[2], 0) / f.length;
      if (mean > centre[2] - 1e-9) pen.shape(f, name, fill, stroke);
    }
  }
  const meanDepth = (points) => points.reduce((s, p) => s + project(p)[2], 0) / points.length;

  function paint(pen, t, run) {
    cos = [Math.cos(azimuth), Math.cos(elevation)];
    sin = [Math.sin(azimuth), Math.sin(elevation)];
    const [a, b, c] = size.map((v, k) => v / scaleUnit[k]);
    const diagonal = Math.hypot(a, b); // so that the state space fits in every direction
    zoom = Math.min((width - 90) / diagonal, (height - 50) / (c * Math.abs(cos[1]) + diagonal * Math.abs(sin[1])));
    const roomCorners = corners(lower, upper).map(project);
    for (const side of SIDES) {
      const mean = side.reduce((s, k) => s + roomCorners[k][2], 0) / 4;
      if (mean < 0) pen.shape(side.map((k) => roomCorners[k]), "quiet", 0.04, 0.35);
    }
    const bodies = [], names = [];
    for (const set of data.sets) {
      if (!isActive(set, t)) continue;
      const by = set.knots ? displacementAt(set.knots, t) : [0, 0, 0];
      const moved = set.solid.corners.map((p) => p.map((v, k) => v + by[k]));
      bodies.push([meanDepth(moved), () => paintBody(pen, moved, set.solid.faces, "unsafe", 0.32, 0.7)]);
      if (set.shell) {
        const shell = set.shell.corners.map((p) => p.map((v, k) => v + by[k]));
        bodies.push([meanDepth(shell), () => paintBody(pen, shell, set.shell.faces, "unsafe", 0.06, 0)]);
      }
      if (data.sets.length <= SOLID_LABEL_LIMIT) names.push([moved, set.name]);
    }
    const startCorners = corners(data.start[0], data.start[1]);
    bodies.push([meanDepth(startCorners), () => paintBody(pen, startCorners, SIDES, "tube", 0, 0.8)]);
    for (const region of data.regions) if (data.regions.length <= SOLID_LABEL_LIMIT) names.push([region.solid.corners, region.name]);
    for (const region of data.regions) bodies.push([meanDepth(region.solid.corners), () => paintBody(pen, region.solid.corners, region.solid.faces, "region", 0.06, 0.7)]);
    for (let k = 0; k < 40; k++) {
      const when = (k / 40) * data.t_c;
      if (when > t) break;
      const points = corners(rowAt(data.low, when), rowAt(data.high, when));
      bodies.push([meanDepth(points), () => paintBody(pen, points, SIDES, "tube", 0.05, 0.12)]);
    }
    const [low, high] = [rowAt(data.low, t), rowAt(data.high, t)];
    const tubeCorners = corners(low, high);
    bodies.push([meanDepth(tubeCorners), () => paintBody(pen, tubeCorners, SIDES, "tube", 0.3, 1)]);
    if (data.target) {
      const by = data.target.knots ? displacementAt(data.target.knots, t) : [0, 0, 0];
      const targetCorners = corners(...data.target.span.map((edge) => edge.map((v, k) => v + by[k])));
      bodies.push([meanDepth(targetCorners), () => paintBody(pen, targetCorners, SIDES, "target", 0.05, 0.9)]);
    }
    bodies.sort((a, b) => a[0] - b[0]);
    for (const [, draw] of bodies) draw();
    const line = data.low.map((row, k) => project(midpoint(row, data.high[k])));
    pen.shape(line, "tube", 0, 0.6, false);
    if (run) {
      pen.shape(run.trace.map((row) => project(row.x)), "ink", 0, 0.9, false);
      const [px, py] = project(run.x);
      pen.shape([0, 1, 2, 3, 4, 5, 6, 7].map((k) => [px + 6 * Math.cos((k * Math.PI) / 4), py + 6 * Math.sin((k * Math.PI) / 4)]), run.status ? "unsafe" : "ink", 1, 0);
    }
    const placedNames = [];
    for (const [points, name] of names) {
      const [x, y] = points.map(project).reduce((s, p) => [s[0] + p[0], s[1] + p[1]], [0, 0]).map((v) => v / points.length);
      const halfWidth = 4 * name.length + 2;
      if (placedNames.some(([p, q, h]) => Math.abs(p - x) < h + halfWidth && Math.abs(q - y) < 16) || x < halfWidth || x > width - halfWidth) continue;
      placedNames.push([x, y, halfWidth]);
      pen.text([x, y], name);
    }
    const ends = [[upper[0], lower[1], lower[2]], [lower[0], upper[1], lower[2]], [lower[0], lower[1], upper[2]]];
    ends.forEach((p, k) => {
      const [a, b] = project(p), [c, d] = project(lower), distance = Math.hypot(a - c, b - d) || 1;
      const x = Math.min(Math.max(a + (14 * (a - c)) / distance, 40), width - 40), y = Math.min(Math.max(b + (14 * (b - d)) / distance, 14), height - 6);
      pen.text([x, y], data.axes[k]);
    });
  }

  let isFrameRequested = false;
  function requestFrame() {
    if (isFrameRequested) return;
    isFrameRequested = true;
    requestAnimationFrame(() => {
      isFrameRequested = false;
      paint(canvasPen(), ...lastShown);
    });
  }
  const turnBy = (a, b) => {
    azimuth += a;
    elevation = Math.min(Math.max(elevation + b, -1.5), 1.5);
    requestFrame();
  };
  let dragStart = null;
  canvas.addEventListener("pointerdown", (event) => {
    dragStart = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!dragStart) return;
    turnBy((event.clientX - dragStart[0]) * 0.008, (event.clientY - dragStart[1]) * 0.008);
    dragStart = [event.clientX, event.clientY];
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { dragStart = null; });
  canvas.addEventListener("keydown", (event) => {
    const angles = { ArrowLeft: [-0.08, 0], ArrowRight: [0.08, 0], ArrowUp: [0, 0.08], ArrowDown: [0, -0.08] }[event.key];
    if (angles) {
      event.preventDefault();
      turnBy(...angles);
    }
  });
  const paintOnPaper = () => paint(paperPen(), ...lastShown);
  window.addEventListener("beforeprint", paintOnPaper);
  const darkScheme = window.matchMedia("(prefers-color-scheme: dark)");
  const onSchemeChange = () => {
    readColours();
    requestFrame();
  };
  darkScheme.addEventListener("change", onSchemeChange);
  // The page builds its views again when its width changes, as it does for paper: then nobody says again that it is printed.
  const paperMedia = window.matchMedia("print");
  const show = (t, run) => {
    lastShown = [t, run];
    requestFrame();
    if (paperMedia.matches) paintOnPaper();
  };
  show.end = () => {
    window.removeEventListener("beforeprint", paintOnPaper);
    darkScheme.removeEventListener("change", onSchemeChange);
  };
  return show;
}
