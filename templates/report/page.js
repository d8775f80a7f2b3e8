/* The page: its time, the views that show it, and the controls of "Drive it". */
const byId = (id) => document.getElementById(id);
const timeSlider = byId("time"), timeOutput = byId("now"), playButton = byId("play"), viewSelect = byId("plane"), nearestOutput = byId("near");
const SLIDER_STEPS = Number(timeSlider.max);
const chosenViews = [...(dimension === 3 ? [[0, 1, 2]] : []), ...data.planes]; // the dimensions of each view
let time = 0;
let views = [];
let loop = null; // stays null where no module runs
let driving = false;

const driver = data.drive ? createDriver(data.drive) : null;
const robotControl = driver && { hold: (where) => driver.hold(where), release: () => loop.release(), shove: (i, by) => driver.shove(i, by) };

/* Say how far the tube is from the nearest set at sample k, rounded down. */
function nearestText(k) {
  const [nearest, distance] = data.near[k];
  const { name, exact } = data.sets[nearest];
  const unit = data.units[0] ? ` ${data.units[0]}` : "";
  const body = data.body.some((v) => v > 0) ? ", the body in it," : "";
  const when = `At ${formatTime((k / segmentCount) * data.t_c)} s the tube${body}`;
  if (distance < 0) return `${when} ${exact && !data.sets[nearest].round ? "meets" : "may meet"} ${name}.`;
  return `${when} is at least ${formatNumber(roundDown(distance))}${unit} from every unsafe set; the nearest is ${name}.`;
}

function showTime(t) {
  time = t;
  timeSlider.value = String(Math.round((t / data.t_c) * SLIDER_STEPS));
  timeSlider.setAttribute("aria-valuetext", `${formatTime(t)} seconds`);
  timeOutput.textContent = `${formatTime(t)} s`;
  const k = Math.round((Math.min(t, data.t_c) / data.t_c) * segmentCount);
  if (nearestOutput) nearestOutput.textContent = data.near && data.near[k] ? nearestText(k) : "";
  const run = driving ? loop : null;
  for (const view of views) view(t, run);
}

/* Views are built for the width of the page, and again when that changes. */
const arenaFigure = byId("arena"), stripsFigure = byId("strips");
function buildViews() {
  if (loop) loop.release(); // because the dot that is held is removed
  for (const view of views) if (view.end) view.end();
  views = [];
  const chosen = chosenViews[Number(viewSelect.value || 0)];
  if (chosen) views.push(chosen.length === 3 ? solid(arenaFigure) : arena(arenaFigure, chosen, robotControl));
  views.push(strips(stripsFigure));
  showTime(time);
}
if (chosenViews.length) {
  chosenViews.forEach((axes, k) => viewSelect.add(new Option(axes.map((i) => data.axes[i]).join(", "), k)));
  byId("pair").hidden = chosenViews.length < 2;
  viewSelect.addEventListener("change", () => {
    buildViews();
    if (driver) driver.showLimits();
  });
} else arenaFigure.remove();
let lastWidth = 0;
new ResizeObserver(() => {
  const now = stripsFigure.clientWidth;
  if (Math.abs(now - lastWidth) < 2) return;
  lastWidth = now;
  buildViews();
}).observe(stripsFigure);

