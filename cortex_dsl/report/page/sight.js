"use strict";
// What somebody sees: a sector of view, less what lies behind outlines that hide, by the definition of the simulation
// (exact in the plane, no ray is sampled). Pure functions.
// An eye is {x, y, heading, angle, distance}: its place, the middle of its view, how wide it opens, how far it reaches.
// A box is {x, y, heading, length, width}. SI units, angles in radians.

/** A border of what is seen that follows the circle of the view turns by at most this much between two points. */
const ARC = Math.PI / 90;
/** Nearer than this is the same place [m]; what touches the eye is kept apart by so much. */
const HAIR = 1e-9;
const APART = 1e-7;

/** The area that an eye sees, as points [x, y] in order; none for an eye inside of what hides. */
function visibleArea(eye, boxes) {
  if (boxes.some((box) => isInside(eye, box))) return [];
  const half = Math.min(eye.angle / 2, Math.PI);
  const edges = boxes.flatMap((box) => frontEdges(eye, box));
  const points = eye.angle < 2 * Math.PI ? [[0, 0]] : [];
  for (const [from, to, edge] of fronts(edges, -half, half)) {
    points.push(...(edge ? [onEdge(edge, from), onEdge(edge, to)] : arc(eye.distance, from, to)));
  }
  return points.map((point) => fromEye(eye, point));
}

/** The whole sector of a view, whoever stands in it. */
function sectorOf(eye) {
  return visibleArea(eye, []);
}

/** Whether an eye sees any part of an outline. Outlines that overlap do not hide each other, only what is behind both. */
function seesBox(eye, target, boxes) {
  if (isInside(eye, target)) return true;
  if (boxes.some((box) => isInside(eye, box))) return false;
  const half = Math.min(eye.angle / 2, Math.PI);
  const mine = frontEdges(eye, target);
  const others = boxes.filter((box) => !overlap(box, target)).flatMap((box) => frontEdges(eye, box));
  return fronts([...mine, ...others], -half, half).some(([, , edge]) => mine.includes(edge));
}

// -- outlines, as the eye has them: it stands at the origin and looks along +x ------------------------------------------

const cross = (a, b) => a[0] * b[1] - a[1] * b[0];

function toEye(eye, [x, y]) {
  const [cos, sin, dx, dy] = [Math.cos(eye.heading), Math.sin(eye.heading), x - eye.x, y - eye.y];
  return [cos * dx + sin * dy, cos * dy - sin * dx];
}

function fromEye(eye, [x, y]) {
  const [cos, sin] = [Math.cos(eye.heading), Math.sin(eye.heading)];
  return [eye.x + cos * x - sin * y, eye.y + sin * x + cos * y];
}

/** Corners of a box in the world, anticlockwise. */
function cornersOf({ x, y, heading, length, width }) {
  const place = { x, y, heading };
  return [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([u, v]) => fromEye(place, [(u * length) / 2, (v * width) / 2]));
}

function isInside(eye, box) {
  const [x, y] = toEye(box, [eye.x, eye.y]);
  return Math.abs(x) < box.length / 2 - HAIR && Math.abs(y) < box.width / 2 - HAIR;
}

/** Whether two boxes have more than a border in common: no side of either parts them. */
function overlap(a, b) {
  const parted = (one, other) => {
    const places = cornersOf(other).map((corner) => toEye(one, corner));
    return [one.length, one.width].some((size, axis) => {
      const values = places.map((place) => place[axis]);
      return Math.min(...values) >= size / 2 - HAIR || Math.max(...values) <= HAIR - size / 2;
    });
  };
  return !parted(a, b) && !parted(b, a);
}

/** A box, or one that touches the eye and is moved away a little, so that it hides the half of the world behind it. */
function clear(eye, box) {
  const [x, y] = toEye(box, [eye.x, eye.y]);
  const [along, across] = [Math.abs(x) - box.length / 2, Math.abs(y) - box.width / 2];
  if (Math.max(along, across) > APART) return box;
  const away = along > across ? [-APART * Math.sign(x), 0] : [0, -APART * Math.sign(y)];
  const [left, low] = fromEye(box, away);
  return { ...box, x: left, y: low };
}

