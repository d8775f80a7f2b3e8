/* The page: one time, the views that show it, and the loop that drives. */
const byId = (id) => document.getElementById(id);
const slider = byId("time"), output = byId("now"), play = byId("play"), select = byId("plane"), near = byId("near");
const STEPS = Number(slider.max);
const chosenViews = [...(count === 3 ? [[0, 1, 2]] : []), ...data.planes]; // the dimensions of each
let time = 0;
let views = [];
let loop = null; // where the C is there
let driving = false;

const drive = data.drive ? driver(data.drive) : null;
const hand = drive && { hold: (where) => drive.hold(where), release: () => loop.release(), shove: (i, by) => drive.shove(i, by) };

/* How far the tube is from the nearest set at the nearest sample, rounded down. */
function told(k) {
  const [nearest, far] = data.near[k];
  const { name, exact } = data.sets[nearest];
  const unit = data.units[0] ? ` ${data.units[0]}` : "";
  const body = data.body.some((v) => v > 0) ? ", the body in it," : "";
  const when = `At ${clock((k / samples) * data.t_c)} s the tube${body}`;
  if (far < 0) return `${when} ${exact && !data.sets[nearest].round ? "meets" : "may meet"} ${name}.`;
  return `${when} is at least ${short(down(far))}${unit} from every unsafe set; the nearest is ${name}.`;
}

function show(t) {
  time = t;
  slider.value = String(Math.round((t / data.t_c) * STEPS));
  slider.setAttribute("aria-valuetext", `${clock(t)} seconds`);
  output.textContent = `${clock(t)} s`;
  const k = Math.round((Math.min(t, data.t_c) / data.t_c) * samples);
  if (near) near.textContent = data.near && data.near[k] ? told(k) : "";
  const run = driving ? loop : null;
  for (const view of views) view(t, run);
}

/* Views are made for the width that there is, anew when that changes. */
const arenaFigure = byId("arena"), stripsFigure = byId("strips");
function build() {
  if (loop) loop.release(); // the dot that is held goes with its view
  for (const view of views) if (view.end) view.end();
  views = [];
  const chosen = chosenViews[Number(select.value || 0)];
  if (chosen) views.push(chosen.length === 3 ? solid(arenaFigure) : arena(arenaFigure, chosen, hand));
  views.push(strips(stripsFigure));
  show(time);
}
if (chosenViews.length) {
  chosenViews.forEach((axes, k) => select.add(new Option(axes.map((i) => data.axes[i]).join(", "), k)));
  byId("pair").hidden = chosenViews.length < 2;
  select.addEventListener("change", () => { build(); if (drive) drive.limits(); });
} else arenaFigure.remove();
let wide = 0;
new ResizeObserver(() => {
  const now = stripsFigure.clientWidth;
  if (Math.abs(now - wide) < 2) return;
  wide = now;
  build();
}).observe(stripsFigure);

/* Playing: the tube by the clock or, where something is driven, the loop. */
let last = null;
function step(stamp) {
  if (last === null) return;
  const passed = Math.min(Math.max(stamp - last, 0) / 1000, 0.1);
  last = stamp;
  if (driving) drive.run(passed);
  else {
    let t = time + passed;
    if (t >= data.t_c && data.cycle) t -= data.cycle[1] - data.cycle[0];
    if (t >= data.t_c) { show(data.t_c); stop(); return; }
    show(t);
  }
  requestAnimationFrame(step);
}
function stop() {
  last = null;
  play.textContent = "Play";
  play.setAttribute("aria-pressed", "false");
}
function start() {
  if (!driving && time >= data.t_c) show(0);
  play.textContent = "Stop";
  play.setAttribute("aria-pressed", "true");
  last = performance.now();
  requestAnimationFrame(step);
}
play.addEventListener("click", () => (last === null ? start() : stop()));
slider.addEventListener("input", () => go((Number(slider.value) / STEPS) * data.t_c));
function go(t) {
  if (driving) drive.begin(t);
  show(t);
}
for (const button of document.querySelectorAll("button.go")) {
  button.addEventListener("click", () => { stop(); go(Number(button.dataset.time)); byId("tube").scrollIntoView({ block: "start" }); });
}
/* On paper the tube is seen half way, where the reader is at its begin. */
let shown = null;
window.addEventListener("beforeprint", () => { if (time === 0 && !driving) { shown = time; show(data.t_c / 2); } });
window.addEventListener("afterprint", () => { if (shown !== null) show(shown); shown = null; });
const bill = byId("bill");
if (bill) {
  byId("save-bill").addEventListener("click", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([bill.textContent], { type: "application/json" }));
    link.download = `${data.name}.cdx.json`;
    link.click();
    URL.revokeObjectURL(link.href);
  });
}

