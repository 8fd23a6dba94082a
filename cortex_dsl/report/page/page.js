"use strict";
// The page around the replays: colours, one case at a time, and the map of all simulations.

function startTheme() {
  const button = document.querySelector(".theme");
  if (!button) return;
  const dark = () => {
    const chosen = document.documentElement.dataset.theme;
    return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  };
  const show = () => (button.textContent = dark() ? "light" : "dark");
  button.addEventListener("click", () => {
    document.documentElement.dataset.theme = dark() ? "light" : "dark";
    show();
    document.dispatchEvent(new Event("theme"));
  });
  show();
}

/** One case at a time; without this script, and in print, all of them stand below one another. */
function startCases() {
  const cases = [...document.querySelectorAll(".case")];
  const tabs = [...document.querySelectorAll(".case-tab")];
  if (cases.length < 2) return;
  const choose = (rank) => {
    for (const one of cases) one.classList.toggle("away", one.dataset.case !== rank);
    for (const tab of tabs) tab.setAttribute("aria-current", String(tab.dataset.case === rank));
  };
  for (const tab of tabs) {
    tab.addEventListener("click", (event) => {
      event.preventDefault();
      choose(tab.dataset.case);
    });
  }
  choose(cases[0].dataset.case);
}

/** Room around the map of all simulations for its axes [px]. */
const ROOM = { left: 84, right: 16, top: 24, bottom: 38 };

/** Along a gene's range: round numbers, or as many of its options as there is room for; [value, text] each. */
function ticks({ low, high, options }, most) {
  const stride = Math.ceil(options.length / most);
  if (stride) return options.map((text, k) => [k, text]).filter(([k]) => k % stride === 0);
  const raw = (high - low) / 5 || 1;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 2.5, 5, 10].find((s) => s * power >= raw * (1 - 1e-9));
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++)
    found.push([k * step, String(Number((k * step).toPrecision(6)))]);
  return found;
}

const short = (text, most) => (text.length > most ? `${text.slice(0, most - 1)}…` : text);

class Explorer {
  constructor(root, data) {
    this.data = data;
    this.canvas = root.querySelector("canvas");
    this.tip = root.querySelector(".tip");
    [this.across, this.up] = root.querySelectorAll("select");
    for (const select of [this.across, this.up]) select.addEventListener("change", () => this.draw());
    this.canvas.addEventListener("pointermove", (event) => this.point(event));
    this.canvas.addEventListener("pointerleave", () => (this.tip.textContent = this.tip.dataset.idle));
    addEventListener("resize", () => this.draw());
    document.addEventListener("theme", () => this.draw());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    this.draw();
  }

  get genes() {
    return [Number(this.across.value), Number(this.up.value)];
  }

  /** Canvas pixels of an individual. */
  place(row) {
    const [a, b] = this.genes;
    return [this.x(a, this.data.values[a][row]), this.y(b, this.data.values[b][row])];
  }

  x(gene, value) {
    const { low, high } = this.data.genes[gene];
    return ROOM.left + ((value - low) / (high - low || 1)) * (this.width - ROOM.left - ROOM.right);
  }

  y(gene, value) {
    const { low, high } = this.data.genes[gene];
    const bottom = this.height - ROOM.bottom;
    return bottom - ((value - low) / (high - low || 1)) * (bottom - ROOM.top);
  }

  /** Lines and numbers along both sides, and what they are of. */
  drawAxes(pen, style) {
    const [a, b] = this.genes;
    const [across, up] = [this.data.genes[a], this.data.genes[b]];
    const [right, bottom] = [this.width - ROOM.right, this.height - ROOM.bottom];
    const line = (...points) => {
      pen.beginPath();
      pen.moveTo(points[0], points[1]);
      pen.lineTo(points[2], points[3]);
      pen.stroke();
    };
    const say = (text, x, y, align) => {
      pen.textAlign = align;
      pen.fillText(text, x, y);
    };
    const name = ({ name, unit }) => (unit ? `${name} [${unit}]` : name);
    pen.strokeStyle = style.getPropertyValue("--line").trim();
    pen.fillStyle = style.getPropertyValue("--quiet").trim();
    pen.font = "11px system-ui, sans-serif";
    for (const [value, text] of ticks(across, 8)) {
      line(this.x(a, value), ROOM.top - 8, this.x(a, value), bottom + 6);
      say(short(text, 14), this.x(a, value), bottom + 18, "center");
    }
    for (const [value, text] of ticks(up, 14)) {
      line(ROOM.left - 6, this.y(b, value), right + 8, this.y(b, value));
      say(short(text, 12), ROOM.left - 10, this.y(b, value) + 4, "right");
    }
    say(name(across), right, this.height - 6, "right");
    say(name(up), 6, 12, "left");
  }

  draw() {
    const box = this.canvas.getBoundingClientRect();
    const ratio = devicePixelRatio || 1;
    [this.width, this.height] = [box.width, box.height];
    this.canvas.width = box.width * ratio;
    this.canvas.height = box.height * ratio;
    const pen = this.canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const style = getComputedStyle(this.canvas);
    this.drawAxes(pen, style);
    this.data.kinds.forEach(({ colour }, kind) => this.drawKind(pen, kind, style.getPropertyValue(colour).trim()));
  }

  drawKind(pen, kind, colour) {
    pen.fillStyle = pen.strokeStyle = colour;
    pen.globalAlpha = kind > 1 ? 0.75 : 0.55;
    this.data.kind.forEach((value, row) => {
      if (value !== kind) return;
      const [x, y] = this.place(row);
      pen.beginPath();
      if (kind === 0) {
        pen.moveTo(x - 2, y - 2);
        pen.lineTo(x + 2, y + 2);
        pen.moveTo(x - 2, y + 2);
        pen.lineTo(x + 2, y - 2);
        pen.stroke();
      } else {
        pen.arc(x, y, 2.4, 0, 2 * Math.PI);
        pen.fill();
      }
    });
  }

  point(event) {
    const box = this.canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    let best = -1;
    let least = 144;
    this.data.kind.forEach((_, row) => {
      const [px, py] = this.place(row);
      const apart = (px - x) ** 2 + (py - y) ** 2;
      if (apart < least) [best, least] = [row, apart];
    });
    this.tip.textContent = best < 0 ? this.tip.dataset.idle : this.words(best);
  }

  words(row) {
    const { genes, values, kinds, kind, score, place } = this.data;
    const risk = score[row] < 0 ? "" : `risk ${score[row]}`;
    const what = [kinds[kind[row]].words, risk].filter((text) => text).join(", ");
    const params = genes.map((gene, k) => {
      const value = gene.options.length ? gene.options[values[k][row]] : values[k][row];
      return `${gene.name} ${value}${gene.unit ? ` ${gene.unit}` : ""}`;
    });
    return `generation ${place[row][0] + 1}, place ${place[row][1] + 1}: ${what} · ${params.join(" · ")}`;
  }
}

function startExplorer() {
  const root = document.querySelector(".explorer");
  const block = document.getElementById("evaluations");
  if (root && block) new Explorer(root, JSON.parse(block.textContent));
}

startTheme();
startCases();
startExplorer();