/* Playing moves the time by the clock, or runs the loop while it is driven. */
let lastStamp = null;
function animate(stamp) {
  if (lastStamp === null) return;
  const passed = Math.min(Math.max(stamp - lastStamp, 0) / 1000, 0.1);
  lastStamp = stamp;
  if (driving) driver.run(passed);
  else {
    let t = time + passed;
    if (t >= data.t_c && data.cycle) t -= data.cycle[1] - data.cycle[0];
    if (t >= data.t_c) {
      showTime(data.t_c);
      stopPlaying();
      return;
    }
    showTime(t);
  }
  requestAnimationFrame(animate);
}
function stopPlaying() {
  lastStamp = null;
  playButton.textContent = "Play";
  playButton.setAttribute("aria-pressed", "false");
}
function startPlaying() {
  if (!driving && time >= data.t_c) showTime(0);
  playButton.textContent = "Stop";
  playButton.setAttribute("aria-pressed", "true");
  lastStamp = performance.now();
  requestAnimationFrame(animate);
}
playButton.addEventListener("click", () => (lastStamp === null ? startPlaying() : stopPlaying()));
timeSlider.addEventListener("input", () => goTo((Number(timeSlider.value) / SLIDER_STEPS) * data.t_c));
function goTo(t) {
  if (driving) driver.begin(t);
  showTime(t);
}
for (const button of document.querySelectorAll("button.go-to-time")) {
  button.addEventListener("click", () => {
    stopPlaying();
    goTo(Number(button.dataset.time));
    byId("tube").scrollIntoView({ block: "start" });
  });
}
/* Paper shows the tube half way, if the page is at its beginning. */
let timeBeforePrint = null;
window.addEventListener("beforeprint", () => {
  if (time === 0 && !driving) {
    timeBeforePrint = time;
    showTime(data.t_c / 2);
  }
});
window.addEventListener("afterprint", () => {
  if (timeBeforePrint !== null) showTime(timeBeforePrint);
  timeBeforePrint = null;
});
const billData = byId("bill");
if (billData) {
  byId("save-bill").addEventListener("click", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([billData.textContent], { type: "application/json" }));
    link.download = `${data.name}.cdx.json`;
    link.click();
    URL.revokeObjectURL(link.href);
  });
}

