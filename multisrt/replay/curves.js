// Curves of coverage, isolation and distance, and strips of what robots did, with a cursor.

const SAMPLES = 400;
const DASHES = [[], [5, 3], [2, 2], [8, 3, 2, 3]]; // of the runs

// Styles of activities: a colour, and which part of the height they take, so that they also differ
// without colours.
const ACTIVITY_STYLES = {
  "moves": ["line", 0.9, false],
  "supports": ["link", 0.9, true],
  "coordinates": ["message", 0.6, false],
  "waits": ["solid", 0.3, false],
  "cut off": ["frontier", 0.75, true],
  "done": ["line", 0.08, false],
  "dead": ["ink", 0.2, true],
  "not started": ["line", 0.04, false],
};
// As in figures of activities.
const ACTIVITY_COLOURS = { moves: "#0072b2", supports: "#56b4e9", coordinates: "#e69f00", "cut off": "#b94600" };

class Plot {
  constructor(player, element, title, label) {
    this.player = player;
    this.width = 0;
    this.ratio = 1;
    this.figure = make("figure", { className: "chart" });
    this.value = make("b", {});
    this.plot = make("div", { className: "plot" });
    this.canvas = make("canvas", {});
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", label);
    this.cursor = make("div", { className: "cursor" });
    this.plot.append(this.canvas, this.cursor);
    this.figure.append(make("figcaption", {}, make("span", { textContent: title }), this.value), this.plot);
    element.append(this.figure);
    const seek = (event) => {
      const { left, width } = this.plot.getBoundingClientRect();
      player.seek((player.end * (event.clientX - left)) / width);
    };
    this.plot.addEventListener("pointerdown", (event) => {
      this.plot.setPointerCapture(event.pointerId);
      seek(event);
    });
    this.plot.addEventListener("pointermove", (event) => event.buttons && seek(event));
    new ResizeObserver(() => this.redraw()).observe(this.plot);
  }

  redraw() {
    const { width, height } = this.plot.getBoundingClientRect();
    if (!width) return;
    this.ratio = Math.min(2, window.devicePixelRatio || 1);
    this.width = Math.round(width * this.ratio);
    this.height = Math.round(height * this.ratio);
    Object.assign(this.canvas, { width: this.width, height: this.height });
    this.paint(this.canvas.getContext("2d"));
    this.follow(this.player.time);
  }

  x(time) {
    return this.player.end > 0 ? (time / this.player.end) * this.width : 0;
  }

  follow(time) {
    const share = this.player.end > 0 ? time / this.player.end : 0;
    this.cursor.style.transform = `translateX(${(share * this.width) / this.ratio}px)`;
  }

  say() {}
}

// One value against time for each run: steps, or a line between samples.
class Curve extends Plot {
  constructor(player, element, title, curve) {
    super(player, element, title, `${title} against time`);
    this.curve = curve;
  }

  get most() {
    return Math.max(1, ...this.player.runs.map((run) => this.curve.most(run)));
  }

  paint(c) {
    const { colours, runs } = this.player, most = this.most, pad = this.ratio * 2;
    const y = (value) => this.height - pad - (value / most) * (this.height - 2 * pad);
    c.strokeStyle = colours.line;
    c.lineWidth = this.ratio;
    for (const level of [0, 0.5, 1]) {
      c.beginPath();
      c.moveTo(0, y(level * most));
      c.lineTo(this.width, y(level * most));
      c.stroke();
    }
    runs.forEach((run, number) => {
      for (const [kind, colour, width] of this.curve.kinds || [["", "ink", 1.8]]) {
        c.beginPath();
        for (let k = 0; k <= SAMPLES; k++) {
          const time = (run.end * k) / SAMPLES, value = this.curve.value(run, time, kind);
          if (value !== null) c.lineTo(this.x(time), y(value));
        }
        c.strokeStyle = colours[colour];
        c.lineWidth = width * this.ratio;
        c.setLineDash(DASHES[number].map((length) => length * this.ratio));
        c.stroke();
        c.setLineDash([]);
      }
    });
  }

  say(time) {
    const { runs } = this.player;
    const texts = runs.map((run) => this.curve.text(run, Math.min(time, run.end)));
    this.value.textContent = texts.join(" | ");
  }
}

function stepAt(t, values, time) {
  const row = lastBy(t, time);
  return row < 0 ? 0 : values[row];
}

function percent(share) {
  return `${(100 * share).toFixed(1)} %`;
}

function distanceBy(run, time) {
  let sum = 0;
  for (let robot = 0; robot < run.count; robot++) sum += run.driven(robot, time);
  return sum;
}

