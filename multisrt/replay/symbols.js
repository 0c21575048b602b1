// The legend of the map: a sample and words for each thing that layers draw. The first of a layer
// stands beside its name, too.

const SAMPLE_WIDTH = 32, SAMPLE_HEIGHT = 18;
const OF_TEAMS = ["groups", "masters", "links", "messages"]; // layers that a robot alone does not have

// The outline of the mark of a base station, of size 1 around (0, 0).
const HOUSE = [[-0.8, -0.9], [0.8, -0.9], [0.8, 0.15], [1.2, 0.15], [0, 1.3], [-1.2, 0.15], [-0.8, 0.15]];

// [layer, words, paint(sample), whether it is of teams only, whether it is of base stations only]
const SYMBOLS = [
  ["truth", "free space, obstacle, wall", (s) => s.box(s.colours.free, s.colours.wall, s.colours.solid)],
  ["seen", "seen by a scan", (s) => s.box(s.colours.seen)],
  ["regions", "safe region, in the colour of the robot that was there first", (s) => s.box(s.area)],
  ["delivered", "known to the base station", (s) => s.box(s.colours.free).hatch(s.colours.delivered), false, true],
  ["trees", "edge of a tree, with a node", (s) => s.line(s.line1, 2).dot(22, 3.2, s.line1)],
  ["trees", "root of a tree", (s) => s.square(16, 4.5, s.line1)],
  ["bridges", "path between two nodes that no edge joins", (s) => s.line(s.line1, 1.8, [1.5, 2.5])],
  ["paths", "path that was driven", (s) => s.line(s.line1, 1)],
  ["paths", "rest of the present motion", (s) => s.line(s.colours.ink, 1.4, [4, 3])],
  ["frontier", "frontier", (s) => s.line(s.colours.frontier, 2.5)],
  ["frontier", "frontier arc that was given up", (s) => s.line(s.colours.ink, 2, [4, 2.5])],
  ["goals", "goal of a robot", (s) => s.line(s.line1, 1, [2, 3]).diamond(25, 5.5, s.line1, s.colours.paper)],
  ["goals", "place that the chosen robot considered", (s) => s.diamond(16, 3.5, s.colours.frontier)],
  ["bodies", "robot, with its heading", (s) => s.robot()],
  ["bodies", "cut off from all other robots", (s) => s.robot().ring(16, 8, s.colours.frontier, 2, [3, 3]), true],
  ["bodies", "dead", (s) => s.robot(s.colours.solid, s.colours.ink).cross(16, 7)],
  ["bodies", "not switched on yet", (s) => s.robot(s.colours.paper, s.line1, [2, 2])],
  ["bodies", "base station", (s) => s.house(16, 6.5, s.colours.ink), false, true],
  ["bodies", "chosen robot or node", (s) => s.ring(16, 7, s.colours.link, 3)],
  ["groups", "robots that are engaged (GER)", (s) => s.oval(s.colours.link, 1.8, [], 0.1)],
  ["groups", "robots that are pre-engaged (GPR)", (s) => s.oval(s.colours.link, 1.2, [3, 4])],
  ["masters", "master, with lines to its group", (s) => s.line(s.colours.link, 1.2, [1, 3]).badge("M")],
  ["links", "radio link", (s) => s.line(s.colours.radio, 1.5)],
  ["messages", "message to a robot that received it", (s) => s.arrow(s.colours.message)],
  ["messages", "message that was lost", (s) => s.arrow(s.colours.message, [3, 3])],
  ["stops", "protective stop", (s) => s.octagon(16, 7, s.colours.frontier, s.colours.paper)],
];

// A canvas of the size of some letters, on which a symbol is drawn.
class Sample {
  constructor(player) {
    this.player = player;
    const ratio = Math.min(2, Math.max(1, window.devicePixelRatio || 1));
    this.canvas = make("canvas", { width: SAMPLE_WIDTH * ratio, height: SAMPLE_HEIGHT * ratio });
    this.canvas.setAttribute("aria-hidden", "true");
    this.c = this.canvas.getContext("2d");
    this.c.scale(ratio, ratio);
  }

  paint(symbol) {
    const { colours, runs } = this.player;
    this.colours = colours;
    this.line1 = colours.lineOf(runs[0], 0);
    this.area = colours.areaOf(runs[0], 0);
    this.body = colours.bodyOf(runs[0], 0);
    this.c.clearRect(0, 0, SAMPLE_WIDTH, SAMPLE_HEIGHT);
    symbol(this);
  }

  hatch(colour) {
    const { c } = this;
    c.save();
    c.beginPath();
    c.rect(2, 2, 28, 14);
    c.clip();
    c.beginPath();
    for (let x = 9; x < 44; x += 7) {
      c.moveTo(x, 2);
      c.lineTo(x - 14, 16);
    }
    this.stroke(colour, 1);
    c.restore();
    return this;
  }

