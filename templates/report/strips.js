/* Every coordinate over time, with what it keeps off; of order 2 the speed that the tubes leave and the tube of v + lambda x; of
   what is driven u and margin too. */
const bare = (name) => name.replace(/ \[.*/, "");

/* The strips by kind, each a list with what it is about and between which values it is drawn. */
function stripsOf() {
  const ends = (low, high, i) => {
    const [a, b] = [Math.min(...low.map((row) => row[i])), Math.max(...high.map((row) => row[i]))];
    return { from: a - 0.05 * (b - a), to: b + 0.05 * (b - a) };
  };
  const places = data.axes.map((name, i) => ({ name, low: data.low, high: data.high, i, place: true, from: data.space[0][i], to: data.space[1][i], of: (row) => row.x[i] }));
  if (!data.filtered) return [places];
  const { lambda, low, high } = data.filtered;
  const slow = low.map((row, k) => row.map((v, i) => v - lambda[i] * data.high[k][i]));
  const fast = high.map((row, k) => row.map((v, i) => v - lambda[i] * data.low[k][i]));
  const speeds = data.axes.map((name, i) => ({ name: `v, ${bare(name)}`, low: slow, high: fast, i, ...ends(slow, fast, i), of: (row) => row.v[i] }));
  const sums = data.axes.map((name, i) => ({ name: `v + ${short(lambda[i])} ${bare(name)}`, low, high, i, ...ends(low, high, i), of: (row) => row.v[i] + lambda[i] * row.x[i] }));
  return [places, speeds, sums];
}

function strips(figure) {
  figure.replaceChildren();
  const left = 58, right = 14, gap = 26, least = 380;
  const kinds = stripsOf();
  const whole = Math.max(figure.clientWidth, 240);
  const columns = Math.max(1, Math.min(kinds.length, Math.floor(whole / least)));
  const each = kinds.length > 1 ? 96 : Math.max(84, Math.min(150, 420 / count));
  const span = whole / columns, width = span - left - right;
  const driven = [{ name: "u", of: (row) => row.u, driven: true }, { name: "margin", of: (row) => [row.margin], driven: true, from: -0.1, to: 0.55 }];
  const filled = Array.from({ length: columns }, (_, c) => kinds.filter((_, k) => k % columns === c).flat());
  const rows = Math.max(...filled.map((list) => list.length));
  const all = filled.flatMap((list, c) => list.map((row, r) => ({ ...row, c, r })));
  if (data.drive) all.push(...driven.map((row, k) => ({ ...row, c: k % columns, r: rows + Math.floor(k / columns) })));
  const more = Math.max(...all.map((row) => row.r)) + 1;
  const svg = make(figure, "svg", { role: "img", "aria-label": "The edges of the tube over time" });
  const x = (t, c) => c * span + left + (t / data.t_c) * width;
  const hands = [], traces = [];
  const extra = make(svg, "g", { hidden: "" });
  all.forEach((row, k) => {
    const top = 8 + row.r * (each + gap);
    const begin = row.c * span + left, here = (t) => x(t, row.c).toFixed(1);
    const into = row.driven ? extra : svg;
    let [from, to] = [row.from ?? -1, row.to ?? 1];
    const y = (v) => top + ((to - v) / (to - from)) * each;
    if (!row.driven) {
      const edge = (list) => list.map((r, n) => `${here((n / samples) * data.t_c)},${y(r[row.i]).toFixed(1)}`);
      const clip = make(make(svg, "defs", {}), "clipPath", { id: `strip${k}` });
      make(clip, "rect", { x: begin, y: top, width, height: each });
      const scene = make(svg, "g", { "clip-path": `url(#strip${k})` });
      make(scene, "polygon", { class: "band", points: [...edge(row.high), ...edge(row.low).reverse()].join(" ") });
      if (row.place) {
        for (const one of data.strips[row.i]) {
          const shape = make(scene, "polygon", { class: one.kept ? "kept" : "may", points: one.outline.map(([t, v]) => `${here(t)},${y(v).toFixed(1)}`).join(" ") });
          make(shape, "title", {}, one.name);
        }
        if (data.target) make(scene, "line", { class: "goal", x1: x(data.t_c, row.c) - 2, x2: x(data.t_c, row.c) - 2, y1: y(data.target.span[0][row.i]), y2: y(data.target.span[1][row.i]) });
        make(scene, "line", { class: "begin", x1: begin + 2, x2: begin + 2, y1: y(data.start[0][row.i]), y2: y(data.start[1][row.i]) });
      }
    }
    if (data.cycle) make(into, "line", { class: "again", x1: here(data.cycle[0]), x2: here(data.cycle[0]), y1: top, y2: top + each });
    make(into, "rect", { class: "frame", x: begin, y: top, width, height: each });
    const scales = make(into, "g", {});
    const scale = () => { for (const v of ticks(from, to, Math.max(2, each / 22))) make(scales, "text", { x: begin - 6, y: y(v) + 4, "text-anchor": "end", class: "quiet" }, short(v)); };
    scale();
    const told = make(into, "text", { transform: `translate(${begin - left + 12} ${top + each / 2}) rotate(-90)`, "text-anchor": "middle" }, row.name);
    if (row.name.length > each / 7.5) told.setAttribute("class", "tight");
    hands.push([make(into, "line", { class: "hand", y1: top, y2: top + each }), row.c]);
    const lines = [];
    traces.push((run) => {
      const values = run.trace.map((r) => [row.of(r)].flat());
      if (row.driven && row.from === undefined) {
        const most = Math.max(1e-9, ...values.flat().map(Math.abs));
        if (most > to || most < to / 4) { [from, to] = [-1.15 * most, 1.15 * most]; scales.replaceChildren(); scale(); }
      }
      const wide = values.length ? values[0].length : 0;
      while (lines.length < wide) lines.push(make(into, "polyline", { class: `trace of${lines.length % 4}` }));
      lines.forEach((line, n) => line.setAttribute("points", run.trace.map((r, m) => `${here(r.t)},${Math.min(Math.max(y(values[m][n]), top), top + each).toFixed(1)}`).join(" ")));
    });
  });
  const foot = make(svg, "g", {});
  for (let c = 0; c < columns; c++) {
    for (const v of ticks(0, data.t_c, width / 50)) make(foot, "text", { x: x(v, c), y: 0, "text-anchor": "middle", class: "quiet" }, short(v));
    make(foot, "text", { x: x(data.t_c / 2, c), y: 18, "text-anchor": "middle" }, "t [s]");
  }
  return (t, run) => {
    const shown = run ? more : rows;
    svg.setAttribute("viewBox", `0 0 ${whole} ${shown * (each + gap) + 24}`);
    foot.setAttribute("transform", `translate(0 ${shown * (each + gap)})`);
    extra.toggleAttribute("hidden", !run);
    for (const [hand, c] of hands) for (const end of ["x1", "x2"]) hand.setAttribute(end, x(Math.min(t, data.t_c), c));
    for (const draw of traces) draw(run || { trace: [] });
  };
}
