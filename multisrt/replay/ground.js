// What only grows with time is drawn once, into canvases of its own: what was seen, safe regions,
// trees, paths. Copies from time to time make it cheap to go back.

const SLICE_MS = 12; // per frame and map
const COPY_PIXELS = 3e7; // bound of the memory of copies
const MIN_ITEMS = 300; // between two copies

class Growing {
  // `items` are {t: times}; `paint(context, number)` draws one of them.
  constructor(view, items, paint) {
    Object.assign(this, { view, items, paint, done: 0, copies: [], version: -1 });
    this.canvas = document.createElement("canvas");
  }

  restart() {
    const { width, height, version, left, bottom, scale } = this.view;
    if (this.version >= 0 && this.shown) this.stale = { ...this.shown, canvas: this.copyOf(this.canvas) };
    Object.assign(this.canvas, { width, height });
    this.context = this.canvas.getContext("2d");
    this.version = version;
    this.done = 0;
    this.copies = [];
    this.placed = { left, bottom, scale };
    const room = Math.max(2, Math.floor(COPY_PIXELS / 4 / (width * height)));
    this.every = Math.max(MIN_ITEMS, Math.ceil(this.items.t.length / room));
  }

  copyOf(canvas) {
    const copy = document.createElement("canvas");
    Object.assign(copy, { width: canvas.width, height: canvas.height });
    if (canvas.width) copy.getContext("2d").drawImage(canvas, 0, 0);
    return copy;
  }

  // Draw what is there at a time, until a moment; returns whether all of it is drawn.
  advance(time, until) {
    if (this.version !== this.view.version) this.restart();
    const wanted = lastBy(this.items.t, time) + 1;
    if (wanted < this.done) this.goBack(wanted);
    while (this.done < wanted) {
      this.paint(this.context, this.done++);
      if (this.done % this.every === 0 && !this.copies.some((copy) => copy.done === this.done)) {
        this.copies.push({ done: this.done, canvas: this.copyOf(this.canvas) });
      }
      if (this.done % 16 === 0 && performance.now() > until) break;
    }
    if (this.done < wanted) return false;
    this.stale = null;
    this.shown = this.placed;
    return true;
  }

  goBack(wanted) {
    const from = this.copies.filter((copy) => copy.done <= wanted).pop();
    this.context.globalCompositeOperation = "source-over";
    this.context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (from) this.context.drawImage(from.canvas, 0, 0);
    this.done = from ? from.done : 0;
  }

  // While a map that was moved or zoomed is drawn anew, the old picture stands in for it.
  show(context) {
    const { stale, view } = this;
    if (!stale) {
      context.drawImage(this.canvas, 0, 0);
      return;
    }
    const zoom = view.scale / stale.scale, { width, height } = stale.canvas;
    const x = (stale.left - view.left) * view.scale;
    const y = view.height - (stale.bottom - view.bottom) * view.scale - height * zoom;
    context.drawImage(stale.canvas, x, y, width * zoom, height * zoom);
  }
}

class Ground {
  constructor(view) {
    this.view = view;
    this.key = "";
  }

  layers() {
    const { run, player } = this.view, robot = player.robotOf(run);
    const known = run.knownBy(robot), scans = run.scansOf(robot);
    const legs = legsOf(run, robot), bridges = bridgesOf(run, robot);
    return {
      seen: new Growing(this.view, scans, (c, k) => this.paintSeen(c, scans.rows[k])),
      regions: new Growing(this.view, known, (c, k) => this.paintRegion(c, known.nodes[k])),
      paths: new Growing(this.view, legs, (c, k) => this.paintLeg(c, legs.robot[k], legs.to[k])),
      bridges: new Growing(this.view, bridges, (c, k) => this.paintBridge(c, bridges.rows[k])),
      trees: new Growing(this.view, known, (c, k) => this.paintNode(c, known.nodes[k], known.since)),
    };
  }

  draw(time) {
    const { view } = this, { run, player } = view;
    const key = `${player.robotOf(run)} ${player.colours.key}`;
    if (key !== this.key) {
      this.growing = this.layers();
      this.key = key;
      this.drawn = "";
    }
    const until = performance.now() + SLICE_MS;
    let isDone = true;
    const shown = Object.keys(this.growing).filter((name) => player.layers.has(name));
    for (const name of shown) isDone = this.growing[name].advance(time, until) && isDone;
    const drawn = [view.version, [...player.layers].join(), ...shown.map((name) => this.growing[name].done)].join(" ");
    if (drawn !== this.drawn || !isDone) this.compose(shown);
    this.drawn = drawn;
    return isDone;
  }

  compose(shown) {
    const { view } = this, { colours, layers } = view.player;
    const context = view.below.getContext("2d");
    const isTrue = layers.has("truth");
    if (isTrue) this.drawWorld();
    if (isTrue) context.drawImage(this.free, 0, 0);
    else {
      context.fillStyle = colours.free;
      context.fillRect(0, 0, view.width, view.height);
    }
    for (const name of ["seen", "regions"]) if (shown.includes(name)) this.growing[name].show(context);
    if (isTrue) context.drawImage(this.walls, 0, 0);
    for (const name of ["paths", "bridges", "trees"]) if (shown.includes(name)) this.growing[name].show(context);
  }

