const MOST_EVENTS = 100;

/* The emitted C in a loop with a plant, both WebAssembly: samples, an input that is held, a wind, a hand. */
function loopOf(setting) {
  const bytes = Uint8Array.from(atob(setting.wasm), (c) => c.charCodeAt(0));
  const module = new WebAssembly.Module(bytes);
  /* What the C calls of a C library, in double; the result is rounded to what the C says it is. */
  const NAMES = { fabs: "abs", fmin: "min", fmax: "max" };
  const env = {};
  for (const { name } of WebAssembly.Module.imports(module)) {
    const plain = name in Math || name in NAMES ? name : name.replace(/f$/, "");
    env[name] = Math[NAMES[plain] || plain];
  }
  const own = new WebAssembly.Instance(module, { env }).exports;
  const n = count, states = setting.order * n;
  const address = own.report_room_address();
  const [X, U, F, G, P, S] = [0, 2 * n, 3 * n, 4 * n, 4 * n + n * n, 4 * n + n * n + setting.constants.length];
  const room = () => new Float64Array(own.memory.buffer, address, S + n); // anew: memory that grows lets go of the old view
  const where = (k) => address + 8 * k;

  const loop = { t: 0, x: [], v: null, u: [], w: [], status: 0, margin: 0, lag: 0, trace: [], log: [], hand: null, broken: "", proved: false };
  let before = 0; // seconds of t that alpha has got to
  let late = []; // inputs on their way: when they act, and what they are
  let sample = [];
  let was = 0; // the status at the sample before
  let seed = 1;
  const random = () => { seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0; return seed / 2 ** 31 - 1; };

  /* The tube's time for a time since the start: turned back where the tube repeats itself, behind where it waits. */
  loop.tubeTime = () => {
    const t = loop.t - loop.lag;
    if (!data.cycle || t < data.t_c) return Math.min(t, data.t_c);
    const long = data.cycle[1] - data.cycle[0];
    return data.cycle[0] + ((t - data.cycle[0]) % long);
  };
  loop.control = (t, x) => {
    room().set(x, X);
    const status = own.loop_own_step(t, where(X), where(U));
    return [status, [...room().subarray(U, U + n)]];
  };
  loop.tube = (t) => { own.loop_own_tube(t, where(X), where(G)); return [[...room().subarray(X, X + states)], [...room().subarray(G, G + states)]]; };
  loop.marginAt = (t, x) => { room().set(x, X); return own.loop_own_margin(t, where(X)); };

  function plant(x) {
    const all = room();
    all.set(x, X);
    all.set(setting.constants, P);
    all.set(sample, S);
    own.loop_plant(where(X), where(P), where(S), where(F), where(G));
    const view = room();
    return Array.from({ length: n }, (_, i) => loop.u.reduce((sum, u, k) => sum + view[G + i * n + k] * u, view[F + i] + loop.w[i]));
  }
  const rate = setting.order === 1 ? plant : (z) => [...z.slice(n), ...plant(z)];

  function integrate(z, h) {
    const add = (k, s) => z.map((v, i) => v + s * k[i]);
    const k1 = rate(z), k2 = rate(add(k1, h / 2)), k3 = rate(add(k2, h / 2)), k4 = rate(add(k3, h));
    return z.map((v, i) => v + (h / 6) * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]));
  }

  const state = () => (setting.order === 2 ? [...loop.x, ...loop.v] : loop.x);
  function place(z) {
    loop.x = z.slice(0, n);
    loop.v = setting.order === 2 ? z.slice(n) : null;
  }
  function advanceAlpha(t) {
    if (!setting.adaptive || t <= before) return;
    own.loop_own_advance(before, t - before);
    before = t;
  }

  /* Begin at t with the state in the middle of the tube there, at t = 0 with that of the task; of order 2 at the tube's pace. */
  loop.begin = (t) => {
    if (own.loop_own_start) own.loop_own_start();
    before = 0;
    [loop.t, loop.lag, loop.trace, loop.log, late, loop.u, loop.w] = [t, 0, [], [], [], new Array(n).fill(0), new Array(n).fill(0)];
    [loop.broken, loop.left, loop.hand, seed] = ["", false, null, 1];
    advanceAlpha(t);
    const [low, high] = loop.tube(t);
    loop.x = t > 0 ? middle(low.slice(0, n), high.slice(0, n)) : [...setting.x];
    loop.v = null;
    if (setting.order === 2) loop.v = t > 0 ? data.filtered.lambda.map((l, i) => (low[n + i] + high[n + i]) / 2 - l * loop.x[i]) : new Array(n).fill(0);
    sample = [...loop.x];
    if (setting.differs && t > 0) loop.control(t - setting.period, loop.x.map((v, i) => v - setting.period * loop.v[i]).concat(loop.v));
    observe({ period: setting.period, latency: 0, noise: 0, wind: 0 }, true);
    loop.broken = !setting.proved ? "no sampling period is proved for this gain" : amongStarts() ? "" : "not one of the starts";
    loop.proved = !loop.broken;
    seen.clear();
    was = 0;
    note();
  };

  function wind(given) {
    const size = given.wind;
    if (!size) return new Array(n).fill(0);
    if (given.kind === "outward") {
      const [low, high] = loop.tube(loop.t);
      const at = (k) => (setting.order === 2 ? loop.v[k] + data.filtered.lambda[k] * loop.x[k] : loop.x[k]);
      const first = setting.order === 2 ? n : 0;
      const share = loop.x.map((_, k) => (2 * at(k) - low[first + k] - high[first + k]) / (high[first + k] - low[first + k]));
      const worst = share.reduce((m, v, k) => (Math.abs(v) > Math.abs(share[m]) ? k : m), 0);
      return share.map((v, k) => (k === worst ? Math.sign(v || 1) * size : 0));
    }
    if (given.kind === "random") {
      const w = loop.x.map(random);
      return w.map((v) => (v * size) / (Math.hypot(...w) || 1));
    }
    const [i, j] = given.plane;
    return loop.x.map((_, k) => (k === i ? size * Math.cos(given.angle) : k === j ? size * Math.sin(given.angle) : 0));
  }

  /* A sample: measure, ask the C for u, let it act at once or late. */
  function observe(given, first) {
    advanceAlpha(loop.t);
    const measured = state().map((v, k) => v + given.noise * (k < n ? 1 : setting.noise_v) * random());
    const [status, u] = loop.control(loop.t, measured);
    if (own.loop_own_lag) loop.lag = own.loop_own_lag();
    loop.status = status;
    loop.margin = loop.marginAt(loop.t, state());
    if (first || !given.latency) { loop.u = u; sample = measured.slice(0, n); late = []; }
    else late.push([loop.t + given.latency, u, measured.slice(0, n)]);
    if (!first) judge(given);
  }

  /* Whether what is proved speaks of this loop: its assumptions hold, and have since the state was one of the starts. */
  function judge(given) {
    const known = setting.proved;
    const more = 1 + 1e-9;
    const reasons = [];
    if (!known) reasons.push("no sampling period is proved for this gain");
    else {
      if (given.period > known.period * more) reasons.push("samples too rare");
      if (given.period < known.shortest / more) reasons.push("samples too dense");
      if (given.latency > known.latency * more) reasons.push("delay");
      if (given.noise > known.noise * more) reasons.push("noise");
      if (given.wind > known.w * more) reasons.push("wind");
    }
    if (loop.hand) reasons.push("a hand");
    const away = reasons.join(", ");
    if (away) loop.broken = away;
    else if (loop.broken && amongStarts() && !late.length) loop.broken = "";
    loop.proved = !loop.broken;
  }
  /* At t = 0 the starts are those at rest (order 2: within the speeds that the task allows), whatever v + lambda x is. */
  function amongStarts() {
    const [low, high] = loop.tube(loop.t);
    const z = setting.order === 2 && loop.t > 0 ? loop.x.concat(loop.v.map((v, i) => v + data.filtered.lambda[i] * loop.x[i])) : loop.x;
    return z.every((v, i) => Math.abs(2 * v - low[i] - high[i]) <= setting.proved.share * (high[i] - low[i]));
  }

  /* What happens, told when it begins; what comes and goes is told once. */
  const seen = new Map();
  function tell(now, text) {
    if (!now) return;
    const before = seen.get(text);
    seen.set(text, loop.t);
    if ((before === undefined || loop.t - before > data.t_c / 20) && loop.log.length < MOST_EVENTS) loop.log.push([loop.t, text]);
  }
  function note() {
    const t = loop.tubeTime();
    tell(loop.status === 1, "outside the tube");
    tell(was === 1 && loop.status === 0, "inside the tube again");
    was = loop.status;
    for (const set of data.sets) tell(inside(set, loop.x, t), `in unsafe set ${set.name}`);
    tell(loop.x.some((v, i) => v < data.space[0][i] || v > data.space[1][i]), "out of the state space");
    const goal = data.target && data.target.span;
    const there = goal && loop.t - loop.lag >= data.t_c && loop.x.every((v, i) => goal[0][i] <= v && v <= goal[1][i]);
    tell(there, "in the target, in time");
    const last = loop.trace[loop.trace.length - 1];
    if (last && t < last.t) loop.trace = [];
    if (!last || t - last.t >= data.t_c / 1500) loop.trace.push({ t, x: [...loop.x], v: loop.v && [...loop.v], u: [...loop.u], margin: loop.margin });
  }

  /* One period: wind and plant under what acts, then the next sample. */
  loop.step = (given) => {
    loop.w = wind(given);
    const parts = Math.max(4, Math.min(40, Math.ceil((given.period / data.t_c) * 4000)));
    const begin = loop.t, h = given.period / parts;
    for (let k = 0; k < parts; k++) {
      const t = begin + k * h;
      while (late.length && late[0][0] < t + h) [, loop.u, sample] = late.shift(); // not later than is said
      if (!loop.hand) place(integrate(state(), h));
    }
    if (loop.hand) for (const [i, value] of loop.hand) { loop.x[i] = value; if (loop.v) loop.v[i] = 0; }
    loop.t = begin + given.period;
    observe(given, false);
    note();
  };
  loop.hold = (where) => { loop.hand = where; touched(); for (const [i, value] of where) loop.x[i] = value; };
  loop.release = () => { loop.hand = null; };
  loop.shove = (i, by) => { loop.x[i] += by; touched(); };
  function touched() { [loop.broken, loop.proved] = ["a hand", false]; }
  return loop;
}