  stroke(colour, width, dashes = []) {
    Object.assign(this.c, { strokeStyle: colour, lineWidth: width });
    this.c.setLineDash(dashes);
    this.c.stroke();
    this.c.setLineDash([]);
    return this;
  }

  // A closed outline of points around a place, with a colour of its own within.
  shape(points, colour, within, width = 2) {
    this.c.beginPath();
    for (const [x, y] of points) this.c.lineTo(x, y);
    this.c.closePath();
    if (within) {
      this.c.fillStyle = within;
      this.c.fill();
    }
    return this.stroke(colour, width);
  }

  // An area; with walls and obstacles at its right end.
  box(colour, wall, solid) {
    const { c } = this;
    c.fillStyle = colour;
    c.fillRect(2, 2, 28, 14);
    if (!wall) return this;
    c.fillStyle = solid;
    c.fillRect(18, 2, 12, 14);
    c.beginPath();
    c.rect(2, 2, 16, 14);
    return this.stroke(wall, 1);
  }

  line(colour, width, dashes = []) {
    this.c.beginPath();
    this.c.moveTo(2, 9);
    this.c.lineTo(30, 9);
    return this.stroke(colour, width, dashes);
  }

  ring(x, radius, colour, width, dashes = []) {
    this.c.beginPath();
    this.c.arc(x, 9, radius, 0, 2 * Math.PI);
    return this.stroke(colour, width, dashes);
  }

  dot(x, radius, colour) {
    this.c.beginPath();
    this.c.arc(x, 9, radius, 0, 2 * Math.PI);
    this.c.fillStyle = colour;
    this.c.fill();
    return this;
  }

  square(x, half, colour) {
    this.c.fillStyle = colour;
    this.c.fillRect(x - half, 9 - half, 2 * half, 2 * half);
    return this;
  }

  diamond(x, size, colour, within) {
    return this.shape([[x + size, 9], [x, 9 - size], [x - size, 9], [x, 9 + size]], colour, within);
  }

  octagon(x, size, colour, within) {
    const angles = Array.from({ length: 8 }, (_, k) => Math.PI / 8 + (k * Math.PI) / 4);
    return this.shape(angles.map((angle) => [x + size * Math.cos(angle), 9 + size * Math.sin(angle)]), colour, within, 2.5);
  }

  house(x, size, colour) {
    return this.shape(HOUSE.map(([u, v]) => [x + size * u, 9 - size * v]), colour, colour, 1);
  }

  robot(fill = this.body.fill, edge = this.body.edge, dashes = []) {
    this.dot(16, 4.5, fill);
    this.ring(16, 4.5, edge, 1.5, dashes);
    this.c.beginPath();
    this.c.moveTo(16, 9);
    this.c.lineTo(22.5, 9);
    return this.stroke(colourOfHeading(this.colours, fill, edge), 1.5);
  }

  cross(x, size) {
    this.c.beginPath();
    this.c.moveTo(x - size, 9 - size);
    this.c.lineTo(x + size, 9 + size);
    this.c.moveTo(x - size, 9 + size);
    this.c.lineTo(x + size, 9 - size);
    return this.stroke(this.colours.ink, 1.8);
  }

  oval(colour, width, dashes, tint = 0) {
    const { c } = this;
    c.beginPath();
    c.ellipse(16, 9, 14, 7, 0, 0, 2 * Math.PI);
    c.globalAlpha = tint;
    c.fillStyle = colour;
    c.fill();
    c.globalAlpha = 1;
    return this.stroke(colour, width, dashes);
  }

  badge(letter) {
    this.dot(24, 6.5, this.colours.link);
    Object.assign(this.c, { font: '600 9px system-ui, "Liberation Sans", sans-serif', textAlign: "center", textBaseline: "middle", fillStyle: this.colours.paper });
    this.c.fillText(letter, 24, 9.5);
    return this;
  }

  arrow(colour, dashes = []) {
    const { c } = this;
    c.beginPath();
    c.moveTo(2, 9);
    c.lineTo(29, 9);
    this.stroke(colour, 1.6, dashes);
    c.beginPath();
    c.moveTo(23, 5.5);
    c.lineTo(29, 9);
    c.lineTo(23, 12.5);
    return this.stroke(colour, 1.6);
  }
}

// The symbols of the layers that some runs have.
function symbolsOf(runs) {
  const hasTeam = runs.some((run) => run.count > 1), hasBase = runs.some((run) => run.base);
  const hasRadio = (layer) => hasBase && ["links", "messages"].includes(layer);
  return SYMBOLS.filter(([layer, , , isOfTeams, isOfBases]) => (hasBase || !isOfBases) && (hasTeam || hasRadio(layer) || !(isOfTeams || OF_TEAMS.includes(layer))));
}
