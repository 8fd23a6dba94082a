"use strict";
// Replays: each .player shows the replay of its number in the embedded data. `camera.js` says which part of the world,
// `sight.js` what somebody sees of it.

const words = (value, digits) => (value === null ? "–" : value.toFixed(digits));

class Player {
  constructor(root, data) {
    this.root = root;
    this.data = unpackReplay(data);
    this.last = data.samples - 1;
    this.place = clamp(data.key / data.step, 0, this.last);
    this.fresh = true;
    this.rate = 1;
    this.running = false;
    this.closeUp = false;
    this.viewer = -1;
    this.find();
    this.listen();
    this.draw();
  }

  find() {
    const one = (selector) => this.root.querySelector(selector);
    this.svg = one("svg.scene");
    this.compass = one(".compass");
    this.sight = one(".sight");
    this.actors = [...this.root.querySelectorAll(".actors .actor")];
    this.signals = [...this.root.querySelectorAll(".road .signal")];
    this.group = one(".actors");
    this.contact = one(".contact");
    this.ghosts = one(".ghosts");
    this.note = one(".after-note");
    this.scrub = one(".scrub");
    this.clock = one(".clock");
    this.button = one(".play");
    this.cursors = [...this.root.querySelectorAll(".chart")].map((chart) => ({
      cursor: chart.querySelector(".cursor"),
      low: Number(chart.dataset.low),
      high: Number(chart.dataset.high),
      start: Number(chart.dataset.start),
      end: Number(chart.dataset.end),
    }));
    this.readings = [...this.root.querySelectorAll("[data-reading]")];
  }

  listen() {
    const { root } = this;
    this.button.addEventListener("click", () => this.toggle());
    this.scrub.addEventListener("input", () => this.go(Number(this.scrub.value)));
    for (const button of root.querySelectorAll(".step")) {
      button.addEventListener("click", () => this.step(Number(button.dataset.by)));
    }
    for (const button of root.querySelectorAll(".speed")) {
      button.addEventListener("click", () => this.setRate(Number(button.dataset.speed)));
    }
    root.querySelector(".zoom").addEventListener("click", () => this.toggleZoom());
    root.querySelector(".see").addEventListener("click", () => this.nextViewer());
    for (const chip of root.querySelectorAll(".chip")) {
      chip.addEventListener("click", () => this.toggleViewer(Number(chip.dataset.viewer)));
    }
    new ResizeObserver(() => this.drawFrame()).observe(this.svg);
    for (const chart of root.querySelectorAll(".plot .chart")) {
      chart.addEventListener("pointerdown", (event) => this.pick(chart, event));
      chart.addEventListener("pointermove", (event) => event.buttons && this.pick(chart, event));
    }
    const moments = root.closest(".case")?.querySelectorAll("[data-time]") ?? [];
    for (const moment of moments) {
      moment.addEventListener("click", () => this.go(Number(moment.dataset.time) / this.data.step));
    }
  }

  /** Go to where a chart was pressed. */
  pick(chart, event) {
    const box = chart.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * chart.viewBox.baseVal.width;
    const { low, high, start, end } = chart.dataset;
    const time = Number(low) + ((x - start) / (end - start)) * (high - low);
    this.go(time / this.data.step);
  }

  go(place) {
    this.pause();
    this.fresh = false;
    this.place = clamp(place, 0, this.last);
    this.draw();
  }

  step(by) {
    this.go(by > 0 ? Math.floor(this.place + 1e-6) + by : Math.ceil(this.place - 1e-6) + by);
  }

  toggle() {
    if (this.running) this.pause();
    else this.play();
  }

  play() {
    if (this.fresh || this.place >= this.last) this.place = 0;
    this.fresh = false;
    this.running = true;
    this.before = null;
    this.showState();
    requestAnimationFrame((now) => this.tick(now));
  }

  pause() {
    this.running = false;
    this.showState();
  }

  tick(now) {
    if (!this.running) return;
    if (this.root.offsetParent === null) this.pause(); // another case is shown
    if (this.before !== null) {
      this.place = Math.min(this.last, this.place + (((now - this.before) / 1000) * this.rate) / this.data.step);
    }
    this.before = now;
    this.draw();
    if (this.place >= this.last) this.pause();
    else requestAnimationFrame((next) => this.tick(next));
  }

  setRate(rate) {
    this.rate = rate;
    for (const button of this.root.querySelectorAll(".speed")) {
      button.setAttribute("aria-pressed", String(Number(button.dataset.speed) === rate));
    }
  }

