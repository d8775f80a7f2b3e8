/* Every coordinate over time, with what it keeps off; of order 2 the tube of v + lambda x; of what is driven u and margin too. */
function strips(figure) {
  figure.replaceChildren();
  const left = 58, right = 14, gap = 26;
  const width = Math.max(figure.clientWidth, 240) - left - right;
  const rows = data.axes.map((name, i) => ({ name, low: data.low, high: data.high, i, from: data.space[0][i], to: data.space[1][i], of: (row) => row.x[i] }));
  if (data.filtered) {
    const most = (list, f) => list.reduce((m, row) => row.reduce((k, v) => f(k, v), m), f === Math.min ? Infinity : -Infinity);
    data.axes.forEach((name, i) => {
      const [a, b] = [most(data.filtered.low.map((r) => [r[i]]), Math.min), most(data.filtered.high.map((r) => [r[i]]), Math.max)];
      const lambda = data.filtered.lambda[i];
      const told = `v + ${short(lambda)} ${name.replace(/ \[.*/, "")}`;
      rows.push({ name: told, low: data.filtered.low, high: data.filtered.high, i, filtered: true, from: a - 0.05 * (b - a), to: b + 0.05 * (b - a), of: (row) => row.v[i] + lambda * row.x[i] });
    });
  }
  const driven = [{ name: "u", of: (row) => row.u, driven: true }, { name: "margin", of: (row) => [row.margin], driven: true, from: -0.1, to: 0.55 }];
  const all = data.drive ? [...rows, ...driven] : rows;
  const each = Math.max(78, Math.min(150, 420 / all.length));
  const svg = make(figure, "svg", { viewBox: `0 0 ${left + width + right} ${rows.length * (each + gap) + 24}`, role: "img", "aria-label": "The edges of the tube over time" });
  const x = (t) => left + (t / data.t_c) * width;
  const hands = [], traces = [];
  const extra = make(svg, "g", { hidden: "" });
  all.forEach((row, k) => {
    const top = 8 + k * (each + gap);
    const into = row.driven ? extra : svg;
    let [from, to] = [row.from ?? -1, row.to ?? 1];
    const y = (v) => top + ((to - v) / (to - from)) * each;
    if (!row.driven) {
      const edge = (list) => list.map((r, n) => `${x((n / samples) * data.t_c).toFixed(1)},${y(r[row.i]).toFixed(1)}`);
      const clip = make(make(svg, "defs", {}), "clipPath", { id: `strip${k}` });
      make(clip, "rect", { x: left, y: top, width, height: each });
      const scene = make(svg, "g", { "clip-path": `url(#strip${k})` });
      make(scene, "polygon", { class: "band", points: [...edge(row.high), ...edge(row.low).reverse()].join(" ") });
      if (!row.filtered) {
        for (const one of data.strips[row.i]) {
          const shape = make(scene, "polygon", { class: one.kept ? "kept" : "may", points: one.outline.map(([t, v]) => `${x(t).toFixed(1)},${y(v).toFixed(1)}`).join(" ") });
          make(shape, "title", {}, one.name);
        }
        if (data.target) make(scene, "line", { class: "goal", x1: x(data.t_c) - 2, x2: x(data.t_c) - 2, y1: y(data.target.span[0][row.i]), y2: y(data.target.span[1][row.i]) });
        make(scene, "line", { class: "begin", x1: left + 2, x2: left + 2, y1: y(data.start[0][row.i]), y2: y(data.start[1][row.i]) });
      }
    }
    if (data.cycle) make(into, "line", { class: "again", x1: x(data.cycle[0]), x2: x(data.cycle[0]), y1: top, y2: top + each });
    make(into, "rect", { class: "frame", x: left, y: top, width, height: each });
    const scales = make(into, "g", {});
    const scale = () => { for (const v of ticks(from, to, Math.max(2, each / 22))) make(scales, "text", { x: left - 6, y: y(v) + 4, "text-anchor": "end", class: "quiet" }, short(v)); };
    scale();
    const told = make(into, "text", { transform: `translate(12 ${top + each / 2}) rotate(-90)`, "text-anchor": "middle" }, row.name);
    if (row.name.length > each / 7) told.setAttribute("class", "tight");
    hands.push(make(into, "line", { class: "hand", y1: top, y2: top + each }));
    const lines = [];
    traces.push((run) => {
      const values = run.trace.map((r) => [row.of(r)].flat());
      if (row.driven && row.from === undefined) {
        const most = Math.max(1e-9, ...values.flat().map(Math.abs));
        if (most > to || most < to / 4) { [from, to] = [-1.15 * most, 1.15 * most]; scales.replaceChildren(); scale(); }
      }
      const wide = values.length ? values[0].length : 0;
      while (lines.length < wide) lines.push(make(into, "polyline", { class: `trace of${lines.length % 4}` }));
      lines.forEach((line, n) => line.setAttribute("points", run.trace.map((r, m) => `${x(r.t).toFixed(1)},${Math.min(Math.max(y(values[m][n]), top), top + each).toFixed(1)}`).join(" ")));
    });
  });
  const foot = make(svg, "g", {});
  for (const v of ticks(0, data.t_c, width / 50)) make(foot, "text", { x: x(v), y: 0, "text-anchor": "middle", class: "quiet" }, short(v));
  make(foot, "text", { x: left + width / 2, y: 18, "text-anchor": "middle" }, "t [s]");
  return (t, run) => {
    const shown = run ? all.length : rows.length;
    svg.setAttribute("viewBox", `0 0 ${left + width + right} ${shown * (each + gap) + 24}`);
    foot.setAttribute("transform", `translate(0 ${shown * (each + gap)})`);
    extra.toggleAttribute("hidden", !run);
    const here = x(Math.min(t, data.t_c));
    for (const hand of hands) { hand.setAttribute("x1", here); hand.setAttribute("x2", here); }
    const empty = { trace: [] };
    for (const draw of traces) draw(run || empty);
  };
}