/* Create the loop and connect the controls of "Drive it"; return its methods, or null where the browser cannot run it. */
function createDriver(setting) {
  const controls = byId("drive-controls");
  const driveElement = (name) => byId(`drive-${name}`);
  const proved = setting.proved;
  try { loop = createLoop(setting); } catch (error) {
    controls.remove();
    byId("drive-readings").hidden = false;
    byId("drive-readings").querySelector("dl").hidden = true;
    byId("drive-state").textContent = `This browser does not run it: ${error.message}`;
    return null;
  }
  const peakSpeed = data.low.slice(1).reduce((m, row, k) => row.reduce((s, v, i) => Math.max(s, Math.abs(v - data.low[k][i])), m), 0) * segmentCount / data.t_c;
  const sliderLimits = { wind: Math.max(3 * (proved ? proved.w : 0), 2 * peakSpeed), latency: Math.max(0.3, 4 * (proved ? proved.latency : 0)), noise: Math.max(4 * (proved ? proved.noise : 0), 0.2 * Math.max(...data.high[0].map((v, i) => v - data.low[0][i]))) };
  const samplingRate = () => 10 ** Number(driveElement("rate").value);
  driveElement("rate").min = String(Math.log10(5 / data.t_c));
  driveElement("rate").max = String(Math.log10(Math.max(2000, 2e4 / data.t_c, 10 / setting.period)));
  driveElement("rate").value = String(Math.log10(1 / setting.period));
  const currentConditions = () => ({
    period: 1 / samplingRate(),
    wind: sliderLimits.wind * Number(driveElement("wind").value) ** 2,
    latency: sliderLimits.latency * Number(driveElement("latency").value) ** 2,
    noise: sliderLimits.noise * Number(driveElement("noise").value) ** 2,
    kind: driveElement("kind").value,
    angle: (Number(driveElement("angle").value) * Math.PI) / 180,
    plane: (chosenViews[Number(viewSelect.value || 0)] || [0, 0]).slice(0, 2),
  });
  const unit = new Set(data.units).size === 1 && data.units[0] ? ` ${data.units[0]}` : "";
  const perTime = `${unit ? "/s" : " per s"}${setting.order === 2 ? "\u00b2" : ""}`;
  function showLimits() {
    const now = currentConditions();
    const exceeded = loop.exceededLimits(now);
    for (const name of ["rate", "wind", "latency", "noise"]) driveElement(name).closest("label").classList.toggle("beyond", name in exceeded);
    const provedLimit = (v, text) => (proved ? `, proved: ${text(v)}` : "");
    driveElement("rate-now").textContent = `${formatNumber(1 / now.period)} a second${proved ? `, proved: ${formatNumber(roundUp(1 / proved.period))} or more` : ""}`;
    driveElement("wind-now").textContent = `${formatNumber(now.wind)}${unit}${perTime}${provedLimit(proved && proved.w, (v) => `up to ${formatNumber(roundDown(v))}`)}`;
    driveElement("latency-now").textContent = `${formatNumber(now.latency * 1000)} ms${provedLimit(proved && proved.latency, (v) => `up to ${formatNumber(roundDown(v * 1000))}`)}`;
    const noiseUnit = setting.x_noise_ratio ? unit : ` of v, ${unit ? `${unit.trim()}/s` : "per s"}`;
    const noisiest = [setting.x_noise_ratio, setting.v_noise_ratio].some(Array.isArray) ? " on the noisiest axis" : "";
    driveElement("noise-now").textContent = `${formatNumber(now.noise)}${noiseUnit}${noisiest}${provedLimit(proved && proved.noise, (v) => `up to ${formatNumber(roundDown(v))}`)}`;
    const [i, j] = now.plane;
    driveElement("angle-now").textContent = dimension > 1 ? `${driveElement("angle").value}\u00b0 from ${withoutUnit(data.axes[i])} to ${withoutUnit(data.axes[j])}` : `${driveElement("angle").value}\u00b0`;
    driveElement("angle").closest("label").hidden = now.kind !== "constant";
    loop.arrow = 1 / (peakSpeed || 1) * 0.15 * Math.max(...data.space[1].map((v, i) => v - data.space[0][i]));
  }
  controls.addEventListener("input", showLimits);

  let pendingSeconds = 0;
  function showState() {
    const margin = byId("drive-margin");
    margin.value = Math.max(0, loop.margin);
    byId("drive-u").textContent = loop.u.map(formatNumber).join(", ");
    byId("drive-status").textContent = ["OK", "OUTSIDE_TUBE", "BAD_INPUT"][loop.status];
    byId("drive-share").textContent = `${formatNumber(loop.margin)} of the width`;
    byId("drive-state").textContent = loop.proved ? "Within what is proved." : `Beyond what is proved: ${loop.unprovedReason}.`;
    byId("drive-state").classList.toggle("beyond", !loop.proved);
    const [low, high] = [rowAt(data.low, time), rowAt(data.high, time)];
    const thrown = setting.order === 1 && loop.status === 1 && loop.u.some((u, i) => Math.abs(u) * currentConditions().period > high[i] - low[i]);
    byId("drive-hint").hidden = !thrown;
    const log = byId("drive-log");
    while (log.childNodes.length > loop.log.length) log.lastChild.remove();
    for (const [t, text] of loop.log.slice(log.childNodes.length)) log.appendChild(document.createElement("li")).textContent = `${formatTime(t)} s: ${text}`;
    showTime(loop.tubeTime());
  }
  const methods = {
    showLimits,
    begin(t) {
      pendingSeconds = 0;
      loop.begin(t);
      showState();
    },
    run(passed) {
      const now = currentConditions();
      pendingSeconds += passed * Number(driveElement("pace").value);
      let steps = 0;
      while (pendingSeconds >= now.period && !loop.lost && steps++ < 4000) {
        loop.step(now);
        pendingSeconds -= now.period;
      }
      if (steps >= 4000) pendingSeconds = 0;
      showState();
      if (loop.lost) stopPlaying();
    },
    hold(where) {
      loop.hold(where);
      if (lastStamp === null) showState();
    },
    shove(i, by) {
      loop.shove(i, by);
      if (lastStamp === null) {
        loop.step(currentConditions());
        showState();
      }
    },
  };
  function setDriving(on) {
    if (on === driving) return;
    driving = on;
    driveElement("on").textContent = on ? "Stop driving" : "Drive";
    byId("drive-readings").hidden = !on;
    if (on) methods.begin(time >= data.t_c ? 0 : time);
    else {
      stopPlaying();
      showTime(Math.min(time, data.t_c));
    }
  }
  driveElement("on").addEventListener("click", () => {
    setDriving(!driving);
    if (driving && lastStamp === null) startPlaying();
  });
  driveElement("step").addEventListener("click", () => {
    stopPlaying();
    setDriving(true);
    loop.step(currentConditions());
    showState();
  });
  driveElement("again").addEventListener("click", () => {
    if (!driving) {
      showTime(0);
      return;
    }
    methods.begin(0);
    if (lastStamp === null) startPlaying();
  });
  showLimits();
  return methods;
}