/** The sides of a box that face the eye, as far as its view reaches. */
function frontEdges(eye, box) {
  const corners = cornersOf(clear(eye, box)).map((corner) => toEye(eye, corner));
  return corners.flatMap((a, k) => {
    const b = corners[(k + 1) % 4];
    return cross(a, b) < -HAIR ? within(b, a, eye.distance) : [];
  });
}

/** The part of a side, from right to left, inside the circle of the view: one edge, two where it passes behind the eye. */
function within(a, b, radius) {
  const way = [b[0] - a[0], b[1] - a[1]];
  const square = way[0] ** 2 + way[1] ** 2;
  const middle = -(a[0] * way[0] + a[1] * way[1]) / square;
  const rest = radius ** 2 - cross(a, b) ** 2 / square;
  if (rest <= 0) return [];
  const reach = Math.sqrt(rest / square);
  const [start, end] = [Math.max(0, middle - reach), Math.min(1, middle + reach)];
  if (start >= end) return [];
  const [right, left] = [start, end].map((share) => {
    const [x, y] = [a[0] + share * way[0], a[1] + share * way[1]];
    return Math.atan2(y, x);
  });
  if (right <= left) return [{ a, way, right, left }];
  return [{ a, way, right, left: Math.PI }, { a, way, right: -Math.PI, left }];
}

// -- the nearest side in each direction ---------------------------------------------------------------------------------

/** How far away an edge is in a direction. */
function reachOf(edge, angle) {
  return cross(edge.a, edge.way) / cross([Math.cos(angle), Math.sin(angle)], edge.way);
}

function onEdge(edge, angle) {
  const reach = reachOf(edge, angle);
  return [reach * Math.cos(angle), reach * Math.sin(angle)];
}

function arc(radius, from, to) {
  const steps = Math.max(1, Math.ceil((to - from) / ARC));
  return Array.from({ length: steps + 1 }, (_, k) => {
    const angle = from + ((to - from) * k) / steps;
    return [radius * Math.cos(angle), radius * Math.sin(angle)];
  });
}

/** From right to left, each stretch of directions with the edge that is nearest there: [from, to, edge or undefined]. */
function fronts(edges, right, left) {
  const angles = [right, left, ...edges.flatMap((edge) => [edge.right, edge.left]), ...crossings(edges)];
  const cuts = angles.filter((angle) => angle >= right && angle <= left).sort((a, b) => a - b);
  const found = [];
  for (let k = 1; k < cuts.length; k++) {
    const [from, to] = [cuts[k - 1], cuts[k]];
    if (to - from < 1e-12) continue;
    const edge = nearest(edges, (from + to) / 2);
    const last = found.at(-1);
    if (last && last[2] === edge) last[1] = to;
    else found.push([from, to, edge]);
  }
  return found;
}

function nearest(edges, angle) {
  let [best, least] = [undefined, Infinity];
  for (const edge of edges) {
    if (angle < edge.right || angle > edge.left) continue;
    const reach = reachOf(edge, angle);
    if (reach < least) [best, least] = [edge, reach];
  }
  return best;
}

/** Directions in which two edges cross: of outlines that overlap. */
function crossings(edges) {
  const found = [];
  edges.forEach((one, k) => {
    for (const other of edges.slice(k + 1)) {
      if (one.right >= other.left || other.right >= one.left) continue;
      const steep = cross(one.way, other.way);
      if (Math.abs(steep) < HAIR) continue;
      const share = cross([other.a[0] - one.a[0], other.a[1] - one.a[1]], other.way) / steep;
      if (share >= 0 && share <= 1) found.push(Math.atan2(one.a[1] + share * one.way[1], one.a[0] + share * one.way[0]));
    }
  });
  return found;
}
