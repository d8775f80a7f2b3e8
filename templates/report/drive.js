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
  let view = new Float64Array(own.memory.buffer, address, S + n);
  const room = () => (view.length ? view : (view = new Float64Array(own.memory.buffer, address, S + n))); // memory that grows lets go of it
  const where = (k) => address + 8 * k;

  const loop = { t: 0, x: [], v: null, u: [], w: [], status: 0, margin: 0, lag: 0, trace: [], log: [], hand: null, broken: "", proved: false };
  let before = 0; // seconds of t that alpha has got to
  let late = []; // inputs on their way: when they act, what they are, whether their samples are as the proof has them
  let acting = false; // the same of what acts
  let clean = 0; // samples in a row, up to now, that nothing was wrong with
  let arrived = false; // whether t_c is past, and said
  let sample = [];
  let was = 0; // the status at the sample before
  let latest = 0; // the period of the last step
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
    const now = room();
    return Array.from({ length: n }, (_, i) => loop.u.reduce((sum, u, k) => sum + now[G + i * n + k] * u, now[F + i] + loop.w[i]));
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
    [loop.broken, loop.lost, loop.hand, seed] = ["", false, null, 1];
    advanceAlpha(t);
    const [low, high] = loop.tube(t);
    loop.x = t > 0 ? middle(low.slice(0, n), high.slice(0, n)) : [...setting.x];
    loop.v = null;
    if (setting.order === 2) loop.v = t > 0 ? data.filtered.lambda.map((l, i) => (low[n + i] + high[n + i]) / 2 - l * loop.x[i]) : new Array(n).fill(0);
    sample = [...loop.x];
    if (setting.differs && t > 0) loop.control(t - setting.period, loop.x.map((v, i) => v - setting.period * loop.v[i]).concat(loop.v));
    const known = setting.proved;
    const calm = { period: known ? known.period : setting.period, latency: 0, noise: 0, wind: 0 }; // no sample was yet, so none is too rare
    observe(calm, true);
    loop.broken = fault(calm, 0) || (loop.status === 0 && amongStarts() ? "" : "not one of the starts");
    loop.proved = acting = !loop.broken;
    [clean, arrived] = [loop.proved ? 2 : 0, false];
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
    if (n === 1) return [Math.sign(Math.cos(given.angle) || 1) * size];
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
    const good = first || fault(given, status) === "";
    if (first || !given.latency) { loop.u = u; sample = measured.slice(0, n); late = []; acting = good; }
    else {
      const arrival = loop.t + given.latency;
      late = late.filter(([when]) => when <= arrival); // what would come after a newer one is dropped
      late.push([arrival, u, measured.slice(0, n), good]);
    }
    if (!first) judge(given, good);
  }

  /* Which settings are beyond what is proved, by name and in words; more: what a slider rounds to. */
  loop.beyond = (given) => {
    const known = setting.proved, more = 1 + 1e-9;
    if (!known) return { rate: "samples", wind: "wind", latency: "delay", noise: "noise" };
    const found = {};
    if (given.period > known.period * more) found.rate = "samples too rare";
    if (given.period < known.shortest / more) found.rate = "samples too dense";
    if (given.latency > known.latency * more) found.latency = "delay";
    if (given.noise > known.noise * more) found.noise = "noise";
    if (given.wind > known.w * more) found.wind = "wind";
    return found;
  };

  /* Why a sample is not one that what is proved speaks of; nothing where it is. */
  function fault(given, status) {
    if (!setting.proved) return "no sampling period is proved for this gain";
    const reasons = Object.values(loop.beyond(given));
    if (setting.adaptive) reasons.push("the steps of alpha");
    if (loop.hand) reasons.push("a hand");
    if (status !== 0) reasons.push("outside the tube");
    return reasons.join(", ");
  }

  /* Once something was wrong, it is proved again from a sample on that is one of the starts, where what acts and what is on its
     way is of such samples too; v by differences is of two samples, so the one before must have been right as well. */
  function judge(given, good) {
    const why = fault(given, loop.status);
    clean = why ? 0 : clean + 1;
    if (why) suspect(why);
    else if (loop.broken && clean >= (setting.differs ? 2 : 1) && good && acting && late.every((one) => one[3]) && amongStarts()) loop.broken = "";
    loop.proved = !loop.broken;
  }
  /* From here on something is not as the proof has it: neither are the inputs that act or are on their way. */
  function suspect(why) {
    [loop.broken, loop.proved, acting, clean] = [why, false, false, 0];
    late = late.map(([when, u, of]) => [when, u, of, false]);
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
    for (const set of data.sets) if (inside(set, loop.x, t)) tell(true, `${set.exact ? "in" : "may be in"} unsafe set ${set.name}`);
    tell(!within(data.room, loop.x), "out of the state space");
    arrive();
    const last = loop.trace[loop.trace.length - 1];
    if (last && t < last.t) loop.trace = [];
    if (!last || t - last.t >= data.t_c / 1500) loop.trace.push({ t, x: [...loop.x], v: loop.v && [...loop.v], u: [...loop.u], margin: loop.margin });
  }

  /* What is said when the tube's time is t_c, and of who comes later; of a target that moves nothing is said then. */
  function arrive() {
    if (!data.target || data.cycle || arrived || loop.t < data.t_c) return;
    const there = within(data.target.faces, loop.x) && !loop.hand;
    const delay = loop.t - data.t_c;
    const onTime = delay < latest;
    if (there) loop.log.push([loop.t, onTime ? "in the target, in time" : `in the target, ${short(delay)} s late`]);
    else if (onTime) loop.log.push([loop.t, "not in the target at the prescribed time"]);
    arrived = there || Boolean(data.target.knots);
  }

  /* One period: wind and plant under what acts, then the next sample. */
  loop.step = (given) => {
    loop.w = wind(given);
    const still = [...state()];
    const parts = Math.max(4, Math.min(40, Math.ceil((given.period / data.t_c) * 4000)));
    const begin = loop.t, h = given.period / parts;
    latest = given.period;
    const end = begin + given.period;
    for (let t = begin, k = 1; t < end; ) {
      while (late.length && late[0][0] <= t) [, loop.u, sample, acting] = late.shift();
      let next = k < parts ? begin + k * h : end;
      if (late.length && late[0][0] < next) next = late[0][0]; // what is late acts when it is there
      else k++;
      if (!loop.hand) place(integrate(state(), next - t));
      t = next;
    }
    if (!state().every(Number.isFinite)) {
      place(still);
      loop.lost = true;
      loop.log.push([loop.t, "the state grows beyond numbers: the loop stops"]);
      return;
    }
    if (loop.hand) for (const [i, value] of loop.hand) { loop.x[i] = value; if (loop.v) loop.v[i] = 0; }
    loop.t = begin + given.period;
    observe(given, false);
    note();
  };
  loop.hold = (where) => { loop.hand = where; touched(); for (const [i, value] of where) loop.x[i] = value; };
  loop.release = () => { loop.hand = null; };
  loop.shove = (i, by) => { loop.x[i] += by; touched(); };
  const touched = () => suspect("a hand");
  return loop;
}
