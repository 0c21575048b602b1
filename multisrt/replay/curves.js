// Curves of coverage, isolation and distance against time, one line for each run.

const SAMPLES = 400;
const DASHES = [[], [5, 3], [2, 2], [8, 3, 2, 3]]; // of the runs
const VALUE_TICK_PX = 22; // between two labels of values, at least

class Curve extends Plot {
  constructor(player, element, title, curve) {
    super(player, element, title, `${title} against time`);
    this.curve = curve;
    this.figure.classList.add("curve");
  }

  paint(c) {
    const { colours, runs } = this.player, { unit } = this.curve;
    const most = Math.max(1, ...runs.map((run) => this.curve.most(run)));
    const y = (value) => this.bottom - (value / most) * this.height;
    c.strokeStyle = colours.line;
    c.lineWidth = 1;
    for (const level of ticksTo(most, this.height / VALUE_TICK_PX).filter((value) => Number.isInteger(value))) {
      this.line(c, GUTTER_PX, y(level), GUTTER_PX + this.width, y(level));
      this.text(c, withUnit(level, unit, most), GUTTER_PX - 5, y(level), "right");
    }
    runs.forEach((run, number) => {
      for (const [kind, colour, width] of this.curve.kinds) {
        c.strokeStyle = colours[colour];
        c.lineWidth = width;
        c.setLineDash(DASHES[number]);
        this.trace(c, run, kind, y);
        c.setLineDash([]);
      }
    });
  }

  trace(c, run, kind, y) {
    c.beginPath();
    for (let k = 0; k <= SAMPLES; k++) {
      const time = (run.end * k) / SAMPLES, value = this.curve.value(run, time, kind);
      if (value !== null) c.lineTo(this.x(time), y(value));
    }
    c.stroke();
  }

  say(time) {
    const texts = this.player.runs.map((run) => this.curve.text(run, Math.min(time, run.end)));
    this.value.textContent = texts.join(" | ");
  }
}

// A label of an axis; of long distances, in kilometres.
function withUnit(value, unit, most) {
  if (unit === "m" && most >= 10000) return `${value / 1000} km`;
  return unit ? `${value} ${unit}` : String(value);
}

function stepAt(t, values, time) {
  const row = lastBy(t, time);
  return row < 0 ? 0 : values[row];
}

function distanceBy(run, time) {
  let sum = 0;
  for (let robot = 0; robot < run.count; robot++) sum += run.driven(robot, time);
  return sum;
}

function titleOf({ title, ofAll, withBase }, runs) {
  if (withBase && runs.some((run) => run.base)) return withBase;
  return ofAll && runs.some((run) => run.count > 1) ? `${title}, ${ofAll}` : title;
}

// Without a limit of the radio nobody is cut off, unless radios fail; nor is a robot alone.
function canBeCutOff(run) {
  return run.count > 1 && (run.links !== null || Math.max(0, ...run.isolated.robots) > 0);
}

const CURVES = [
  {
    title: "Covered (seen: thin line)",
    withBase: "Covered (seen: grey, at the base: thin line)",
    unit: "%",
    isOf: (run) => run.coverage !== null,
    otherwise: "Coverage is not known: the recording has no scans.",
    kinds: [["seen", "soft", 1], ["coverage", "link", 2], ["delivered", "ink", 1]],
    most: () => 100,
    value: (run, time, kind) => (run.coverage && run.coverage[kind] ? 100 * stepAt(run.coverage.t, run.coverage[kind], time) : null),
    text: (run, time) => {
      const share = (kind) => `${(100 * stepAt(run.coverage.t, run.coverage[kind], time)).toFixed(1)} %`;
      if (!run.coverage) return "no scans";
      return run.coverage.delivered ? `${share("coverage")}, ${share("delivered")} at the base` : share("coverage");
    },
  },
  {
    title: "Robots cut off",
    unit: "",
    isOfTeams: true,
    isOf: canBeCutOff,
    otherwise: "No robot is ever cut off: radio unlimited.",
    kinds: [["", "frontier", 1.8]],
    most: (run) => Math.max(0, ...run.isolated.robots),
    value: (run, time) => (canBeCutOff(run) ? stepAt(run.isolated.t, run.isolated.robots, time) : null),
    text: (run, time) => (canBeCutOff(run) ? String(stepAt(run.isolated.t, run.isolated.robots, time)) : run.count > 1 ? "radio unlimited" : "one robot"),
  },
  {
    title: "Distance driven",
    ofAll: "all robots",
    unit: "m",
    isOf: () => true,
    kinds: [["", "ink", 1.8]],
    most: (run) => distanceBy(run, run.end),
    value: distanceBy,
    text: (run, time) => `${distanceBy(run, time).toFixed(0)} m`,
  },
];
