"use strict";
// Which part of the picture is shown: all of it, or a close-up that follows the ego. Pure functions, and the compass.
// Pictures are turned by their heading; a box is [left, top, width, height] in metres, its y pointing down, as in SVG.

/** Height of the world in close-up [m]. */
const CLOSE = 24;
/** Somebody nearer to the ego than NEAR draws the close-up's middle to itself, and nobody beyond FAR does [m]. */
const NEAR = 10;
const FAR = 26;
/** Pixels that the bar of the scale may take, and the least between the corner and what stands there. */
const BAR = 140;
const CORNER = 14;

const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

/** A place of the world [x, y] in a picture whose right is the world's direction `heading`, y down. */
function toPicture([x, y], heading) {
  const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
  return [cos * x + sin * y, sin * x - cos * y];
}

/** The smallest box of the shape of a stage, width over height, that shows a box in its middle. */
function fitted([left, top, width, height], shape) {
  const wide = Math.max(width, height * shape);
  const high = wide / shape;
  return [left - (wide - width) / 2, top - (high - height) / 2, wide, high];
}

/** The middle of the close-up: the ego's place, drawn towards those who are near. It never jumps: whoever comes nearer
 * counts for more, from nothing at FAR. */
function middleOf(ego, others) {
  let [x, y, weights] = [0, 0, 0];
  for (const other of others) {
    const [dx, dy] = [other[0] - ego[0], other[1] - ego[1]];
    const weight = clamp((FAR - Math.hypot(dx, dy)) / (FAR - NEAR), 0, 1);
    [x, y, weights] = [x + weight * dx, y + weight * dy, weights + weight];
  }
  return [ego[0] + x / (1 + weights), ego[1] + y / (1 + weights)];
}

/** The close-up around a middle in a stage of a shape: the ego stays well inside, and it is never more than `whole`. */
function closeUpOf(ego, others, whole, shape) {
  const height = Math.min(CLOSE, whole[3]);
  const width = height * shape;
  const middle = middleOf(ego, others);
  const [x, y] = [width, height].map((size, axis) => clamp(middle[axis], ego[axis] - size / 4, ego[axis] + size / 4));
  return [x - width / 2, y - height / 2, width, height];
}

/** The longest round length whose bar is not too long [m]; `pixel` is what one shows [m]. */
function barLength(pixel) {
  let best = 1;
  for (let power = 1; power <= 1e5; power *= 10)
    for (const digit of [1, 2, 5]) if (digit * power <= BAR * pixel) best = digit * power;
  return best;
}

/** North arrow and bar stay in the corner of what is shown, as large as ever, and the bar stays true. */
function placeCompass(compass, [left, top, width, height], pixels) {
  if (!compass) return;
  const pixel = width / pixels;
  const [length, end] = [barLength(pixel), 48 + barLength(pixel) / pixel];
  const corner = [left + CORNER * pixel, top + height - CORNER * pixel].map((value) => value.toFixed(3));
  compass.setAttribute("transform", `translate(${corner.join(" ")}) scale(${pixel.toFixed(6)})`);
  compass.querySelector(".bar").setAttribute("d", `M48-5V0H${end.toFixed(1)}V-5`);
  compass.querySelector(".length").textContent = `${length} m`;
  compass.querySelector("title").textContent = `north, and a bar of ${length} m`;
}