const CURVES = [
  ["Covered (seen: thin)", {
    most: () => 1,
    kinds: [["seen", "soft", 1], ["coverage", "link", 2]],
    value: (run, time, kind) => (run.coverage ? stepAt(run.coverage.t, run.coverage[kind || "coverage"], time) : null),
    text: (run, time) => (run.coverage ? percent(stepAt(run.coverage.t, run.coverage.coverage, time)) : "no scans"),
  }],
  ["Robots cut off", {
    kinds: [["", "frontier", 1.8]],
    most: (run) => Math.max(0, ...run.isolated.robots),
    value: (run, time) => stepAt(run.isolated.t, run.isolated.robots, time),
    text: (run, time) => String(stepAt(run.isolated.t, run.isolated.robots, time)),
  }],
  ["Distance driven", {
    kinds: [["", "ink", 1.8]],
    most: (run) => distanceBy(run, run.end),
    value: distanceBy,
    text: (run, time) => `${distanceBy(run, time).toFixed(0)} m`,
  }],
];

// What each robot of a run did, one row a robot.
class Strip extends Plot {
  constructor(player, element, run) {
    super(player, element, player.runs.length > 1 ? `What robots did: ${run.title}` : "What robots did", `What each robot did when: ${run.title}`);
    this.run = run;
    this.row = Math.max(4, Math.min(13, Math.floor(140 / run.count)));
    this.plot.style.height = `${this.row * run.count}px`;
    this.figure.classList.add("strip");
    this.plot.addEventListener("click", (event) => {
      const robot = Math.floor((event.clientY - this.plot.getBoundingClientRect().top) / this.row);
      if (robot >= 0 && robot < run.count) player.choose(player.runs.indexOf(run), robot);
    });
  }

  paint(c) {
    const { run, player } = this, { names } = run.packed.activities, row = this.height / run.count;
    run.activities.forEach(({ t, what }, robot) => {
      for (let k = 0; k < t.length; k++) {
        const until = k + 1 < t.length ? t[k + 1] : run.end;
        paintActivity(c, player.colours, names[what[k]], this.x(t[k]), robot * row, this.x(until) - this.x(t[k]), row, this.ratio);
      }
    });
  }

  say(time) {
    const robot = this.player.robotOf(this.run);
    const what = robot === TEAM ? null : this.run.activity(robot, Math.min(time, this.run.end));
    this.value.textContent = what === null ? "" : `robot ${robot}: ${this.run.packed.activities.names[what]}`;
  }
}

function paintActivity(c, colours, name, x, top, width, row, ratio) {
  const [colour, share, isHatched] = ACTIVITY_STYLES[name];
  const height = Math.max(ratio, share * (row - ratio));
  const y = top + (row - height) / 2;
  c.fillStyle = ACTIVITY_COLOURS[name] || colours[colour];
  c.fillRect(x, y, Math.max(width, 0.5), height);
  if (!isHatched || width < 3 * ratio) return;
  c.save();
  c.beginPath();
  c.rect(x, y, width, height);
  c.clip();
  c.beginPath();
  for (let at = x - (x % (5 * ratio)) - height; at < x + width; at += 5 * ratio) {
    c.moveTo(at, y + height);
    c.lineTo(at + height, y);
  }
  c.strokeStyle = colours.paper;
  c.lineWidth = ratio;
  c.stroke();
  c.restore();
}

function activityKeys(player) {
  const list = make("ul", { className: "keys" });
  list.setAttribute("aria-label", "What the strips show");
  for (const name of player.runs[0].packed.activities.names) {
    const canvas = make("canvas", { width: 64, height: 28 });
    canvas.setAttribute("aria-hidden", "true");
    paintActivity(canvas.getContext("2d"), player.colours, name, 0, 0, 64, 28, 2);
    list.append(make("li", {}, canvas, name));
  }
  return list;
}

class Lines {
  constructor(player, curves, strips) {
    this.player = player;
    this.plots = CURVES.map(([title, curve]) => {
      const plot = new Curve(player, curves, title, curve);
      plot.figure.classList.add("curve");
      return plot;
    });
    this.plots.push(...player.runs.map((run) => new Strip(player, strips, run)));
    this.strips = strips;
    this.key = null;
  }

  redraw() {
    for (const plot of this.plots) plot.redraw();
    const key = activityKeys(this.player);
    if (this.key) this.key.replaceWith(key);
    else this.strips.append(key);
    this.key = key;
  }

  follow(time) {
    for (const plot of this.plots) plot.follow(time);
  }

  say(time) {
    for (const plot of this.plots) plot.say(time);
  }
}
