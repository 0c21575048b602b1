// Strips of what each robot of a run did, one row a robot.

const ROW_PX = 14;
const MIN_ROW_PX = 4;
const ROWS_PX = 170; // of all rows of a large team
const NUMBER_PX = 12; // between the numbers of two rows, at least
const CUT_OFF = 0.2; // of a row: a bar below the activity while a robot is cut off

// Activities differ in colour, in the part of the height that they take, and in hatches; the
// colours are those of figures of activities.
const ACTIVITY_STYLES = {
  "moves": { colour: "#0072b2", share: 0.9 },
  "supports": { colour: "#56b4e9", share: 0.9, isHatched: true },
  "coordinates": { colour: "#e69f00", share: 0.6 },
  "waits": { colour: "solid", share: 0.3 },
  "done": { colour: "soft", share: 0.75, isHollow: true },
  "dead": { colour: "ink", share: 0.2 },
  "not started": { colour: "soft", share: 0, isDotted: true },
};

class Strip extends Plot {
  constructor(player, element, run) {
    super(player, element, player.runs.length > 1 ? `What robots did: ${run.title}` : "What robots did", `What each robot did when: ${run.title}`);
    this.run = run;
    this.row = Math.max(MIN_ROW_PX, Math.min(ROW_PX, Math.floor(ROWS_PX / run.count)));
    this.plot.style.height = `${this.row * run.count + TOP_PX + BOTTOM_PX}px`;
    this.figure.classList.add("strip");
    this.plot.addEventListener("click", (event) => {
      const robot = Math.floor((event.clientY - this.plot.getBoundingClientRect().top - TOP_PX) / this.row);
      if (robot >= 0 && robot < run.count) player.choose(player.runs.indexOf(run), robot);
    });
  }

  paint(c) {
    const { run, player, row } = this, { names } = run.packed.activities;
    const every = [1, 2, 5, 10, 20, 50].find((step) => step * row >= NUMBER_PX);
    const bar = canBeCutOff(run) ? Math.max(1, Math.round(CUT_OFF * row)) : 0;
    run.activities.forEach(({ t, what }, robot) => {
      const top = TOP_PX + robot * row;
      if (robot % every === 0) this.text(c, String(robot), GUTTER_PX - 5, top + row / 2, "right");
      for (let k = 0; k < t.length; k++) {
        const until = k + 1 < t.length ? t[k + 1] : run.end;
        paintActivity(c, player.colours, names[what[k]], this.x(t[k]), top, this.x(until) - this.x(t[k]), row - bar);
      }
      const { begin, end } = run.cutOff[robot];
      c.fillStyle = player.colours.frontier;
      for (let k = 0; k < begin.length; k++) c.fillRect(this.x(begin[k]), top + row - 1 - bar, Math.max(1, this.x(end[k]) - this.x(begin[k])), bar);
    });
    this.text(c, "robot", 2, TOP_PX + row / 2, "left");
  }

  say(time) {
    const robot = this.player.robotOf(this.run);
    this.value.textContent = robot === TEAM ? "" : `robot ${robot}: ${this.run.doing(robot, Math.min(time, this.run.end))}`;
  }
}

function paintActivity(c, colours, name, x, top, width, row) {
  const { colour, share, isHatched, isHollow, isDotted } = ACTIVITY_STYLES[name];
  const height = Math.max(1, share * (row - 1)), y = top + (row - height) / 2;
  c.fillStyle = c.strokeStyle = colours[colour] || colour;
  c.lineWidth = 1;
  if (isDotted) dotted(c, x, top + row / 2, width);
  else if (isHollow) c.strokeRect(x + 0.5, y + 0.5, Math.max(0, width - 1), Math.max(0, height - 1));
  else c.fillRect(x, y, Math.max(width, 0.5), height);
  if (isHatched && width >= 3) hatch(c, colours.paper, x, y, width, height);
}

function dotted(c, x, y, width) {
  c.beginPath();
  c.moveTo(x, y);
  c.lineTo(x + width, y);
  c.setLineDash([1.5, 3]);
  c.stroke();
  c.setLineDash([]);
}

function hatch(c, paper, x, y, width, height) {
  c.save();
  c.beginPath();
  c.rect(x, y, width, height);
  c.clip();
  c.beginPath();
  for (let at = x - (x % 5) - height; at < x + width; at += 5) {
    c.moveTo(at, y + height);
    c.lineTo(at + height, y);
  }
  c.strokeStyle = paper;
  c.stroke();
  c.restore();
}

function activityKeys(player) {
  const list = make("ul", { className: "keys" });
  list.setAttribute("aria-label", "What the strips show");
  const add = (name, paint) => {
    const canvas = make("canvas", { width: 64, height: 28 }), context = canvas.getContext("2d");
    canvas.setAttribute("aria-hidden", "true");
    context.scale(2, 2);
    paint(context);
    list.append(make("li", {}, canvas, name));
  };
  for (const name of player.runs[0].packed.activities.names) {
    add(name, (c) => paintActivity(c, player.colours, name, 0, 0, 32, ROW_PX));
  }
  if (player.runs.some(canBeCutOff)) {
    add("cut off (below)", (c) => {
      c.fillStyle = player.colours.frontier;
      c.fillRect(0, 10, 32, 3);
    });
  }
  return list;
}

// Which line of the curves is which run.
function runKeys({ runs, colours }) {
  const list = make("ul", { className: "keys" });
  list.setAttribute("aria-label", "Lines of the curves");
  runs.forEach((run, number) => {
    const canvas = make("canvas", { width: 64, height: 28 }), context = canvas.getContext("2d");
    canvas.setAttribute("aria-hidden", "true");
    context.scale(2, 2);
    context.strokeStyle = colours.ink;
    context.lineWidth = 1.8;
    context.setLineDash(DASHES[number]);
    context.beginPath();
    context.moveTo(0, 7);
    context.lineTo(32, 7);
    context.stroke();
    list.append(make("li", {}, canvas, run.title));
  });
  return list;
}

// All curves and strips.
class Lines {
  constructor(player, curves, strips) {
    this.player = player;
    const shown = CURVES.filter(({ isOf }) => player.runs.some(isOf));
    curves.style.setProperty("--curves", shown.length);
    this.plots = shown.map((curve) => new Curve(player, curves, titleOf(curve, player.runs), curve));
    const hasTeam = player.runs.some((run) => run.count > 1);
    for (const curve of CURVES) if (!shown.includes(curve) && (hasTeam || !curve.isOfTeams)) curves.append(make("p", { className: "without", textContent: curve.otherwise }));
    this.plots.push(...player.runs.map((run) => new Strip(player, strips, run)));
    this.keys = [];
    this.places = [[curves, runKeys], [strips, activityKeys]].slice(player.runs.length > 1 ? 0 : 1);
  }

  redraw() {
    for (const plot of this.plots) plot.redraw();
    for (const key of this.keys) key.remove();
    this.keys = this.places.map(([element, keys]) => keys(this.player));
    this.places.forEach(([element], k) => element.append(this.keys[k]));
  }

  follow(time) {
    for (const plot of this.plots) plot.follow(time);
  }

  say(time) {
    for (const plot of this.plots) plot.say(time);
  }
}
