"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const samples = data.low.length - 1;
  const SVG = "http://www.w3.org/2000/svg";
  const slider = document.getElementById("time");
  const output = document.getElementById("now");
  const play = document.getElementById("play");
  const select = document.getElementById("plane");
  const MANY = 40; // names are drawn up to so many sets

  function make(parent, kind, attributes, text) {
    const node = document.createElementNS(SVG, kind);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    if (text !== undefined) node.textContent = text;
    parent.appendChild(node);
    return node;
  }

  /* A value at a time, straight between two samples. */
  function at(values, t) {
    const place = Math.min(Math.max(t / data.t_c, 0), 1) * samples;
    const k = Math.min(Math.floor(place), samples - 1);
    return values[k].map((v, i) => v + (place - k) * (values[k + 1][i] - v));
  }

  /* Where a set is displaced to, and whether it is unsafe. */
  function displaced(set, t) {
    const knots = set.knots;
    let k = knots.findIndex((knot) => knot[0] >= t);
    if (k === -1) k = knots.length - 1;
    if (k === 0 || knots[k][0] < t) return knots[k].slice(1);
    const share = (t - knots[k - 1][0]) / (knots[k][0] - knots[k - 1][0]);
    return knots[k].slice(1).map((v, i) => knots[k - 1][i + 1] + share * (v - knots[k - 1][i + 1]));
  }

  function there(set, t) {
    return !set.window || (set.window[0] <= t && (t <= set.window[1] || set.window[1] >= data.t_c));
  }

  function ticks(low, high) {
    const step = 10 ** Math.floor(Math.log10((high - low) / 2));
    const coarse = [1, 2, 5, 10].map((m) => m * step).find((s) => (high - low) / s <= 6);
    const found = [];
    for (let v = Math.ceil(low / coarse - 1e-9) * coarse; v <= high + 1e-9 * coarse; v += coarse) found.push(Number(v.toPrecision(12)));
    return found;
  }

  /* One pair of axes from above. */
  function arena(figure, plane) {
    figure.replaceChildren();
    const [i, j] = plane;
    const key = plane.join(",");
    const wide = data.space[1][i] - data.space[0][i];
    const tall = data.space[1][j] - data.space[0][j];
    const left = 46, below = 38, size = 520;
    const scale = Math.min(size / wide, size / tall);
    const width = wide * scale, height = tall * scale;
    const svg = make(figure, "svg", { viewBox: `0 0 ${left + width + 12} ${height + below + 12}`, role: "img" });
    make(svg, "title", {}, `The tube over ${data.axes[i]} and ${data.axes[j]}`);
    const x = (v) => left + (v - data.space[0][i]) * scale;
    const y = (v) => 8 + (data.space[1][j] - v) * scale;
    const points = (outline) => outline.map(([a, b]) => `${x(a).toFixed(2)},${y(b).toFixed(2)}`).join(" ");
    const box = (low, high) => ({ x: x(low[i]), y: y(high[j]), width: Math.max((high[i] - low[i]) * scale, 0), height: Math.max((high[j] - low[j]) * scale, 0) });
    const clip = make(make(svg, "defs", {}), "clipPath", { id: "room" });
    make(clip, "rect", { x: left, y: 8, width, height });
    const inside = make(svg, "g", { "clip-path": "url(#room)" });
    const past = make(inside, "g", {});
    const drawn = data.sets.map((set) => {
      const group = make(inside, "g", {});
      if (set.grown) make(group, "polygon", { class: "grown", points: points(set.grown[key]) });
      make(group, "polygon", { class: "unsafe", points: points(set.outline[key]) });
      make(group, "title", {}, set.name);
      return [set, group];
    });
    for (const region of data.regions) make(inside, "polygon", { class: "region", points: points(region.outline[key]) });
    if (data.target[key]) make(inside, "polygon", { class: "target", points: points(data.target[key]) });
    make(inside, "rect", { class: "start", ...box(data.start[0], data.start[1]) });
    const centre = data.low.map((row, k) => [(row[i] + data.high[k][i]) / 2, (row[j] + data.high[k][j]) / 2]);
    make(inside, "polyline", { class: "way", points: points(centre) });
    const now = make(inside, "rect", { class: "now" });
    make(svg, "rect", { class: "frame", x: left, y: 8, width, height });
    for (const v of ticks(data.space[0][i], data.space[1][i])) make(svg, "text", { x: x(v), y: height + 24, "text-anchor": "middle", class: "quiet" }, v);
    for (const v of ticks(data.space[0][j], data.space[1][j])) make(svg, "text", { x: left - 6, y: y(v) + 4, "text-anchor": "end", class: "quiet" }, v);
    make(svg, "text", { x: left + width / 2, y: height + 42, "text-anchor": "middle" }, data.axes[i]);
    make(svg, "text", { transform: `translate(11 ${8 + height / 2}) rotate(-90)`, "text-anchor": "middle" }, data.axes[j]);
    const names = data.sets.length <= MANY ? data.sets : [];
    for (const set of [...names.filter((s) => !s.knots), ...data.regions]) {
      const middle = set.outline[key].reduce(([a, b], [c, d]) => [a + c, b + d], [0, 0]).map((v) => v / set.outline[key].length);
      make(inside, "text", { x: x(middle[0]), y: y(middle[1]) + 4, "text-anchor": "middle" }, set.name);
    }
    const numbers = new Map();
    for (const [entry, , begin] of data.visits) numbers.set(begin || 0, [...(numbers.get(begin || 0) || []), entry]);
    for (const [when, entries] of [...numbers].slice(0, MANY)) {
      const low = at(data.low, when), high = at(data.high, when);
      const mark = make(inside, "g", { class: "visit", transform: `translate(${x((low[i] + high[i]) / 2)} ${y((low[j] + high[j]) / 2)})` });
      const told = [...new Set(entries)].join(",");
      make(mark, "circle", { r: 7 + 2 * told.length });
      make(mark, "text", { y: 4, "text-anchor": "middle" }, told);
    }
    return (t) => {
      const low = at(data.low, t), high = at(data.high, t);
      for (const [name, value] of Object.entries(box(low, high))) now.setAttribute(name, value);
      const shown = Math.round((Math.min(t, data.t_c) / data.t_c) * 60);
      while (past.childNodes.length > shown) past.lastChild.remove();
      while (past.childNodes.length < shown) {
        const when = (past.childNodes.length / 60) * data.t_c;
        make(past, "rect", { class: "passed", ...box(at(data.low, when), at(data.high, when)) });
      }
      for (const [set, group] of drawn) {
        if (!set.knots) continue;
        const by = displaced(set, t);
        group.setAttribute("transform", `translate(${by[i] * scale} ${-by[j] * scale})`);
        group.setAttribute("opacity", there(set, t) ? 1 : 0.15);
      }
    };
  }

  /* Every coordinate over time. */
  function strips(figure) {
    figure.replaceChildren();
    const count = data.axes.length, left = 58, width = 640, each = Math.max(110, 330 / count), gap = 26;
    const svg = make(figure, "svg", { viewBox: `0 0 ${left + width + 14} ${count * (each + gap) + 22}`, role: "img" });
    make(svg, "title", {}, "The edges of the tube over time");
    const x = (t) => left + (t / data.t_c) * width;
    const hands = [];
    for (let i = 0; i < count; i++) {
      const top = 8 + i * (each + gap);
      const y = (v) => top + ((data.space[1][i] - v) / (data.space[1][i] - data.space[0][i])) * each;
      const upper = data.high.map((row, k) => `${x((k / samples) * data.t_c).toFixed(1)},${y(row[i]).toFixed(1)}`);
      const lower = data.low.map((row, k) => `${x((k / samples) * data.t_c).toFixed(1)},${y(row[i]).toFixed(1)}`).reverse();
      make(svg, "polygon", { class: "band", points: [...upper, ...lower].join(" ") });
      if (data.cycle) make(svg, "line", { class: "again", x1: x(data.cycle[0]), x2: x(data.cycle[0]), y1: top, y2: top + each });
      make(svg, "rect", { class: "frame", x: left, y: top, width, height: each });
      for (const v of ticks(data.space[0][i], data.space[1][i])) make(svg, "text", { x: left - 6, y: y(v) + 4, "text-anchor": "end", class: "quiet" }, v);
      make(svg, "text", { transform: `translate(12 ${top + each / 2}) rotate(-90)`, "text-anchor": "middle" }, data.axes[i]);
      hands.push(make(svg, "line", { class: "hand", y1: top, y2: top + each }));
    }
    const bottom = count * (each + gap);
    for (const v of ticks(0, data.t_c)) make(svg, "text", { x: x(v), y: bottom, "text-anchor": "middle", class: "quiet" }, v);
    make(svg, "text", { x: left + width / 2, y: bottom + 18, "text-anchor": "middle" }, "t [s]");
    return (t) => hands.forEach((hand) => { hand.setAttribute("x1", x(Math.min(t, data.t_c))); hand.setAttribute("x2", x(Math.min(t, data.t_c))); });
  }

  const moveHands = strips(document.getElementById("strips"));
  let moveTube = () => {};
  let time = 0;

  function show(t) {
    time = t;
    slider.value = String(Math.round((t / data.t_c) * 1000));
    slider.setAttribute("aria-valuetext", `${t.toFixed(2)} seconds`);
    output.textContent = `${t.toFixed(2)} s`;
    moveTube(t);
    moveHands(t);
  }

  function choose() {
    moveTube = arena(document.getElementById("arena"), data.planes[Number(select.value)]);
    show(time);
  }

  if (data.planes.length) {
    data.planes.forEach(([i, j], k) => select.add(new Option(`${data.axes[i]}, ${data.axes[j]}`, k)));
    document.getElementById("pair").hidden = data.planes.length < 2;
    select.addEventListener("change", choose);
    choose();
  } else {
    document.getElementById("arena").remove();
    show(0);
  }
  slider.addEventListener("input", () => show((Number(slider.value) / 1000) * data.t_c));
  for (const button of document.querySelectorAll("button.go")) {
    button.addEventListener("click", () => { show(Number(button.dataset.time)); slider.scrollIntoView({ block: "center" }); });
  }

  let last = null;
  function step(stamp) {
    if (last === null) return;
    let t = time + (stamp - last) / 1000;
    if (t >= data.t_c) {
      if (data.cycle) t -= data.cycle[1] - data.cycle[0];
      else { stop(); show(data.t_c); return; }
    }
    last = stamp;
    show(t);
    requestAnimationFrame(step);
  }
  function stop() {
    last = null;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  }
  play.addEventListener("click", () => {
    if (last !== null) { stop(); return; }
    if (time >= data.t_c) show(0);
    play.textContent = "Stop";
    play.setAttribute("aria-pressed", "true");
    last = performance.now();
    requestAnimationFrame(step);
  });
  show(0);
})();
