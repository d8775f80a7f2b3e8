/* One pair of axes from above. hand: what drags the robot, (dimension, value) pairs; null where nothing is driven. */
function arena(figure, plane, hand) {
  figure.replaceChildren();
  const [i, j] = plane;
  const key = plane.join(",");
  const [lower, upper] = data.space;
  const left = 48, below = 40, top = 8, right = 14;
  const room = Math.max(figure.clientWidth, 240) - left - right;
  const alike = data.units[i] === data.units[j];
  const wide = upper[i] - lower[i], tall = upper[j] - lower[j];
  const most = Math.max(260, Math.min(0.72 * window.innerHeight, 860));
  const scale = Math.min(room / wide, most / tall);
  const [sx, sy] = alike ? [scale, scale] : [room / wide, Math.min(room, most) / tall];
  const width = wide * sx, height = tall * sy;
  const svg = make(figure, "svg", { viewBox: `0 0 ${left + width + right} ${top + height + below}`, role: "group" });
  svg.style.maxWidth = `${left + width + right}px`;
  svg.setAttribute("aria-label", `The tube over ${data.axes[i]} and ${data.axes[j]}`);
  const x = (v) => left + (v - lower[i]) * sx;
  const y = (v) => top + (upper[j] - v) * sy;
  const points = (outline) => outline.map(([a, b]) => `${x(a).toFixed(2)},${y(b).toFixed(2)}`).join(" ");
  const box = (low, high) => ({ x: x(low[i]), y: y(high[j]), width: Math.max((high[i] - low[i]) * sx, 0), height: Math.max((high[j] - low[j]) * sy, 0) });
  const centreOf = (outline) => outline.reduce(([p, q], [c, d]) => [p + c, q + d], [0, 0]).map((v) => v / outline.length);
  const put = (node, attributes) => { for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value); };

  const clip = make(make(svg, "defs", {}), "clipPath", { id: `room${key.replace(",", "-")}` });
  make(clip, "rect", { x: left, y: top, width, height });
  const scene = make(svg, "g", { "clip-path": `url(#room${key.replace(",", "-")})` });
  for (const wall of data.walls[key]) make(scene, "polygon", { class: "wall", points: points(wall) });
  const past = make(scene, "g", {});
  const drawn = data.sets.map((set) => {
    const may = doubtful(set) ? make(scene, "polygon", { class: "maybe" }) : null;
    const group = make(scene, "g", { "data-name": set.name });
    if (set.grown) make(group, "polygon", { class: "grown", points: points(set.grown[key]) });
    make(group, "polygon", { class: "unsafe", points: points(set.outline[key]) });
    if (set.knots && data.sets.length <= MANY) {
      const [a, b] = centreOf(set.outline[key]);
      make(group, "text", { x: x(a), y: y(b) + 4, "text-anchor": "middle", class: "name" }, set.name);
    }
    return [set, group, may];
  });
  for (const region of data.regions) make(scene, "polygon", { class: "region", points: points(region.outline[key]), "data-name": region.name });
  const target = data.target ? make(scene, "polygon", { class: "target", points: points(data.target.outline[key]) }) : null;
  make(scene, "rect", { class: "start", ...box(data.start[0], data.start[1]) });
  const centre = data.low.map((row, k) => [(row[i] + data.high[k][i]) / 2, (row[j] + data.high[k][j]) / 2]);
  make(scene, "polyline", { class: "way", points: points(centre) });
  for (const [, from, to] of data.meets) {
    const first = Math.floor((from / data.t_c) * samples), last = Math.ceil((to / data.t_c) * samples);
    for (let k = first; k <= last; k += 3) make(scene, "rect", { class: "hit", ...box(data.low[k], data.high[k]) });
  }
  const now = make(scene, "rect", { class: "now" });
  const trace = make(scene, "polyline", { class: "trace" });
  const body = data.body.some((v) => v > 0) ? make(scene, "rect", { class: "body" }) : null;
  make(svg, "rect", { class: "frame", x: left, y: top, width, height });
  for (const v of ticks(lower[i], upper[i], width / 60)) make(svg, "text", { x: x(v), y: top + height + 16, "text-anchor": "middle", class: "quiet" }, short(v));
  for (const v of ticks(lower[j], upper[j], height / 40)) make(svg, "text", { x: left - 6, y: y(v) + 4, "text-anchor": "end", class: "quiet" }, short(v));
  make(svg, "text", { x: left + width / 2, y: top + height + 34, "text-anchor": "middle" }, data.axes[i]);
  make(svg, "text", { transform: `translate(12 ${top + height / 2}) rotate(-90)`, "text-anchor": "middle" }, data.axes[j]);

  const labels = [];
  const named = (outline, name, above = false) => {
    const [a, b] = centreOf(outline);
    const place = above ? y(Math.max(...outline.map((p) => p[1]))) + 14 : y(b) + 4;
    labels.push(make(svg, "text", { x: x(a), y: place, "text-anchor": "middle", class: "name" }, name));
  };
  named([[data.start[0][i], data.start[0][j]], [data.start[1][i], data.start[1][j]]], "start");
  if (data.target && !data.target.knots) named(data.target.outline[key], "target");
  if (data.sets.length <= MANY) for (const set of data.sets) if (!set.knots) named(set.outline[key], set.name);
  if (data.regions.length <= MANY) for (const region of data.regions) named(region.outline[key], region.name, true);
  settle(labels, left, top, left + width, top + height, visits());

  /* The name of the set under the pointer, where names have no room. */
  const hover = make(svg, "text", { class: "name", "text-anchor": "middle" });
  svg.addEventListener("pointermove", (event) => {
    const name = event.target.closest("[data-name]")?.dataset.name || "";
    hover.textContent = name;
    if (!name) return;
    const [px, py] = local(event);
    put(hover, { x: px, y: py - 12 });
    settle([hover], left, top, left + width, top + height);
    if (!hover.isConnected) svg.appendChild(hover);
  });

  function local(event) {
    const frame = svg.getBoundingClientRect();
    const per = (left + width + right) / frame.width;
    return [(event.clientX - frame.left) * per, (event.clientY - frame.top) * per];
  }

  /* The numbers of the mission's entries where they are served, and the room that they take. */
  function visits() {
    const numbers = new Map(), taken = [];
    for (const [entry, , begin] of data.visits) numbers.set(begin || 0, [...(numbers.get(begin || 0) || []), entry]);
    for (const [when, entries] of [...numbers].slice(0, MANY)) {
      const [low, high] = [at(data.low, when), at(data.high, when)];
      const [cx, cy] = [x((low[i] + high[i]) / 2), y((low[j] + high[j]) / 2)];
      const told = [...new Set(entries)].join(",");
      const r = 7 + 2 * told.length;
      if (taken.some((o) => Math.hypot(o.left + o.right - 2 * cx, o.top + o.bottom - 2 * cy) < r + (o.right - o.left) / 2)) continue;
      const mark = make(scene, "g", { class: "visit", transform: `translate(${cx} ${cy})` });
      make(mark, "circle", { r });
      make(mark, "text", { y: 4, "text-anchor": "middle" }, told);
      taken.push({ left: cx - r, right: cx + r, top: cy - r, bottom: cy + r });
    }
    return taken;
  }

  /* The robot: a dot to drag, larger to the finger than to the eye; arrow keys shove it. */
  const robot = make(svg, "g", { class: "robot", hidden: "" });
  const speed = make(robot, "line", { class: "speed" });
  const push = make(robot, "line", { class: "push" });
  const grip = make(robot, "circle", { class: "grip", r: 22 });
  make(robot, "circle", { class: "dot", r: 6 });
  if (hand) {
    put(grip, { tabindex: "0", role: "button", "aria-label": "The robot: drag it, or shove it with the arrow keys" });
    const to = (event) => {
      const [px, py] = local(event);
      hand.hold([[i, lower[i] + (px - left) / sx], [j, upper[j] - (py - top) / sy]]);
    };
    grip.addEventListener("pointerdown", (event) => { grip.setPointerCapture(event.pointerId); event.preventDefault(); grip.focus({ preventScroll: true }); to(event); });
    grip.addEventListener("pointermove", (event) => { if (grip.hasPointerCapture(event.pointerId)) to(event); });
    for (const end of ["pointerup", "pointercancel"]) grip.addEventListener(end, () => hand.release());
    grip.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: [i, -1], ArrowRight: [i, 1], ArrowUp: [j, 1], ArrowDown: [j, -1] }[event.key];
      if (!way) return;
      event.preventDefault();
      hand.shove(way[0], way[1] * 0.01 * (upper[way[0]] - lower[way[0]]));
    });
  }

  return (t, run) => {
    const [low, high] = [at(data.low, t), at(data.high, t)];
    put(now, box(low, high));
    const shown = Math.round((Math.min(t, data.t_c) / data.t_c) * 60);
    while (past.childNodes.length > shown) past.lastChild.remove();
    while (past.childNodes.length < shown) {
      const when = (past.childNodes.length / 60) * data.t_c;
      make(past, "rect", { class: "passed", ...box(at(data.low, when), at(data.high, when)) });
    }
    for (const [set, group, may] of drawn) {
      if (!set.knots) continue;
      const by = displaced(set.knots, t);
      group.setAttribute("transform", `translate(${(by[i] * sx).toFixed(2)} ${(-by[j] * sy).toFixed(2)})`);
      group.setAttribute("opacity", unsafe(set, t) ? 1 : 0.15);
      if (may) may.setAttribute("points", places(set, t).length ? points(swept(set, key, plane, t)) : "");
    }
    if (target && data.target.knots) {
      const by = displaced(data.target.knots, t);
      target.setAttribute("transform", `translate(${by[i] * sx} ${-by[j] * sy})`);
    }
    const place = run ? run.x : middle(low, high);
    if (body) put(body, { x: x(place[i] - data.body[i]), y: y(place[j] + data.body[j]), width: 2 * data.body[i] * sx, height: 2 * data.body[j] * sy });
    robot.toggleAttribute("hidden", !run);
    if (!run) { trace.setAttribute("points", ""); return; }
    robot.setAttribute("transform", `translate(${x(place[i]).toFixed(2)} ${y(place[j]).toFixed(2)})`);
    robot.classList.toggle("out", run.status !== 0);
    trace.setAttribute("points", points(run.trace.map((row) => [row.x[i], row.x[j]])));
    const arrow = (line, vector, size) => put(line, { x1: 0, y1: 0, x2: (vector[i] * size * sx).toFixed(2), y2: (-vector[j] * size * sy).toFixed(2) });
    arrow(push, run.w, run.arrow);
    arrow(speed, run.v || run.w.map(() => 0), 0.5);
  };
}
