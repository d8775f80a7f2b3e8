/* The data of the page (report/page/scene.py), where sets and tube are at a time, and numbers as text: shared by all views. */
const data = JSON.parse(document.getElementById("data").textContent);
const segmentCount = data.low.length - 1;
const dimension = data.axes.length;
const LABEL_LIMIT = 40; // sets; a view of more shows names under the pointer only
const SVG = "http://www.w3.org/2000/svg";

function addSvg(parent, kind, attributes, text) {
  const node = document.createElementNS(SVG, kind);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  if (text !== undefined) node.textContent = text;
  parent.appendChild(node);
  return node;
}

/* Interpolate a row of samples at time t. */
function rowAt(rows, t) {
  const position = Math.min(Math.max(t / data.t_c, 0), 1) * segmentCount;
  const k = Math.min(Math.floor(position), segmentCount - 1);
  return rows[k].map((v, i) => v + (position - k) * (rows[k + 1][i] - v));
}

const midpoint = (low, high) => low.map((v, i) => (v + high[i]) / 2);

/* Interpolate the displacement of something that moves at time tau of its clock. */
function displacementAt(knots, tau) {
  let k = knots.findIndex((knot) => knot[0] >= tau);
  if (k === -1) k = knots.length - 1;
  if (k === 0 || knots[k][0] < tau) return knots[k].slice(1);
  const share = (tau - knots[k - 1][0]) / (knots[k][0] - knots[k - 1][0]);
  return knots[k].slice(1).map((v, i) => knots[k - 1][i + 1] + share * (v - knots[k - 1][i + 1]));
}

/* Whether a set is unsafe at time tau of its clock; an active interval that ends at t_c does not end. */
function isActive(set, tau) {
  return !set.window || (set.window[0] <= tau && (tau <= set.window[1] || set.window[1] >= data.t_c));
}

const isUncertain = (set) => set.knots !== undefined && (set.clock[0] > 0 || set.clock[1] > 0 || set.growth[0] > 0);

/* Return displacements whose hull has all that a set may have at time t; none while it is certainly inactive. */
function possibleDisplacements(set, t) {
  if (!set.knots) return [new Array(dimension).fill(0)];
  let [first, last] = [t - set.clock[0], t + set.clock[1]];
  if (set.window) {
    const open = set.window[1] >= data.t_c ? Infinity : set.window[1];
    [first, last] = [Math.max(first, set.window[0]), Math.min(last, open)];
  }
  if (first > last) return [];
  const between = set.knots.map((knot) => knot[0]).filter((tau) => first < tau && tau < last);
  return [first, ...between, last].map((tau) => displacementAt(set.knots, tau));
}

/* Return the corners of the hull of points in the plane, in order around it. */
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const halfHull = (sortedPoints) => {
    const chain = [];
    for (const p of sortedPoints) {
      while (chain.length > 1) {
        const [a, b] = chain.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        chain.pop();
      }
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...halfHull(sorted), ...halfHull(sorted.reverse())];
}

const SQUARE = [[-1, -1], [-1, 1], [1, -1], [1, 1]];
const CIRCLE = Array.from({ length: 32 }, (_, k) => [Math.cos((k * Math.PI) / 16), Math.sin((k * Math.PI) / 16)]);

/* Return the outline of all that a set may cover in a plane at time t, with its growth. */
function possibleOutline(set, key, [i, j], t) {
  const growth = set.growth[0] * Math.max(t + set.clock[1], 0);
  const [growthX, growthY] = [growth * set.growth[1][i], growth * set.growth[1][j]];
  const directions = set.growth[2] ? CIRCLE : SQUARE;
  const grownOutline = set.outline[key].flatMap(([x, y]) => directions.map(([c, s]) => [x + growthX * c, y + growthY * s]));
  return hull(possibleDisplacements(set, t).flatMap((d) => grownOutline.map(([x, y]) => [x + d[i], y + d[j]])));
}

/* Whether a point is in all half-spaces. */
const isWithin = (faces, x) => faces.every(([normal, offset]) => normal.reduce((sum, c, i) => sum + c * x[i], 0) <= offset);

/* Whether the body at state x overlaps a set at time t, at the stated position of the set. */
function isInSet(set, x, t) {
  if (!isActive(set, t)) return false;
  const displacement = set.knots ? displacementAt(set.knots, t) : null;
  const relative = displacement ? x.map((v, i) => v - displacement[i]) : x;
  if (!isWithin(set.faces, relative)) return false;
  if (!set.round) return true;
  const [[a, b], radius, axes] = set.round;
  const distanceTo = (s) => Math.hypot(...axes.map((i) => Math.max(Math.abs(relative[i] - a[i] - s * (b[i] - a[i])) - data.body[i], 0)));
  let [low, high] = [0, 1]; // the distance is convex along the line
  for (let k = 0; k < 60; k++) {
    const [lowThird, highThird] = [low + (high - low) / 3, high - (high - low) / 3];
    if (distanceTo(lowThird) < distanceTo(highThird)) high = highThird;
    else low = lowThird;
  }
  return distanceTo((low + high) / 2) <= radius;
}

/* Return round numbers from low to high for an axis, at most tickLimit or so. */
function ticks(low, high, tickLimit = 6) {
  const decade = 10 ** Math.floor(Math.log10((high - low) / 2));
  const spacing = [1, 2, 5, 10, 20].map((m) => m * decade).find((s) => (high - low) / s <= tickLimit) || high - low;
  const values = [];
  for (let v = Math.ceil(low / spacing - 1e-9) * spacing; v <= high + 1e-9 * spacing; v += spacing) values.push(Number(v.toPrecision(12)));
  return values;
}

/* Round to three digits, up or down. */
function roundUp(v) { return v > 0 ? roundToDigits(v, Math.ceil) : v; }
function roundDown(v) { return v > 0 ? roundToDigits(v, Math.floor) : v; }
function roundToDigits(v, rounding) {
  const unit = 10 ** (Math.floor(Math.log10(v)) - 2);
  return rounding(Number((v / unit).toPrecision(12))) * unit;
}
const decimals = Math.min(9, Math.max(2, 2 - Math.floor(Math.log10(data.t_c)))); // of a time in seconds
const formatTime = (t) => t.toFixed(decimals);

const formatNumber = (v) => (Number.isFinite(v) ? Number(v.toPrecision(3)).toString().replace("-", "\u2212") : "no number");

/* Move labels into the frame, and remove a label that would cover an earlier one or a taken box. Labels have to be in the page. */
function placeLabels(labels, left, top, right, bottom, taken = []) {
  const placed = [...taken];
  for (const label of labels) {
    let box = label.getBBox();
    const x = Math.max(left + 3 - box.x, 0) + Math.min(right - 3 - box.x - box.width, 0);
    const y = Math.max(top + 2 - box.y, 0) + Math.min(bottom - 2 - box.y - box.height, 0);
    label.setAttribute("x", Number(label.getAttribute("x")) + x);
    label.setAttribute("y", Number(label.getAttribute("y")) + y);
    box = { left: box.x + x, right: box.x + x + box.width, top: box.y + y, bottom: box.y + y + box.height };
    const wide = box.right - box.left > right - left;
    if (wide || placed.some((o) => box.left < o.right && o.left < box.right && box.top < o.bottom && o.top < box.bottom)) label.remove();
    else placed.push(box);
  }
}
