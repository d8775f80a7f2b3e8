/* Draw the state space in two axes; return a function that shows time t and the running loop.

   control: the methods hold, release and shove that move the robot; null where no module runs. */
function arena(figure, plane, control) {
  figure.replaceChildren();
  const [i, j] = plane;
  const key = plane.join(",");
  const [lower, upper] = data.space;
  const left = 48, below = 40, top = 8, right = 14;
  const available = Math.max(figure.clientWidth, 240) - left - right;
  const hasOneUnit = data.units[i] === data.units[j];
  const extentX = upper[i] - lower[i], extentY = upper[j] - lower[j];
  const heightLimit = Math.max(260, Math.min(0.72 * window.innerHeight, 860));
  const scale = Math.min(available / extentX, heightLimit / extentY);
  const [sx, sy] = hasOneUnit ? [scale, scale] : [available / extentX, Math.min(available, heightLimit) / extentY];
  const width = extentX * sx, height = extentY * sy;
  const svg = addSvg(figure, "svg", { viewBox: `0 0 ${left + width + right} ${top + height + below}`, role: "group" });
  svg.style.maxWidth = `${left + width + right}px`;
  svg.setAttribute("aria-label", `The tube over ${data.axes[i]} and ${data.axes[j]}`);
  const x = (v) => left + (v - lower[i]) * sx;
  const y = (v) => top + (upper[j] - v) * sy;
  const points = (outline) => outline.map(([a, b]) => `${x(a).toFixed(2)},${y(b).toFixed(2)}`).join(" ");
  const box = (low, high) => ({ x: x(low[i]), y: y(high[j]), width: Math.max((high[i] - low[i]) * sx, 0), height: Math.max((high[j] - low[j]) * sy, 0) });
  const centreOf = (outline) => outline.reduce(([p, q], [c, d]) => [p + c, q + d], [0, 0]).map((v) => v / outline.length);
  const setAttributes = (node, attributes) => { for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value); };

  const clip = addSvg(addSvg(svg, "defs", {}), "clipPath", { id: `room${key.replace(",", "-")}` });
  addSvg(clip, "rect", { x: left, y: top, width, height });
  const scene = addSvg(svg, "g", { "clip-path": `url(#room${key.replace(",", "-")})` });
  for (const wall of data.walls[key]) addSvg(scene, "polygon", { class: "wall", points: points(wall) });
  const passedBoxes = addSvg(scene, "g", {});
  const setShapes = data.sets.map((set) => {
    const uncertainOutline = isUncertain(set) ? addSvg(scene, "polygon", { class: "possible-outline" }) : null;
    const shape = addSvg(scene, "g", { "data-name": set.name });
    if (set.grown) addSvg(shape, "polygon", { class: "grown", points: points(set.grown[key]) });
    addSvg(shape, "polygon", { class: "unsafe", points: points(set.outline[key]) });
    if (set.knots && data.sets.length <= LABEL_LIMIT) {
      const [a, b] = centreOf(set.outline[key]);
      addSvg(shape, "text", { x: x(a), y: y(b) + 4, "text-anchor": "middle", class: "name" }, set.name);
    }
    return [set, shape, uncertainOutline];
  });
  for (const region of data.regions) addSvg(scene, "polygon", { class: "region", points: points(region.outline[key]), "data-name": region.name });
  const target = data.target ? addSvg(scene, "polygon", { class: "target", points: points(data.target.outline[key]) }) : null;
  addSvg(scene, "rect", { class: "start", ...box(data.start[0], data.start[1]) });
  const centreLine = data.low.map((row, k) => [(row[i] + data.high[k][i]) / 2, (row[j] + data.high[k][j]) / 2]);
  addSvg(scene, "polyline", { class: "centre-line", points: points(centreLine) });
  for (const [, from, dragTo] of data.meets) {
    const first = Math.floor((from / data.t_c) * segmentCount), last = Math.ceil((dragTo / data.t_c) * segmentCount);
    for (let k = first; k <= last; k += 3) addSvg(scene, "rect", { class: "overlap", ...box(data.low[k], data.high[k]) });
  }
  const currentBox = addSvg(scene, "rect", { class: "now" });
  const trace = addSvg(scene, "polyline", { class: "trace" });
  const body = data.body.some((v) => v > 0) ? addSvg(scene, "rect", { class: "body" }) : null;
  addSvg(svg, "rect", { class: "frame", x: left, y: top, width, height });
  for (const v of ticks(lower[i], upper[i], width / 60)) addSvg(svg, "text", { x: x(v), y: top + height + 16, "text-anchor": "middle", class: "quiet" }, formatNumber(v));
  for (const v of ticks(lower[j], upper[j], height / 40)) addSvg(svg, "text", { x: left - 6, y: y(v) + 4, "text-anchor": "end", class: "quiet" }, formatNumber(v));
  addSvg(svg, "text", { x: left + width / 2, y: top + height + 34, "text-anchor": "middle" }, data.axes[i]);
  addSvg(svg, "text", { transform: `translate(12 ${top + height / 2}) rotate(-90)`, "text-anchor": "middle" }, data.axes[j]);

  const labels = [];
  const addLabel = (outline, name, above = false) => {
    const [a, b] = centreOf(outline);
    const labelY = above ? y(Math.max(...outline.map((p) => p[1]))) + 14 : y(b) + 4;
    labels.push(addSvg(svg, "text", { x: x(a), y: labelY, "text-anchor": "middle", class: "name" }, name));
  };
  addLabel([[data.start[0][i], data.start[0][j]], [data.start[1][i], data.start[1][j]]], "start");
  if (data.target && !data.target.knots) addLabel(data.target.outline[key], "target");
  if (data.sets.length <= LABEL_LIMIT) for (const set of data.sets) if (!set.knots) addLabel(set.outline[key], set.name);
  if (data.regions.length <= LABEL_LIMIT) for (const region of data.regions) addLabel(region.outline[key], region.name, true);
  placeLabels(labels, left, top, left + width, top + height, visits());

  /* The name of the set under the pointer. */
  const hover = addSvg(svg, "text", { class: "name", "text-anchor": "middle" });
  svg.addEventListener("pointermove", (event) => {
    const name = event.target.closest("[data-name]")?.dataset.name || "";
    hover.textContent = name;
    if (!name) return;
    const [px, py] = toSvgCoordinates(event);
    setAttributes(hover, { x: px, y: py - 12 });
    placeLabels([hover], left, top, left + width, top + height);
    if (!hover.isConnected) svg.appendChild(hover);
  });

  function toSvgCoordinates(event) {
    const frame = svg.getBoundingClientRect();
    const per = (left + width + right) / frame.width;
    return [(event.clientX - frame.left) * per, (event.clientY - frame.top) * per];
  }

  /* Draw the numbers of the mission's entries where they are served; return their boxes. */
  function visits() {
    const numbers = new Map(), taken = [];
    for (const [entry, , begin] of data.visits) numbers.set(begin || 0, [...(numbers.get(begin || 0) || []), entry]);
    for (const [when, entries] of [...numbers].slice(0, LABEL_LIMIT)) {
      const [low, high] = [rowAt(data.low, when), rowAt(data.high, when)];
      const [cx, cy] = [x((low[i] + high[i]) / 2), y((low[j] + high[j]) / 2)];
      const numbersText = [...new Set(entries)].join(",");
      const r = 7 + 2 * numbersText.length;
      if (taken.some((o) => Math.hypot(o.left + o.right - 2 * cx, o.top + o.bottom - 2 * cy) < r + (o.right - o.left) / 2)) continue;
      const mark = addSvg(scene, "g", { class: "visit", transform: `translate(${cx} ${cy})` });
      addSvg(mark, "circle", { r });
      addSvg(mark, "text", { y: 4, "text-anchor": "middle" }, numbersText);
      taken.push({ left: cx - r, right: cx + r, top: cy - r, bottom: cy + r });
    }
    return taken;
  }

  /* The robot: a dot to drag, with a larger invisible handle; arrow keys shove it. */
  const robot = addSvg(svg, "g", { class: "robot", hidden: "" });
  const speedArrow = addSvg(robot, "line", { class: "speed-arrow" });
  const windArrow = addSvg(robot, "line", { class: "wind-arrow" });
  const handle = addSvg(robot, "circle", { class: "handle", r: 22 });
  addSvg(robot, "circle", { class: "dot", r: 6 });
  if (control) {
    setAttributes(handle, { tabindex: "0", role: "button", "aria-label": "The robot: drag it, or shove it with the arrow keys" });
    const dragTo = (event) => {
      const [px, py] = toSvgCoordinates(event);
      control.hold([[i, lower[i] + (px - left) / sx], [j, upper[j] - (py - top) / sy]]);
    };
    handle.addEventListener("pointerdown", (event) => {
      handle.setPointerCapture(event.pointerId);
      event.preventDefault();
      handle.focus({ preventScroll: true });
      dragTo(event);
    });
    handle.addEventListener("pointermove", (event) => { if (handle.hasPointerCapture(event.pointerId)) dragTo(event); });
    for (const end of ["pointerup", "pointercancel"]) handle.addEventListener(end, () => control.release());
    handle.addEventListener("keydown", (event) => {
      const direction = { ArrowLeft: [i, -1], ArrowRight: [i, 1], ArrowUp: [j, 1], ArrowDown: [j, -1] }[event.key];
      if (!direction) return;
      event.preventDefault();
      control.shove(direction[0], direction[1] * 0.01 * (upper[direction[0]] - lower[direction[0]]));
    });
  }

  return (t, run) => {
    const [low, high] = [rowAt(data.low, t), rowAt(data.high, t)];
    setAttributes(currentBox, box(low, high));
    const passedCount = Math.round((Math.min(t, data.t_c) / data.t_c) * 60);
    while (passedBoxes.childNodes.length > passedCount) passedBoxes.lastChild.remove();
    while (passedBoxes.childNodes.length < passedCount) {
      const when = (passedBoxes.childNodes.length / 60) * data.t_c;
      addSvg(passedBoxes, "rect", { class: "passed", ...box(rowAt(data.low, when), rowAt(data.high, when)) });
    }
    for (const [set, shape, uncertainOutline] of setShapes) {
      if (!set.knots) continue;
      const displacement = displacementAt(set.knots, t);
      shape.setAttribute("transform", `translate(${(displacement[i] * sx).toFixed(2)} ${(-displacement[j] * sy).toFixed(2)})`);
      shape.setAttribute("opacity", isActive(set, t) ? 1 : 0.15);
      if (uncertainOutline) uncertainOutline.setAttribute("points", possibleDisplacements(set, t).length ? points(possibleOutline(set, key, plane, t)) : "");
    }
    if (target && data.target.knots) {
      const displacement = displacementAt(data.target.knots, t);
      target.setAttribute("transform", `translate(${displacement[i] * sx} ${-displacement[j] * sy})`);
    }
    const state = run ? run.x : midpoint(low, high);
    if (body) setAttributes(body, { x: x(state[i] - data.body[i]), y: y(state[j] + data.body[j]), width: 2 * data.body[i] * sx, height: 2 * data.body[j] * sy });
    robot.toggleAttribute("hidden", !run);
    if (!run) {
      trace.setAttribute("points", "");
      return;
    }
    robot.setAttribute("transform", `translate(${x(state[i]).toFixed(2)} ${y(state[j]).toFixed(2)})`);
    robot.classList.toggle("out", run.status !== 0);
    trace.setAttribute("points", points(run.trace.map((row) => [row.x[i], row.x[j]])));
    const arrow = (line, vector, size) => setAttributes(line, { x1: 0, y1: 0, x2: (vector[i] * size * sx).toFixed(2), y2: (-vector[j] * size * sy).toFixed(2) });
    arrow(windArrow, run.w, run.arrow);
    arrow(speedArrow, run.v || run.w.map(() => 0), 0.5);
  };
}
