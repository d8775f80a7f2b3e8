/* Draw every coordinate over time with the unsafe sets; of order 2, also the range of speeds and the tube of v + lambda x; of a
   running loop, also u and margin. */
const withoutUnit = (name) => name.replace(/ \[.*/, "");

/* Return groups of strips. A strip has a name, the edges of its band, dimension i, limits from and to, and a value `of` a row of
   the trace. */
function stripGroups() {
  const ends = (low, high, i) => {
    const [a, b] = [Math.min(...low.map((row) => row[i])), Math.max(...high.map((row) => row[i]))];
    return { from: a - 0.05 * (b - a), to: b + 0.05 * (b - a) };
  };
  const positions = data.axes.map((name, i) => ({ name, low: data.low, high: data.high, i, place: true, from: data.space[0][i], to: data.space[1][i], of: (row) => row.x[i] }));
  if (!data.filtered) return [positions];
  const { lambda, low, high } = data.filtered;
  const slow = low.map((row, k) => row.map((v, i) => v - lambda[i] * data.high[k][i]));
  const fast = high.map((row, k) => row.map((v, i) => v - lambda[i] * data.low[k][i]));
  const speeds = data.axes.map((name, i) => ({ name: `v, ${withoutUnit(name)}`, low: slow, high: fast, i, ...ends(slow, fast, i), of: (row) => row.v[i] }));
  const sums = data.axes.map((name, i) => ({ name: `v + ${formatNumber(lambda[i])} ${withoutUnit(name)}`, low, high, i, ...ends(low, high, i), of: (row) => row.v[i] + lambda[i] * row.x[i] }));
  return [positions, speeds, sums];
}

/* Draw all strips; return a function that shows time t and the running loop. */
function strips(figure) {
  figure.replaceChildren();
  const left = 58, right = 14, gap = 26, minimumColumnWidth = 380;
  const groups = stripGroups();
  const totalWidth = Math.max(figure.clientWidth, 240);
  const columns = Math.max(1, Math.min(groups.length, Math.floor(totalWidth / minimumColumnWidth)));
  const stripHeight = groups.length > 1 ? 96 : Math.max(84, Math.min(150, 420 / dimension));
  const columnWidth = totalWidth / columns, width = columnWidth - left - right;
  const inputStrips = [{ name: "u", of: (row) => row.u, driven: true }, { name: "margin", of: (row) => [row.margin], driven: true, from: -0.1, to: 0.55 }];
  const columnStrips = Array.from({ length: columns }, (_, c) => groups.filter((_, k) => k % columns === c).flat());
  const rows = Math.max(...columnStrips.map((list) => list.length));
  const placedStrips = columnStrips.flatMap((list, c) => list.map((row, r) => ({ ...row, c, r })));
  if (data.drive) placedStrips.push(...inputStrips.map((row, k) => ({ ...row, c: k % columns, r: rows + Math.floor(k / columns) })));
  const rowsWithInputs = Math.max(...placedStrips.map((row) => row.r)) + 1;
  const svg = addSvg(figure, "svg", { role: "img", "aria-label": "The edges of the tube over time" });
  const x = (t, c) => c * columnWidth + left + (t / data.t_c) * width;
  const timeMarks = [], traces = [];
  const inputGroup = addSvg(svg, "g", { hidden: "" });
  placedStrips.forEach((row, k) => {
    const top = 8 + row.r * (stripHeight + gap);
    const plotLeft = row.c * columnWidth + left, toX = (t) => x(t, row.c).toFixed(1);
    const group = row.driven ? inputGroup : svg;
    let [from, to] = [row.from ?? -1, row.to ?? 1];
    const y = (v) => top + ((to - v) / (to - from)) * stripHeight;
    if (!row.driven) {
      const edge = (list) => list.map((r, n) => `${toX((n / segmentCount) * data.t_c)},${y(r[row.i]).toFixed(1)}`);
      const clip = addSvg(addSvg(svg, "defs", {}), "clipPath", { id: `strip${k}` });
      addSvg(clip, "rect", { x: plotLeft, y: top, width, height: stripHeight });
      const scene = addSvg(svg, "g", { "clip-path": `url(#strip${k})` });
      addSvg(scene, "polygon", { class: "band", points: [...edge(row.high), ...edge(row.low).reverse()].join(" ") });
      if (row.place) {
        for (const obstacle of data.strips[row.i]) {
          const shape = addSvg(scene, "polygon", { class: obstacle.kept ? "separates-alone" : "may-be-unsafe", points: obstacle.outline.map(([t, v]) => `${toX(t)},${y(v).toFixed(1)}`).join(" ") });
          addSvg(shape, "title", {}, obstacle.name);
        }
        if (data.target) addSvg(scene, "line", { class: "target-edge", x1: x(data.t_c, row.c) - 2, x2: x(data.t_c, row.c) - 2, y1: y(data.target.span[0][row.i]), y2: y(data.target.span[1][row.i]) });
        addSvg(scene, "line", { class: "start-edge", x1: plotLeft + 2, x2: plotLeft + 2, y1: y(data.start[0][row.i]), y2: y(data.start[1][row.i]) });
      }
    }
    if (data.cycle) addSvg(group, "line", { class: "cycle-begin", x1: toX(data.cycle[0]), x2: toX(data.cycle[0]), y1: top, y2: top + stripHeight });
    addSvg(group, "rect", { class: "frame", x: plotLeft, y: top, width, height: stripHeight });
    const scaleTexts = addSvg(group, "g", {});
    const drawScale = () => { for (const v of ticks(from, to, Math.max(2, stripHeight / 22))) addSvg(scaleTexts, "text", { x: plotLeft - 6, y: y(v) + 4, "text-anchor": "end", class: "quiet" }, formatNumber(v)); };
    drawScale();
    const axisName = addSvg(group, "text", { transform: `translate(${plotLeft - left + 12} ${top + stripHeight / 2}) rotate(-90)`, "text-anchor": "middle" }, row.name);
    if (row.name.length > stripHeight / 7.5) axisName.setAttribute("class", "tight");
    timeMarks.push([addSvg(group, "line", { class: "time-mark", y1: top, y2: top + stripHeight }), row.c]);
    const lines = [];
    traces.push((run) => {
      const values = run.trace.map((r) => [row.of(r)].flat());
      if (row.driven && row.from === undefined) {
        const largestValue = Math.max(1e-9, ...values.flat().map(Math.abs));
        if (largestValue > to || largestValue < to / 4) {
          [from, to] = [-1.15 * largestValue, 1.15 * largestValue];
          scaleTexts.replaceChildren();
          drawScale();
        }
      }
      const lineCount = values.length ? values[0].length : 0;
      while (lines.length < lineCount) lines.push(addSvg(group, "polyline", { class: `trace of${lines.length % 4}` }));
      lines.forEach((line, n) => line.setAttribute("points", run.trace.map((r, m) => `${toX(r.t)},${Math.min(Math.max(y(values[m][n]), top), top + stripHeight).toFixed(1)}`).join(" ")));
    });
  });
  const timeAxis = addSvg(svg, "g", {});
  for (let c = 0; c < columns; c++) {
    for (const v of ticks(0, data.t_c, width / 50)) addSvg(timeAxis, "text", { x: x(v, c), y: 0, "text-anchor": "middle", class: "quiet" }, formatNumber(v));
    addSvg(timeAxis, "text", { x: x(data.t_c / 2, c), y: 18, "text-anchor": "middle" }, "t [s]");
  }
  return (t, run) => {
    const visibleRows = run ? rowsWithInputs : rows;
    svg.setAttribute("viewBox", `0 0 ${totalWidth} ${visibleRows * (stripHeight + gap) + 24}`);
    timeAxis.setAttribute("transform", `translate(0 ${visibleRows * (stripHeight + gap)})`);
    inputGroup.toggleAttribute("hidden", !run);
    for (const [mark, c] of timeMarks) for (const end of ["x1", "x2"]) mark.setAttribute(end, x(Math.min(t, data.t_c), c));
    for (const draw of traces) draw(run || { trace: [] });
  };
}
