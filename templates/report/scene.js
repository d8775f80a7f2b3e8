/* What is drawn, and where it is at a time: shared by all views. */
const data = JSON.parse(document.getElementById("data").textContent);
const samples = data.low.length - 1;
const count = data.axes.length;
const MANY = 40; // names are drawn up to so many sets
const SVG = "http://www.w3.org/2000/svg";

function make(parent, kind, attributes, text) {
  const node = document.createElementNS(SVG, kind);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  if (text !== undefined) node.textContent = text;
  parent.appendChild(node);
  return node;
}

/* A row of samples at a time, straight between two of them. */
function at(rows, t) {
  const place = Math.min(Math.max(t / data.t_c, 0), 1) * samples;
  const k = Math.min(Math.floor(place), samples - 1);
  return rows[k].map((v, i) => v + (place - k) * (rows[k + 1][i] - v));
}

const middle = (low, high) => low.map((v, i) => (v + high[i]) / 2);

/* By how much something that moves is displaced at a time on its clock. */
function displaced(knots, tau) {
  let k = knots.findIndex((knot) => knot[0] >= tau);
  if (k === -1) k = knots.length - 1;
  if (k === 0 || knots[k][0] < tau) return knots[k].slice(1);
  const share = (tau - knots[k - 1][0]) / (knots[k][0] - knots[k - 1][0]);
  return knots[k].slice(1).map((v, i) => knots[k - 1][i + 1] + share * (v - knots[k - 1][i + 1]));
}

/* Whether a set is unsafe at a time on its clock; a window that ends at t_c stays closed. */
function unsafe(set, tau) {
  return !set.window || (set.window[0] <= tau && (tau <= set.window[1] || set.window[1] >= data.t_c));
}

const doubtful = (set) => set.knots !== undefined && (set.clock[0] > 0 || set.clock[1] > 0 || set.growth[0] > 0);

/* Where a set may be at a time: the displacements of its path at the corners, none while it is safe for certain. */
function places(set, t) {
  if (!set.knots) return [new Array(count).fill(0)];
  let [first, last] = [t - set.clock[0], t + set.clock[1]];
  if (set.window) {
    const open = set.window[1] >= data.t_c ? Infinity : set.window[1];
    [first, last] = [Math.max(first, set.window[0]), Math.min(last, open)];
  }
  if (first > last) return [];
  const between = set.knots.map((knot) => knot[0]).filter((tau) => first < tau && tau < last);
  return [first, ...between, last].map((tau) => displaced(set.knots, tau));
}

/* The corners of the hull of points in the plane, in order around it. */
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => {
    const found = [];
    for (const p of list) {
      while (found.length > 1) {
        const [a, b] = found.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        found.pop();
      }
      found.push(p);
    }
    return found.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

const SQUARE = [[-1, -1], [-1, 1], [1, -1], [1, 1]];
const CIRCLE = Array.from({ length: 32 }, (_, k) => [Math.cos((k * Math.PI) / 16), Math.sin((k * Math.PI) / 16)]);

/* All that a set may cover in a plane at a time, as large as it may have grown. */
function swept(set, key, [i, j], t) {
  const by = set.growth[0] * Math.max(t + set.clock[1], 0);
  const [a, b] = [by * set.growth[1][i], by * set.growth[1][j]];
  const around = set.growth[2] ? CIRCLE : SQUARE;
  const grown = set.outline[key].flatMap(([x, y]) => around.map(([c, s]) => [x + a * c, y + b * s]));
  return hull(places(set, t).flatMap((d) => grown.map(([x, y]) => [x + d[i], y + d[j]])));
}

/* Whether a point is in all of these half-spaces. */
const within = (faces, x) => faces.every(([normal, offset]) => normal.reduce((sum, c, i) => sum + c * x[i], 0) <= offset);

/* Whether the body about a point is in a set, where the set is stated to be. */
function inside(set, x, t) {
  if (!unsafe(set, t)) return false;
  const d = set.knots ? displaced(set.knots, t) : null;
  const from = d ? x.map((v, i) => v - d[i]) : x;
  if (!within(set.faces, from)) return false;
  if (!set.round) return true;
  const [[a, b], radius, own] = set.round;
  const far = (s) => Math.hypot(...own.map((i) => Math.max(Math.abs(from[i] - a[i] - s * (b[i] - a[i])) - data.body[i], 0)));
  let [low, high] = [0, 1]; // the distance is convex along the line
  for (let k = 0; k < 60; k++) {
    const [p, q] = [low + (high - low) / 3, high - (high - low) / 3];
    if (far(p) < far(q)) high = q;
    else low = p;
  }
  return far((low + high) / 2) <= radius;
}

function ticks(low, high, most = 6) {
  const step = 10 ** Math.floor(Math.log10((high - low) / 2));
  const coarse = [1, 2, 5, 10, 20].map((m) => m * step).find((s) => (high - low) / s <= most) || high - low;
  const found = [];
  for (let v = Math.ceil(low / coarse - 1e-9) * coarse; v <= high + 1e-9 * coarse; v += coarse) found.push(Number(v.toPrecision(12)));
  return found;
}

/* Three digits, not below and not above. */
function up(v) { return v > 0 ? rounded(v, Math.ceil) : v; }
function down(v) { return v > 0 ? rounded(v, Math.floor) : v; }
function rounded(v, way) {
  const unit = 10 ** (Math.floor(Math.log10(v)) - 2);
  return way(Number((v / unit).toPrecision(12))) * unit;
}
const decimals = Math.min(9, Math.max(2, 2 - Math.floor(Math.log10(data.t_c)))); // of a time
const clock = (t) => t.toFixed(decimals);

const short = (v) => (Number.isFinite(v) ? Number(v.toPrecision(3)).toString().replace("-", "\u2212") : "no number");

/* Labels inside the frame and none over another: of two the later one goes. Needs to be in the page, for it measures. */
function settle(labels, left, top, right, bottom, taken = []) {
  const kept = [...taken];
  for (const label of labels) {
    let box = label.getBBox();
    const x = Math.max(left + 3 - box.x, 0) + Math.min(right - 3 - box.x - box.width, 0);
    const y = Math.max(top + 2 - box.y, 0) + Math.min(bottom - 2 - box.y - box.height, 0);
    label.setAttribute("x", Number(label.getAttribute("x")) + x);
    label.setAttribute("y", Number(label.getAttribute("y")) + y);
    box = { left: box.x + x, right: box.x + x + box.width, top: box.y + y, bottom: box.y + y + box.height };
    const wide = box.right - box.left > right - left;
    if (wide || kept.some((o) => box.left < o.right && o.left < box.right && box.top < o.bottom && o.top < box.bottom)) label.remove();
    else kept.push(box);
  }
}