  // Free space and walls: two pictures, as what robots saw lies between.
  drawWorld() {
    const { view } = this, { colours } = view.player, key = `${view.version} ${colours.key}`;
    if (key === this.worldKey) return;
    this.worldKey = key;
    [this.free, this.walls] = [0, 1].map(() => make("canvas", { width: view.width, height: view.height }));
    const below = this.free.getContext("2d"), above = this.walls.getContext("2d");
    below.fillStyle = colours.solid;
    below.fillRect(0, 0, view.width, view.height);
    this.world(below);
    below.fillStyle = colours.free;
    below.fill("evenodd");
    this.world(above);
    above.strokeStyle = colours.wall;
    above.lineWidth = view.px(1);
    above.stroke();
  }

  outline(context, outlines, number) {
    const { view } = this, { first, x, y } = outlines;
    for (let i = first[number]; i < first[number + 1]; i++) {
      if (i === first[number]) context.moveTo(view.x(x[i]), view.y(y[i]));
      else context.lineTo(view.x(x[i]), view.y(y[i]));
    }
    context.closePath();
  }

  world(context) {
    const { rings } = this.view.run;
    context.beginPath();
    for (let ring = 0; ring + 1 < rings.first.length; ring++) this.outline(context, rings, ring);
  }

  paintSeen(context, row) {
    const { scans, nodes } = this.view.run, node = scans.node[row];
    context.fillStyle = context.strokeStyle = this.view.player.colours.seen;
    context.lineWidth = this.view.px(0.7);
    context.beginPath();
    this.outline(context, node < 0 ? scans.region : nodes.region, node < 0 ? scans.number[row] : node);
    context.fill();
    context.stroke();
  }

  // Below what is there already: an area has the colour of the robot that was there first.
  paintRegion(context, node) {
    const { run, player } = this.view;
    context.globalCompositeOperation = "destination-over";
    context.beginPath();
    this.outline(context, run.nodes.region, node);
    context.fillStyle = context.strokeStyle = player.colours.areaOf(run, run.nodes.robot[node]);
    context.lineWidth = this.view.px(0.7);
    context.fill();
    context.stroke();
  }

  paintLeg(context, robot, to) {
    const { view } = this, { run, player } = view;
    context.beginPath();
    traceLeg(context, view, run.robots[robot].track, to - 1, 1);
    context.strokeStyle = player.colours.lineOf(run, robot);
    context.globalAlpha = 0.55;
    context.lineWidth = view.px(1);
    context.stroke();
    context.globalAlpha = 1;
  }

  paintBridge(context, row) {
    const { view } = this, { run, player } = view, { line, robot } = run.bridges;
    context.beginPath();
    for (let i = line.first[row]; i < line.first[row + 1]; i++) context.lineTo(view.x(line.x[i]), view.y(line.y[i]));
    context.strokeStyle = player.colours.lineOf(run, robot[row]);
    context.lineWidth = view.thin(1.6);
    context.setLineDash([view.px(1.5), view.px(2.5)]);
    context.stroke();
    context.setLineDash([]);
  }

  paintNode(context, node, since) {
    const { view } = this, { run, player } = view, { x, y, parent, robot, stage } = run.nodes;
    const colour = player.colours.lineOf(run, robot[node]), from = parent[node];
    if (from >= 0 && stage[node] !== "scan" && since[from] < Infinity) {
      context.beginPath();
      context.moveTo(view.x(x[from]), view.y(y[from]));
      context.lineTo(view.x(x[node]), view.y(y[node]));
      context.strokeStyle = colour;
      context.lineWidth = view.thin(2);
      context.setLineDash(run.robots[robot[node]].dashes.map((mm) => view.thin(3.5 * mm)));
      context.stroke();
      context.setLineDash([]);
    }
    context.beginPath();
    const size = view.thin(from < 0 ? 5 : stage[node] === "scan" ? 1.5 : 3);
    if (from < 0) context.rect(view.x(x[node]) - size, view.y(y[node]) - size, 2 * size, 2 * size);
    else context.arc(view.x(x[node]), view.y(y[node]), size, 0, 2 * Math.PI);
    context.fillStyle = colour;
    context.strokeStyle = player.colours.halo;
    context.lineWidth = view.thin(1);
    context.fill();
    if (stage[node] !== "scan") context.stroke();
  }
}

// The legs of the paths of all robots or of one, in the order in which they end.
function legsOf(run, robot) {
  const found = [];
  run.robots.forEach(({ track }, who) => {
    if (robot !== TEAM && who !== robot) return;
    for (let i = 1; i < track.t.length; i++) {
      if (track.length[i] > track.length[i - 1]) found.push([track.t[i], who, i]);
    }
  });
  found.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  return { t: Float64Array.from(found, (leg) => leg[0]), robot: found.map((leg) => leg[1]), to: found.map((leg) => leg[2]) };
}

function bridgesOf(run, robot) {
  const rows = run.bridges.robot.map((_, row) => row);
  const own = rows.filter((row) => robot === TEAM || run.bridges.robot[row] === robot);
  return { rows: own, t: Float64Array.from(own, (row) => run.bridges.t[row]) };
}

// Add a leg, or the first share of it, to a path on the canvas.
function traceLeg(context, view, track, i, share) {
  const { x, y, heading } = track;
  const steps = Math.max(1, Math.ceil((share * Math.abs(heading[i + 1] - heading[i])) / 0.15));
  context.moveTo(view.x(x[i]), view.y(y[i]));
  for (let k = 1; k <= steps; k++) {
    const [px, py] = poseOn(x, y, heading, i, (share * k) / steps);
    context.lineTo(view.x(px), view.y(py));
  }
}
