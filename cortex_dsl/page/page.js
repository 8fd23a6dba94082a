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
    const inside = (gene, size) => {
      const { low, high } = this.data.genes[gene];
      return 8 + ((this.data.values[gene][row] - low) / (high - low || 1)) * (size - 16);
    };
    return [inside(a, this.width), this.height - inside(b, this.height)];
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
    const colours = ["--invalid", "--safe-dot", "--hot"].map((name) => style.getPropertyValue(name).trim());
    for (const kind of [0, 1, 2]) this.drawKind(pen, kind, colours[kind]);
  }

  drawKind(pen, kind, colour) {
    pen.fillStyle = pen.strokeStyle = colour;
    pen.globalAlpha = kind === 2 ? 0.75 : 0.55;
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
    const { genes, values, kind, score, place } = this.data;
    const what = ["invalid", `risk ${score[row]}`, `collision, risk ${score[row]}`][kind[row]];
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
