"use strict";
// Numbers over time as a page holds them, and what they are between two samples.

const PER_METRE = 100;
const PER_RADIAN = 1000;
const PER_SPEED = 1000;

/** Numbers from a first value and differences; null stays null. */
function unpack(packed, scale) {
  let sum = 0;
  return packed.map((step) => (step === null ? null : (sum += step) / scale));
}

function unpackReplay(data) {
  const actors = data.actors.map((actor) => ({
    ...actor,
    x: unpack(actor.x, PER_METRE),
    y: unpack(actor.y, PER_METRE),
    heading: unpack(actor.heading, PER_RADIAN),
    speed: unpack(actor.speed, PER_SPEED),
  }));
  return { ...data, actors, distance: unpack(data.distance, PER_METRE), closing: unpack(data.closing, PER_SPEED) };
}

/** A series at a place between samples; null where there is no number on one side. */
function at(series, place) {
  const before = Math.floor(place);
  const after = Math.min(before + 1, series.length - 1);
  const a = series[before];
  const b = series[after];
  if (a === null || b === null) return place - before < 1e-9 ? a : null;
  return a + (b - a) * (place - before);
}

/** A series at a place, or where there was its last number before, or else its first one. */
function lastAt(series, place) {
  const now = at(series, place);
  if (now !== null) return now;
  const before = series.slice(0, Math.floor(place) + 1).findLast((value) => value !== null);
  return before ?? series.find((value) => value !== null) ?? null;
}
