// What is drawn below the marks: the world, and pictures of what changes only when something is
// found: what was seen, safe regions, trees, paths, the frontier.

const BELOW_WALLS = ["seen", "regions", "delivered"];
const ABOVE_WALLS = ["paths", "bridges", "trees", "frontier"];

class Ground {
  constructor(view) {
    this.view = view;
    this.made = this.painted = "";
  }

  pictures() {
    const { run, player } = this.view, robot = player.robotOf(run);
    const known = run.knownBy(robot), scans = run.scansOf(robot);
    const legs = legsOf(run, robot), bridges = bridgesOf(run, robot);
    return {
      seen: new Growing(scans, (c, k, camera) => this.paintSeen(c, scans.rows[k], camera)),
      delivered: new Growing(run.delivered, (c, k, camera) => this.paintDelivered(c, run.delivered.nodes[k], camera)),
      regions: new Growing(known, (c, k, camera) => this.paintRegion(c, known.nodes[k], camera)),
      paths: new Growing(legs, (c, k, camera) => this.paintLeg(c, legs.robot[k], legs.to[k], camera)),
      bridges: new Growing(bridges, (c, k, camera) => this.paintBridge(c, bridges.rows[k], camera)),
      trees: new Growing(known, (c, k, camera) => this.paintNode(c, known.nodes[k], known.since, camera)),
      frontier: new FrontierPicture(run.frontier(robot), player.colours),
    };
  }

  // Prepare the layers that are shown at a time, until a moment.
  prepare(time, until) {
    const { view } = this, { run, player } = view;
    const made = `${player.robotOf(run)} ${player.colours.key}`;
    if (made !== this.made) this.layers = this.pictures();
    this.made = made;
    const names = [...BELOW_WALLS, ...ABOVE_WALLS].filter((name) => player.layers.has(name));
    this.shown = new Map(names.map((name) => [name, this.layers[name]]));
    for (const picture of this.shown.values()) picture.advance(time, view.camera, until, view.isMoving);
  }

  // Whether all layers are there at the time that is wanted.
  get isThere() {
    return [...this.shown.values()].every((picture) => picture.isThere);
  }

  // Whether they are drawn with the camera of the view, too.
  get isDone() {
    return [...this.shown.values()].every((picture) => picture.isDone(this.view.camera));
  }

  // What tells one state of what is drawn from another.
  get key() {
    const keys = [...this.shown].map(([name, picture]) => `${name} ${picture.key}`);
    return [this.view.camera.number, this.made, this.view.player.layers.has("truth"), ...keys].join();
  }

  // Draw the layers that are there; those of another time are not.
  paint() {
    const { view, shown, key } = this, { colours, layers } = view.player, isTrue = layers.has("truth");
    if (key === this.painted) return;
    this.painted = key;
    const context = view.below.getContext("2d");
    if (isTrue) this.drawWorld();
    context.fillStyle = isTrue ? colours.solid : colours.free;
    context.fillRect(0, 0, view.width, view.height);
    const show = (name) => shown.has(name) && shown.get(name).show(context, view.camera);
    if (isTrue) context.drawImage(this.free, 0, 0);
    BELOW_WALLS.forEach(show);
    if (isTrue) context.drawImage(this.walls, 0, 0);
    ABOVE_WALLS.forEach(show);
  }

  // Free space and walls: two pictures, as what robots saw lies between.
  drawWorld() {
    const { view } = this, { camera } = view, { colours } = view.player;
    if (this.worldCamera === camera && this.worldTheme === colours.key) return;
    [this.worldCamera, this.worldTheme] = [camera, colours.key];
    [this.free, this.walls] = [0, 1].map(() => make("canvas", { width: view.width, height: view.height }));
    const below = this.free.getContext("2d"), above = this.walls.getContext("2d");
    below.fillStyle = colours.solid;
    below.fillRect(0, 0, view.width, view.height);
    this.world(below, camera);
    below.fillStyle = colours.free;
    below.fill("evenodd");
    this.world(above, camera);
    above.strokeStyle = colours.wall;
    above.lineWidth = view.px(1);
    above.stroke();
  }

  outline(context, outlines, number, camera) {
    const { first, x, y } = outlines;
    for (let i = first[number]; i < first[number + 1]; i++) {
      if (i === first[number]) context.moveTo(camera.x(x[i]), camera.y(y[i]));
      else context.lineTo(camera.x(x[i]), camera.y(y[i]));
    }
    context.closePath();
  }

  world(context, camera) {
    const { rings } = this.view.run;
    context.beginPath();
    for (let ring = 0; ring + 1 < rings.first.length; ring++) this.outline(context, rings, ring, camera);
  }

