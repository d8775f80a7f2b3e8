const EVENT_LIMIT = 100; // entries of the log

/* Create a simulation of the emitted C in closed loop with a plant, both in WebAssembly.

   setting: see drive_settings in report/page/drive.py. The methods take `conditions`: sampling period, latency, noise, and the
   wind with its kind, angle and plane. Events go to `log`, states to `trace`. */
function createLoop(setting) {
  const bytes = Uint8Array.from(atob(setting.wasm), (c) => c.charCodeAt(0));
  const wasmModule = new WebAssembly.Module(bytes);
  /* The C library is that of the browser, in double; WebAssembly rounds results to float where the C declares it. */
  const MATH_NAMES = { fabs: "abs", fmin: "min", fmax: "max" };
  const env = {};
  for (const { name } of WebAssembly.Module.imports(wasmModule)) {
    const plain = name in Math || name in MATH_NAMES ? name : name.replace(/f$/, "");
    env[name] = Math[MATH_NAMES[plain] || plain];
  }
  const wasm = new WebAssembly.Instance(wasmModule, { env }).exports;
  const n = dimension, states = setting.order * n;
  const address = wasm.report_buffer_address();
  /* Offsets in report_buffer: state, input, f, g, constants, sample. */
  const [X, U, F, G, P, S] = [0, 2 * n, 3 * n, 4 * n, 4 * n + n * n, 4 * n + n * n + setting.constants.length];
  let doubles = new Float64Array(wasm.memory.buffer, address, S + n);
  const memory = () => {
    if (!doubles.length) doubles = new Float64Array(wasm.memory.buffer, address, S + n); // memory that grows detaches the array
    return doubles;
  };
  const addressOf = (k) => address + 8 * k;

  const loop = { t: 0, x: [], v: null, u: [], w: [], status: 0, margin: 0, waitedSeconds: 0, trace: [], log: [], hand: null, unprovedReason: "", proved: false };
  let alphaTime = 0; // the time up to which alpha has been stepped
  let pendingInputs = []; // delayed inputs: [time of arrival, u, sample, whether the proof covers it]
  let isProvedInput = false; // whether the proof covers the input that acts now
  let faultlessSamples = 0; // the latest samples in a row without a fault
  let hasArrived = false; // whether the arrival has been reported
  let sample = [];
  let previousStatus = 0; // of the sample before
  let lastPeriod = 0; // of the last step
  let seed = 1;
  /* Return a pseudorandom number of [-1, 1). */
  const random = () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return seed / 2 ** 31 - 1;
  };

  /* The time of the tube: less than t by what it has waited, and within one cycle where it repeats. */
  loop.tubeTime = () => {
    const t = loop.t - loop.waitedSeconds;
    if (!data.cycle || t < data.t_c) return Math.min(t, data.t_c);
    const cycleLength = data.cycle[1] - data.cycle[0];
    return data.cycle[0] + ((t - data.cycle[0]) % cycleLength);
  };
  loop.control = (t, x) => {
    memory().set(x, X);
    const status = wasm.loop_own_step(t, addressOf(X), addressOf(U));
    return [status, [...memory().subarray(U, U + n)]];
  };
  loop.tube = (t) => {
    wasm.loop_own_tube(t, addressOf(X), addressOf(G)); // the edges may cover P and S, which are written before each use
    return [[...memory().subarray(X, X + states)], [...memory().subarray(G, G + states)]];
  };
  loop.marginAt = (t, x) => {
    memory().set(x, X);
    return wasm.loop_own_margin(t, addressOf(X));
  };

  function plantDerivative(x) {
    const memoryDoubles = memory();
    memoryDoubles.set(x, X);
    memoryDoubles.set(setting.constants, P);
    memoryDoubles.set(sample, S);
    wasm.loop_plant(addressOf(X), addressOf(P), addressOf(S), addressOf(F), addressOf(G));
    const results = memory();
    return Array.from({ length: n }, (_, i) => loop.u.reduce((sum, u, k) => sum + results[G + i * n + k] * u, results[F + i] + loop.w[i]));
  }
  const stateDerivative = setting.order === 1 ? plantDerivative : (z) => [...z.slice(n), ...plantDerivative(z)];

  function integrate(z, h) {
    const add = (k, s) => z.map((v, i) => v + s * k[i]);
    const k1 = stateDerivative(z), k2 = stateDerivative(add(k1, h / 2)), k3 = stateDerivative(add(k2, h / 2)), k4 = stateDerivative(add(k3, h));
    return z.map((v, i) => v + (h / 6) * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]));
  }

  const state = () => (setting.order === 2 ? [...loop.x, ...loop.v] : loop.x);
  function setState(z) {
    loop.x = z.slice(0, n);
    loop.v = setting.order === 2 ? z.slice(n) : null;
  }
  function advanceAlpha(t) {
    if (!setting.adaptive || t <= alphaTime) return;
    wasm.loop_own_advance(alphaTime, t - alphaTime);
    alphaTime = t;
  }

  /* Begin at time t in the middle of the tube, at t = 0 in the initial state. Of order 2 the speed follows the tube. */
  loop.begin = (t) => {
    if (wasm.loop_own_start) wasm.loop_own_start();
    alphaTime = 0;
    loop.t = t;
    loop.waitedSeconds = 0;
    loop.trace = [];
    loop.log = [];
    pendingInputs = [];
    loop.u = new Array(n).fill(0);
    loop.w = new Array(n).fill(0);
    loop.unprovedReason = "";
    loop.lost = false;
    loop.hand = null;
    seed = 1;
    advanceAlpha(t);
    const [low, high] = loop.tube(t);
    loop.x = t > 0 ? midpoint(low.slice(0, n), high.slice(0, n)) : [...setting.x];
    loop.v = null;
    if (setting.order === 2) {
      const middleSpeed = (lambda, i) => (low[n + i] + high[n + i]) / 2 - lambda * loop.x[i];
      loop.v = t > 0 ? data.filtered.lambda.map(middleSpeed) : new Array(n).fill(0);
    }
    sample = [...loop.x];
    if (setting.uses_differences && t > 0) { // an earlier sample, from which the C takes the difference
      const earlierX = loop.x.map((v, i) => v - setting.period * loop.v[i]);
      loop.control(t - setting.period, earlierX.concat(loop.v));
    }
    const period = setting.proved ? setting.proved.period : setting.period;
    const calmConditions = { period, latency: 0, noise: 0, wind: 0 }; // before the first sample no condition can be violated
    takeSample(calmConditions, true);
    loop.unprovedReason = faultOf(calmConditions, 0) || (loop.status === 0 && isAmongStarts() ? "" : "not one of the starts");
    loop.proved = isProvedInput = !loop.unprovedReason;
    faultlessSamples = loop.proved ? 2 : 0;
    hasArrived = false;
    lastReported.clear();
    previousStatus = 0;
    recordSample();
  };

  function windUnder(conditions) {
    const size = conditions.wind;
    if (!size) return new Array(n).fill(0);
    if (conditions.kind === "outward") {
      const [low, high] = loop.tube(loop.t);
      const tubeCoordinate = (k) => (setting.order === 2 ? loop.v[k] + data.filtered.lambda[k] * loop.x[k] : loop.x[k]);
      const offset = setting.order === 2 ? n : 0; // of the edges of the filtered tube
      /* e: -1 at the lower edge, 1 at the upper edge */
      const normalizedErrors = loop.x.map((_, k) => (2 * tubeCoordinate(k) - low[offset + k] - high[offset + k]) / (high[offset + k] - low[offset + k]));
      const nearestAxis = normalizedErrors.reduce((m, e, k) => (Math.abs(e) > Math.abs(normalizedErrors[m]) ? k : m), 0);
      return normalizedErrors.map((e, k) => (k === nearestAxis ? Math.sign(e || 1) * size : 0));
    }
    if (conditions.kind === "random") {
      const w = loop.x.map(random);
      return w.map((v) => (v * size) / (Math.hypot(...w) || 1));
    }
    const [i, j] = conditions.plane;
    if (n === 1) return [Math.sign(Math.cos(conditions.angle) || 1) * size];
    return loop.x.map((_, k) => (k === i ? size * Math.cos(conditions.angle) : k === j ? size * Math.sin(conditions.angle) : 0));
  }

  /* The noise of component k of the state over the slider's value. */
  const noiseRatio = (k) => {
    const ratio = k < n ? setting.x_noise_ratio : setting.v_noise_ratio;
    return Array.isArray(ratio) ? ratio[k % n] : ratio;
  };

  /* Take a sample: measure, compute u with the C, and let it act now or after the latency. */
  function takeSample(conditions, isFirst) {
    advanceAlpha(loop.t);
    const measured = state().map((v, k) => v + conditions.noise * noiseRatio(k) * random());
    const [status, u] = loop.control(loop.t, measured);
    if (wasm.loop_own_waited_seconds) loop.waitedSeconds = wasm.loop_own_waited_seconds();
    loop.status = status;
    loop.margin = loop.marginAt(loop.t, state());
    const isFaultless = isFirst || faultOf(conditions, status) === "";
    if (isFirst || !conditions.latency) {
      loop.u = u;
      sample = measured.slice(0, n);
      pendingInputs = [];
      isProvedInput = isFaultless;
    } else {
      const arrival = loop.t + conditions.latency;
      pendingInputs = pendingInputs.filter(([pendingArrival]) => pendingArrival <= arrival); // a newer input replaces those that would arrive after it
      pendingInputs.push([arrival, u, measured.slice(0, n), isFaultless]);
    }
    if (!isFirst) updateProof(conditions, isFaultless);
  }

  /* Return a reason for each condition that exceeds the proved limit, by the name of its slider. */
  loop.exceededLimits = (conditions) => {
    const proved = setting.proved;
    const tolerance = 1 + 1e-9; // for the rounding of a slider
    if (!proved) return { rate: "samples", wind: "wind", latency: "delay", noise: "noise" };
    const reasons = {};
    if (conditions.period > proved.period * tolerance) reasons.rate = "samples too rare";
    if (conditions.period < proved.shortest / tolerance) reasons.rate = "samples too dense";
    if (conditions.latency > proved.latency * tolerance) reasons.latency = "delay";
    if (conditions.noise > proved.noise * tolerance) reasons.noise = "noise";
    if (conditions.wind > proved.w * tolerance) reasons.wind = "wind";
    return reasons;
  };

  /* Return why the proof does not cover a sample; empty where it does. */
  function faultOf(conditions, status) {
    if (!setting.proved) return "no sampling period is proved for this gain";
    const reasons = Object.values(loop.exceededLimits(conditions));
    if (setting.adaptive) reasons.push("the steps of alpha");
    if (loop.hand) reasons.push("a hand");
    if (status !== 0) reasons.push("outside the tube");
    return reasons.join(", ");
  }

  /* After a fault the proof holds again from a sample that is one of the starts, if it covers the acting and the delayed inputs.
     A velocity by differences comes from two samples, so the one before has to be faultless too. */
  function updateProof(conditions, isFaultless) {
    const reason = faultOf(conditions, loop.status);
    faultlessSamples = reason ? 0 : faultlessSamples + 1;
    if (reason) discardProof(reason);
    else if (loop.unprovedReason) {
      const hasEnoughSamples = faultlessSamples >= (setting.uses_differences ? 2 : 1);
      const allInputsCovered = isFaultless && isProvedInput && pendingInputs.every(([, , , isCovered]) => isCovered);
      if (hasEnoughSamples && allInputsCovered && isAmongStarts()) loop.unprovedReason = "";
    }
    loop.proved = !loop.unprovedReason;
  }
  /* The proof does not hold from now on; it covers neither the acting nor the delayed inputs. */
  function discardProof(reason) {
    loop.unprovedReason = reason;
    loop.proved = false;
    isProvedInput = false;
    faultlessSamples = 0;
    pendingInputs = pendingInputs.map(([arrival, u, measured]) => [arrival, u, measured, false]);
  }

  /* Return whether the state is within the start share of the tube. At t = 0, of order 2, the speed is that of the task. */
  function isAmongStarts() {
    const [low, high] = loop.tube(loop.t);
    const z = setting.order === 2 && loop.t > 0 ? loop.x.concat(loop.v.map((v, i) => v + data.filtered.lambda[i] * loop.x[i])) : loop.x;
    return z.every((v, i) => Math.abs(2 * v - low[i] - high[i]) <= setting.proved.start_share * (high[i] - low[i]));
  }

  /* Log an event when it begins; one that comes and goes quickly is logged once. */
  const lastReported = new Map();
  function report(happens, text) {
    if (!happens) return;
    const previous = lastReported.get(text);
    lastReported.set(text, loop.t);
    if ((previous === undefined || loop.t - previous > data.t_c / 20) && loop.log.length < EVENT_LIMIT) loop.log.push([loop.t, text]);
  }
  function recordSample() {
    const t = loop.tubeTime();
    report(loop.status === 1, "outside the tube");
    report(previousStatus === 1 && loop.status === 0, "inside the tube again");
    previousStatus = loop.status;
    for (const set of data.sets) if (isInSet(set, loop.x, t)) report(true, `${set.exact ? "in" : "may be in"} unsafe set ${set.name}`);
    report(!isWithin(data.room, loop.x), "out of the state space");
    reportArrival();
    const last = loop.trace[loop.trace.length - 1];
    if (last && t < last.t) loop.trace = [];
    if (!last || t - last.t >= data.t_c / 1500) loop.trace.push({ t, x: [...loop.x], v: loop.v && [...loop.v], u: [...loop.u], margin: loop.margin });
  }

  /* Log the arrival in the target, or that it is late at t_c. A target that moves is left out after t_c. */
  function reportArrival() {
    if (!data.target || data.cycle || hasArrived || loop.t < data.t_c) return;
    const isInTarget = isWithin(data.target.faces, loop.x) && !loop.hand;
    const delay = loop.t - data.t_c;
    const onTime = delay < lastPeriod;
    if (isInTarget) loop.log.push([loop.t, onTime ? "in the target, in time" : `in the target, ${formatNumber(delay)} s late`]);
    else if (onTime) loop.log.push([loop.t, "not in the target at the prescribed time"]);
    hasArrived = isInTarget || Boolean(data.target.knots);
  }

  /* Simulate one sampling period and take the next sample. */
  loop.step = (conditions) => {
    loop.w = windUnder(conditions);
    const stateBefore = [...state()];
    const substeps = Math.max(4, Math.min(40, Math.ceil((conditions.period / data.t_c) * 4000)));
    const begin = loop.t;
    const h = conditions.period / substeps;
    lastPeriod = conditions.period;
    const end = begin + conditions.period;
    for (let t = begin, k = 1; t < end; ) {
      while (pendingInputs.length && pendingInputs[0][0] <= t) [, loop.u, sample, isProvedInput] = pendingInputs.shift();
      let next = k < substeps ? begin + k * h : end;
      if (pendingInputs.length && pendingInputs[0][0] < next) next = pendingInputs[0][0]; // a delayed input acts between two steps
      else k++;
      if (!loop.hand) setState(integrate(state(), next - t));
      t = next;
    }
    if (!state().every(Number.isFinite)) {
      setState(stateBefore);
      loop.lost = true;
      loop.log.push([loop.t, "the state grows beyond numbers: the loop stops"]);
      return;
    }
    for (const [i, value] of loop.hand || []) {
      loop.x[i] = value;
      if (loop.v) loop.v[i] = 0;
    }
    loop.t = begin + conditions.period;
    takeSample(conditions, false);
    recordSample();
  };
  /* Hold the state at values of some dimensions, as [dimension, value] pairs. */
  loop.hold = (coordinates) => {
    loop.hand = coordinates;
    recordTouch();
    for (const [i, value] of coordinates) loop.x[i] = value;
  };
  loop.release = () => { loop.hand = null; };
  loop.shove = (i, by) => {
    loop.x[i] += by;
    recordTouch();
  };
  const recordTouch = () => discardProof("a hand");
  return loop;
}