/* The controls of "Drive it". */
function driver(setting) {
  const controls = byId("drive-controls");
  const field = (name) => byId(`drive-${name}`);
  const known = setting.proved;
  try { loop = loopOf(setting); } catch (error) {
    controls.remove();
    byId("drive-readings").hidden = false;
    byId("drive-readings").querySelector("dl").hidden = true;
    byId("drive-state").textContent = `This browser does not run it: ${error.message}`;
    return null;
  }
  const speed = data.low.slice(1).reduce((m, row, k) => row.reduce((s, v, i) => Math.max(s, Math.abs(v - data.low[k][i])), m), 0) * samples / data.t_c;
  const most = { wind: Math.max(3 * (known ? known.w : 0), 2 * speed), latency: Math.max(0.3, 4 * (known ? known.latency : 0)), noise: Math.max(4 * (known ? known.noise : 0), 0.2 * Math.max(...data.high[0].map((v, i) => v - data.low[0][i]))) };
  const rates = { value: () => 10 ** Number(field("rate").value) };
  field("rate").min = String(Math.log10(5 / data.t_c));
  field("rate").max = String(Math.log10(Math.max(2000, 2e4 / data.t_c, 10 / setting.period)));
  field("rate").value = String(Math.log10(1 / setting.period));
  const given = () => ({
    period: 1 / rates.value(),
    wind: most.wind * Number(field("wind").value) ** 2,
    latency: most.latency * Number(field("latency").value) ** 2,
    noise: most.noise * Number(field("noise").value) ** 2,
    kind: field("kind").value,
    angle: (Number(field("angle").value) * Math.PI) / 180,
    plane: (chosenViews[Number(select.value || 0)] || [0, 0]).slice(0, 2),
  });
  const unit = new Set(data.units).size === 1 && data.units[0] ? ` ${data.units[0]}` : "";
  const per = `${unit ? "/s" : " per s"}${setting.order === 2 ? "\u00b2" : ""}`;
  function limits() {
    const now = given();
    const beyond = loop.beyond(now);
    for (const name of ["rate", "wind", "latency", "noise"]) field(name).closest("label").classList.toggle("beyond", name in beyond);
    const limit = (v, text) => (known ? `, proved: ${text(v)}` : "");
    field("rate-now").textContent = `${short(1 / now.period)} a second${known ? `, proved: ${short(up(1 / known.period))} or more` : ""}`;
    field("wind-now").textContent = `${short(now.wind)}${unit}${per}${limit(known && known.w, (v) => `up to ${short(down(v))}`)}`;
    field("latency-now").textContent = `${short(now.latency * 1000)} ms${limit(known && known.latency, (v) => `up to ${short(down(v * 1000))}`)}`;
    field("noise-now").textContent = `${short(now.noise)}${unit}${limit(known && known.noise, (v) => `up to ${short(down(v))}`)}`;
    const [i, j] = now.plane;
    field("angle-now").textContent = count > 1 ? `${field("angle").value}\u00b0 from ${bare(data.axes[i])} to ${bare(data.axes[j])}` : `${field("angle").value}\u00b0`;
    field("angle").closest("label").hidden = now.kind !== "constant";
    loop.arrow = 1 / (speed || 1) * 0.15 * Math.max(...data.space[1].map((v, i) => v - data.space[0][i]));
  }
  controls.addEventListener("input", limits);

  let owed = 0;
  function state() {
    const margin = byId("drive-margin");
    margin.value = Math.max(0, loop.margin);
    byId("drive-u").textContent = loop.u.map(short).join(", ");
    byId("drive-status").textContent = ["OK", "OUTSIDE_TUBE", "BAD_INPUT"][loop.status];
    byId("drive-share").textContent = `${short(loop.margin)} of the width`;
    byId("drive-state").textContent = loop.proved ? "Within what is proved." : `Beyond what is proved: ${loop.broken}.`;
    byId("drive-state").classList.toggle("beyond", !loop.proved);
    const [low, high] = [at(data.low, time), at(data.high, time)];
    const thrown = setting.order === 1 && loop.status === 1 && loop.u.some((u, i) => Math.abs(u) * given().period > high[i] - low[i]);
    byId("drive-hint").hidden = !thrown;
    const log = byId("drive-log");
    while (log.childNodes.length > loop.log.length) log.lastChild.remove();
    for (const [t, text] of loop.log.slice(log.childNodes.length)) log.appendChild(document.createElement("li")).textContent = `${clock(t)} s: ${text}`;
    show(loop.tubeTime());
  }
  const api = {
    limits,
    begin(t) { owed = 0; loop.begin(t); state(); },
    run(passed) {
      const now = given();
      owed += passed * Number(field("pace").value);
      let steps = 0;
      while (owed >= now.period && !loop.lost && steps++ < 4000) { loop.step(now); owed -= now.period; }
      if (steps >= 4000) owed = 0;
      state();
      if (loop.lost) stop();
    },
    hold(where) { loop.hold(where); if (last === null) state(); },
    shove(i, by) { loop.shove(i, by); if (last === null) { loop.step(given()); state(); } },
  };
  function turn(on) {
    if (on === driving) return;
    driving = on;
    field("on").textContent = on ? "Stop driving" : "Drive";
    byId("drive-readings").hidden = !on;
    if (on) api.begin(time >= data.t_c ? 0 : time);
    else { stop(); show(Math.min(time, data.t_c)); }
  }
  field("on").addEventListener("click", () => {
    turn(!driving);
    if (driving && last === null) start();
  });
  field("step").addEventListener("click", () => {
    stop();
    turn(true);
    loop.step(given());
    state();
  });
  field("again").addEventListener("click", () => { if (driving) { api.begin(0); if (last === null) start(); } else show(0); });
  limits();
  return api;
}