  nextRate(by) {
    const rates = [...this.root.querySelectorAll(".speed")].map((button) => Number(button.dataset.speed));
    this.setRate(rates[clamp(rates.indexOf(this.rate) + by, 0, rates.length - 1)]);
  }

  toggleZoom() {
    this.closeUp = !this.closeUp;
    this.root.querySelector(".zoom").setAttribute("aria-pressed", String(this.closeUp));
    this.draw();
  }

  /** Show what somebody sees (-1: nobody), or no longer. */
  toggleViewer(actor) {
    this.viewer = this.viewer === actor ? -1 : actor;
    for (const chip of this.root.querySelectorAll(".chip")) {
      chip.setAttribute("aria-pressed", String(Number(chip.dataset.viewer) === this.viewer));
    }
    this.root.querySelector(".see").setAttribute("aria-pressed", String(this.viewer >= 0));
    this.draw();
  }

  /** The ego, then everybody else, then nobody. */
  nextViewer() {
    this.toggleViewer(this.viewer + 1 < this.data.actors.length ? this.viewer + 1 : this.viewer);
  }

  showState() {
    this.button.textContent = this.running ? "❚❚" : "▶";
    this.button.setAttribute("aria-pressed", String(this.running));
  }

  get time() {
    return this.place * this.data.step;
  }

  /** Whether physics after contact is shown: what is drawn then was not scored. */
  get after() {
    return this.data.contact >= 0 && this.time > this.data.key + 1e-6;
  }

  /** A series at this place. Between the last sample before contact and the next it is what it was before the blow,
   * and then what it is after it: nothing lies in between. */
  now(series) {
    const { contact } = this.data;
    if (contact < 0 || this.place <= contact || this.place >= contact + 1) return at(series, this.place);
    return series[this.after ? contact + 1 : contact];
  }

  /** How far the pair is apart: down to 0 at contact, which lies between two samples; where others touch, as before. */
  distance() {
    const { contact, key, step, touched, distance } = this.data;
    const beyond = this.place - contact;
    if (contact < 1 || this.after || beyond <= 0 || distance[contact] === null) return this.now(distance);
    if (touched) return distance[contact] * (1 - beyond / (key / step - contact));
    return distance[contact] + beyond * (distance[contact] - (distance[contact - 1] ?? distance[contact]));
  }

  draw() {
    for (const node of this.actors) this.drawActor(node);
    this.signals.forEach((node, k) => this.drawSignal(node, this.data.signals[k]));
    this.drawSight();
    this.group.classList.toggle("after", this.after);
    const met = this.data.contact >= 0 && this.time >= this.data.key - 1e-6;
    if (this.contact) this.contact.style.display = met ? "" : "none";
    if (this.ghosts) this.ghosts.style.display = this.after ? "" : "none";
    this.note.hidden = !this.after;
    this.drawFrame();
    this.drawCursors();
    this.scrub.value = String(this.place);
    this.clock.textContent = `${this.time.toFixed(2)} s`;
    this.scrub.setAttribute("aria-valuetext", this.clock.textContent);
  }

  /** What a light shows now, of the colours from whose times on it does. */
  drawSignal(node, changes) {
    const [, colour] = changes.findLast(([from]) => from <= this.time + 1e-6) ?? changes[0];
    node.setAttribute("class", `signal ${colour}`);
  }

  drawActor(node) {
    const box = this.boxOf(this.data.actors[Number(node.dataset.actor)]);
    if (!box) {
      node.setAttribute("display", "none");
      return;
    }
    node.removeAttribute("display");
    const degrees = (box.heading * 180) / Math.PI;
    node.setAttribute("transform", `translate(${box.x.toFixed(3)} ${box.y.toFixed(3)}) rotate(${degrees.toFixed(2)})`);
  }

  /** Where an actor stands and how it is turned, as a box; null while it takes no part. */
  boxOf(actor) {
    const [x, y, heading] = [actor.x, actor.y, actor.heading].map((series) => at(series, this.place));
    const [length, width] = actor.outline;
    return x === null || y === null || heading === null ? null : { x, y, heading, length, width };
  }