  paintSeen(context, row, camera) {
    const { scans, nodes } = this.view.run, node = scans.node[row];
    context.fillStyle = context.strokeStyle = this.view.player.colours.seen;
    context.lineWidth = camera.px(0.7);
    context.beginPath();
    this.outline(context, node < 0 ? scans.region : nodes.region, node < 0 ? scans.number[row] : node, camera);
    context.fill();
    context.stroke();
  }

  // Below what is there already: an area has the colour of the robot that was there first.
  paintRegion(context, node, camera) {
    const { run, player } = this.view;
    context.globalCompositeOperation = "destination-over";
    context.beginPath();
    this.outline(context, run.nodes.region, node, camera);
    context.fillStyle = context.strokeStyle = player.colours.areaOf(run, run.nodes.robot[node]);
    context.lineWidth = camera.px(0.7);
    context.fill();
    context.stroke();
  }

  // Hatched in one colour without transparency, so that regions that overlap look like one.
  paintDelivered(context, node, camera) {
    const { run, player } = this.view;
    context.beginPath();
    this.outline(context, run.nodes.region, node, camera);
    context.fillStyle = this.hatching(context, camera, player.colours.delivered);
    context.fill();
  }

  hatching(context, camera, colour) {
    const size = Math.max(4, Math.round(camera.px(7))), key = `${size} ${colour}`;
    if (this.hatchedAs !== key) {
      const tile = make("canvas", { width: size, height: size }), c = tile.getContext("2d");
      c.fillStyle = colour;
      // Two steps of one pixel a row: an edge that is the same wherever tiles meet.
      for (let row = 0; row < size; row++) c.fillRect(size - 1 - row, row, Math.max(1, Math.round(camera.px(1))), 1);
      [this.hatchedAs, this.hatched] = [key, context.createPattern(tile, "repeat")];
    }
    return this.hatched;
  }

  paintLeg(context, robot, to, camera) {
    const { run, player } = this.view;
    context.beginPath();
    traceLeg(context, camera, run.robots[robot].track, to - 1, 1);
    context.strokeStyle = player.colours.lineOf(run, robot);
    context.globalAlpha = 0.55;
    context.lineWidth = camera.px(1);
    context.stroke();
    context.globalAlpha = 1;
  }

  paintBridge(context, row, camera) {
    const { run, player } = this.view, { line, robot } = run.bridges;
    context.beginPath();
    for (let i = line.first[row]; i < line.first[row + 1]; i++) context.lineTo(camera.x(line.x[i]), camera.y(line.y[i]));
    context.strokeStyle = player.colours.lineOf(run, robot[row]);
    context.lineWidth = camera.thin(1.6);
    context.setLineDash([camera.px(1.5), camera.px(2.5)]);
    context.stroke();
    context.setLineDash([]);
  }

  paintNode(context, node, since, camera) {
    const { run, player } = this.view, { x, y, parent, robot, stage } = run.nodes;
    const colour = player.colours.lineOf(run, robot[node]), from = parent[node];
    if (from >= 0 && stage[node] !== "scan" && since[from] < Infinity) {
      context.beginPath();
      context.moveTo(camera.x(x[from]), camera.y(y[from]));
      context.lineTo(camera.x(x[node]), camera.y(y[node]));
      context.strokeStyle = colour;
      context.lineWidth = camera.thin(2);
      context.setLineDash(run.robots[robot[node]].dashes.map((mm) => camera.thin(3.5 * mm)));
      context.stroke();
      context.setLineDash([]);
    }
    context.beginPath();
    const size = camera.thin(from < 0 ? 5 : stage[node] === "scan" ? 1.5 : 3);
    if (from < 0) context.rect(camera.x(x[node]) - size, camera.y(y[node]) - size, 2 * size, 2 * size);
    else context.arc(camera.x(x[node]), camera.y(y[node]), size, 0, 2 * Math.PI);
    context.fillStyle = colour;
    context.strokeStyle = player.colours.halo;
    context.lineWidth = camera.thin(1);
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
function traceLeg(context, camera, track, i, share) {
  const { x, y, heading } = track;
  const steps = Math.max(1, Math.ceil((share * Math.abs(heading[i + 1] - heading[i])) / 0.15));
  context.moveTo(camera.x(x[i]), camera.y(y[i]));
  for (let k = 1; k <= steps; k++) {
    const [px, py] = poseOn(x, y, heading, i, (share * k) / steps);
    context.lineTo(camera.x(px), camera.y(py));
  }
}