  /** What the viewer sees, and the shadows in it; whom it does not see is faint. */
  drawSight() {
    const boxes = this.data.actors.map((actor) => this.boxOf(actor));
    const viewer = boxes[this.viewer];
    const shown = this.viewer >= 0 && viewer;
    this.sight.style.display = shown ? "" : "none";
    for (const node of this.actors) node.classList.remove("unseen");
    if (!shown) return;
    const [angle, distance] = this.data.actors[this.viewer].view;
    const eye = { ...viewer, angle, distance };
    const hiding = (k) => k !== this.viewer && this.data.actors[k].hides && boxes[k];
    const shades = (but) => [...boxes.filter((_, k) => k !== but && hiding(k)), ...this.data.buildings];
    const [area, sector] = [visibleArea(eye, shades(-1)), sectorOf(eye)].map(pathOf);
    this.sight.setAttribute("class", `sight ${this.root.querySelectorAll(".chip")[this.viewer].dataset.colour}`);
    this.sight.querySelector(".shadow").setAttribute("d", sector + area);
    this.sight.querySelector(".seen").setAttribute("d", area);
    for (const node of this.actors) {
      const k = Number(node.dataset.actor);
      const hidden = k !== this.viewer && boxes[k] && !seesBox(eye, boxes[k], shades(k));
      node.classList.toggle("unseen", Boolean(hidden));
    }
  }

  drawFrame() {
    const { clientWidth, clientHeight } = this.svg;
    const { frame, heading } = this.data;
    const shape = clientWidth && clientHeight ? clientWidth / clientHeight : frame[2] / frame[3];
    const whole = fitted(frame, shape);
    const box = this.closeUp ? this.closeUpBox(whole, shape, heading) : whole;
    this.svg.setAttribute("viewBox", box.map((value) => value.toFixed(3)).join(" "));
    placeCompass(this.compass, box, clientWidth || 725);
  }

  /** Around the ego, where it is or last was. */
  closeUpBox(whole, shape, heading) {
    const place = ({ x, y }, reader) => [reader(x, this.place), reader(y, this.place)];
    const [ego, ...others] = this.data.actors;
    const here = place(ego, lastAt);
    if (here.includes(null)) return whole;
    const there = others.map((other) => place(other, at)).filter((each) => !each.includes(null));
    return closeUpOf(toPicture(here, heading), there.map((each) => toPicture(each, heading)), whole, shape);
  }

  drawCursors() {
    for (const { cursor, low, high, start, end } of this.cursors) {
      const x = start + ((this.time - low) / (high - low)) * (end - start);
      cursor?.setAttribute("transform", `translate(${x.toFixed(1)} 0)`);
    }
    for (const reading of this.readings) {
      const [name, index] = reading.dataset.reading.split(":");
      reading.textContent = this.reading(name, Number(index));
    }
  }

  reading(name, index) {
    const times = (value, scale) => (value === null ? null : value * scale);
    const scale = this.data.speed_per_si;
    if (name === "speed") return words(times(this.now(this.data.actors[index].speed), scale), 1);
    if (name === "distance") return words(this.distance(), 2);
    return words(times(this.now(this.data.closing), scale), 1);
  }
}

/** Points [x, y] as a closed path of SVG; nothing for none. */
const pathOf = (points) => (points.length ? `M${points.map((point) => point.map((v) => v.toFixed(2)).join(" ")).join("L")}Z` : "");

const KEYS = {
  " ": (player) => player.toggle(),
  k: (player) => player.toggle(),
  ArrowLeft: (player, event) => player.step(event.shiftKey ? -10 : -1),
  ArrowRight: (player, event) => player.step(event.shiftKey ? 10 : 1),
  Home: (player) => player.go(0),
  End: (player) => player.go(player.last),
  "+": (player) => player.nextRate(1),
  "=": (player) => player.nextRate(1),
  "-": (player) => player.nextRate(-1),
  c: (player) => player.toggleZoom(),
  v: (player) => player.nextViewer(),
};

/** The player that a key is meant for: the one with the focus, or else the one that fills the view. */
function meantPlayer(players, target) {
  const focused = players.find((player) => player.root.contains(target));
  if (focused) return focused;
  if (target !== document.body) return undefined;
  return players.find((player) => {
    const box = player.root.getBoundingClientRect();
    const shown = Math.min(box.bottom, innerHeight) - Math.max(box.top, 0);
    return box.height > 0 && shown > 0.5 * Math.min(box.height, innerHeight);
  });
}

function listenToKeys(players) {
  document.addEventListener("keydown", (event) => {
    const act = KEYS[event.key];
    if (!act || event.ctrlKey || event.altKey || event.metaKey) return;
    const player = meantPlayer(players, event.target);
    const button = event.target instanceof HTMLButtonElement;
    if (!player || (button && event.key === " ")) return;
    event.preventDefault();
    act(player, event);
  });
}

function startReplays() {
  const block = document.getElementById("replays");
  if (!block) return;
  const data = JSON.parse(block.textContent);
  const roots = [...document.querySelectorAll("[data-replay]")];
  const players = roots.map((root) => new Player(root, data[Number(root.dataset.replay)]));
  listenToKeys(players);
}

startReplays();
