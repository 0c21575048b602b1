// What is drawn again in every frame: goals, groups, messages, links, bodies.

const FLASH_S = 0.45; // of a message, in seconds of the clock on the wall
const STILL_S = 0.5; // of messages while the time stands
const MAX_LINES = 600; // of messages in a frame
const GROUP_PX = 16;
const RECENT_S = 3; // since a protective stop, in which its mark is large

class Marks extends Brush {
  constructor(view) {
    super(view);
    this.bodies = new Bodies(view);
  }

  draw(time) {
    const { view } = this, { run, player } = view, { layers } = player;
    this.c.clearRect(0, 0, view.width, view.height);
    this.robot = player.robotOf(run);
    this.time = time;
    const poses = run.robots.map((_, robot) => run.pose(robot, time));
    // In messages and links the base station has the number after the last robot.
    this.poses = run.base ? [...poses, [...run.base, 0]] : poses;
    this.doing = run.robots.map((_, robot) => this.activity(robot));
    this.areCutOff = run.robots.map((_, robot) => run.isCutOff(robot, time));
    if (layers.has("frontier")) this.drawGivenUp();
    if (layers.has("paths")) this.drawAhead();
    if (layers.has("links")) this.drawLinks();
    if (layers.has("groups")) this.drawGroups();
    if (layers.has("goals")) this.drawGoals();
    if (layers.has("stops")) this.drawStops();
    if (layers.has("messages")) this.drawMessages();
    if (player.run === view.number) this.drawChosenNode(player.panel.node);
    if (layers.has("bodies") && run.base) this.drawBase(...run.base);
    if (layers.has("bodies")) this.bodies.draw(poses, this.doing, this.areCutOff, this.robot);
    if (layers.has("masters")) this.drawMasters();
  }

  activity(robot) {
    const what = this.view.run.activity(robot, this.time);
    return what === null ? "" : this.view.run.packed.activities.names[what];
  }

  // Frontier arcs that robots gave up.
  drawGivenUp() {
    const { c } = this, { run, player } = this.view;
    const { begin, end, robot, arc } = run.arcs;
    c.beginPath();
    for (let row = 0; row < begin.length && begin[row] <= this.time; row++) {
      if (end[row] <= this.time || (this.robot !== TEAM && robot[row] !== this.robot)) continue;
      for (let i = arc.first[row]; i + 1 < arc.first[row + 1]; i += 2) this.segment(arc.x[i], arc.y[i], arc.x[i + 1], arc.y[i + 1]);
    }
    this.stroke(player.colours.halo, 4);
    this.stroke(player.colours.ink, 2, [4, 2.5]);
  }

  isMine(robot) {
    return this.robot === TEAM || this.robot === robot;
  }

  // The leg that a robot is on: what it has driven of it, and what lies ahead of the motion.
  drawAhead() {
    const { c, view } = this, { run, player } = view;
    for (let robot = 0; robot < run.count; robot++) {
      const ahead = this.isMine(robot) && run.ahead(robot, this.time);
      if (!ahead) continue;
      const { track } = run.robots[robot], [first, last] = ahead, i = first - 1;
      const share = track.t[first] > track.t[i] ? Math.min(1, (this.time - track.t[i]) / (track.t[first] - track.t[i])) : 1;
      c.beginPath();
      traceLeg(c, view.camera, track, i, share);
      this.stroke(player.colours.lineOf(run, robot), 1);
      c.beginPath();
      const [x, y] = this.poses[robot];
      c.moveTo(view.x(x), view.y(y));
      for (let k = first; k <= last; k++) {
        if (k > first) traceLeg(c, view.camera, track, k - 1, 1);
        else c.lineTo(view.x(track.x[k]), view.y(track.y[k]));
      }
      this.stroke(player.colours.ink, 1.4, [4, 3]);
    }
  }

  drawLinks() {
    const { c, view } = this, { run, player } = view, { links } = run;
    if (!links) return;
    c.beginPath();
    for (let row = 0; row < links.begin.length; row++) {
      if (links.begin[row] > this.time || links.end[row] <= this.time) continue;
      const one = links.one[row], other = links.other[row];
      if (this.robot !== TEAM && one !== this.robot && other !== this.robot) continue;
      this.segment(...this.poses[one].slice(0, 2), ...this.poses[other].slice(0, 2));
    }
    this.stroke(player.colours.radio, 1.2);
  }

  // Those that are being sent; with a robot chosen, those that it sends or is sent.
  drawMessages() {
    const { c, view } = this, { run, player } = view, { t, robot, reached, lost, sets } = run.messages;
    const span = player.isPlaying ? Math.max(0.02, FLASH_S * player.pace) : STILL_S;
    if (player.time > run.end) return;
    let lines = 0;
    for (let row = lastBy(t, this.time); row >= 0 && t[row] > this.time - span && lines < MAX_LINES; row--) {
      const mine = (set) => (this.isMine(robot[row]) ? set : set.filter((to) => to === this.robot));
      const received = mine(sets[reached[row]]), missed = mine(sets[lost[row]]);
      if (!this.isMine(robot[row]) && !received.length && !missed.length) continue;
      const [x, y] = this.poses[robot[row]];
      c.globalAlpha = player.isStill ? 0.9 : Math.max(0.15, 1 - (this.time - t[row]) / span);
      for (const [set, dashes] of [[received, []], [missed, [3, 3]]]) {
        c.beginPath();
        for (const to of set) this.arrow(x, y, ...this.poses[to]);
        this.stroke(player.colours.message, 1.6, dashes);
        lines += set.length;
      }
      c.beginPath();
      c.arc(view.x(x), view.y(y), view.px(11), 0, 2 * Math.PI);
      this.stroke(player.colours.message, 1.2);
    }
    c.globalAlpha = 1;
  }

  arrow(x0, y0, x1, y1) {
    const { c, view } = this, ax = view.x(x0), ay = view.y(y0), bx = view.x(x1), by = view.y(y1);
    const length = distance(ax, ay, bx, by);
    if (length < 1) return;
    const ux = (bx - ax) / length, uy = (by - ay) / length, head = Math.min(view.px(7), length / 3);
    const tip = Math.max(0, length - view.px(9)), px = ax + tip * ux, py = ay + tip * uy;
    c.moveTo(ax, ay);
    c.lineTo(px, py);
    c.moveTo(px - head * ux + (head / 2) * uy, py - head * uy - (head / 2) * ux);
    c.lineTo(px, py);
    c.lineTo(px - head * ux - (head / 2) * uy, py - head * uy + (head / 2) * ux);
  }

  takesPart(robot) {
    return !["done", "dead", "not started"].includes(this.doing[robot]);
  }

  drawGroups() {
    const { run, player } = this.view, { gpr, ger, sets, by } = run.groups;
    const seen = new Set();
    for (let robot = 0; robot < run.count; robot++) {
      const k = lastBy(by[robot].t, this.time);
      if (k < 0 || !this.isMine(robot) || !this.takesPart(robot)) continue;
      const row = by[robot].rows[k];
      for (const [set, radius, isGer] of [[gpr[row], GROUP_PX + 6, false], [ger[row], GROUP_PX, true]]) {
        const key = `${isGer} ${[...sets[set]].sort()}`;
        if (sets[set].length < 2 || seen.has(key)) continue;
        seen.add(key);
        this.blob(sets[set], radius);
        this.c.globalAlpha = 0.1;
        this.c.fillStyle = player.colours.link;
        if (isGer) this.c.fill();
        this.c.globalAlpha = 1;
        this.stroke(player.colours.link, isGer ? 1.8 : 1.2, isGer ? [] : [3, 4]);
      }
    }
  }

  blob(robots, radius) {
    const { c, view } = this;
    const places = Array.from(robots, (robot) => [view.x(this.poses[robot][0]), view.y(this.poses[robot][1])]);
    c.beginPath();
    for (const [x, y] of roundHull(places, view.px(radius))) c.lineTo(x, y);
    c.closePath();
  }

  // Since it organised a group, and until the members decide again.
  drawMasters() {
    const { c, view } = this, { run, player } = view, masters = new Set();
    for (let robot = 0; robot < run.count; robot++) {
      const orders = run.orders.by[robot], decided = run.groups.by[robot];
      const k = lastBy(orders.t, this.time), d = lastBy(decided.t, this.time);
      if (k < 0 || (d >= 0 && decided.t[d] > orders.t[k]) || !this.takesPart(robot)) continue;
      const master = run.orders.master[orders.rows[k]];
      if (!this.isMine(robot) && !this.isMine(master)) continue;
      masters.add(master);
      c.beginPath();
      this.segment(...this.poses[master].slice(0, 2), ...this.poses[robot].slice(0, 2));
      this.stroke(player.colours.link, 1.2, [1, 3]);
    }
    for (const master of masters) {
      const x = view.x(this.poses[master][0]) + view.px(12), y = view.y(this.poses[master][1]) - view.px(12);
      c.beginPath();
      c.arc(x, y, view.px(7), 0, 2 * Math.PI);
      c.fillStyle = player.colours.link;
      c.fill();
      this.label("M", x, y, player.colours.paper, 10);
    }
  }

  drawGoals() {
    const { c, view } = this, { run, player } = view, { x, y, none, by, options } = run.goals;
    for (let robot = 0; robot < run.count; robot++) {
      const k = lastBy(by[robot].t, this.time);
      if (k < 0 || !this.isMine(robot) || this.doing[robot] === "dead") continue;
      const row = by[robot].rows[k], colour = player.colours.lineOf(run, robot);
      if (this.robot !== TEAM) {
        for (let i = options.first[row]; i < options.first[row + 1]; i++) {
          this.diamond(options.x[i], options.y[i], 3.5);
          this.stroke(player.colours.frontier, 1.5);
        }
      }
      if (none.has(row)) continue;
      c.beginPath();
      this.segment(...this.poses[robot].slice(0, 2), x[row], y[row]);
      this.stroke(colour, 1, [2, 3]);
      this.diamond(x[row], y[row], 5.5);
      c.fillStyle = player.colours.paper;
      c.fill();
      this.stroke(colour, 2);
    }
  }

  drawBase(x, y) {
    const { c, view } = this, { colours } = view.player, px = view.x(x), py = view.y(y), size = view.px(7);
    c.beginPath();
    for (const [u, v] of HOUSE) c.lineTo(px + size * u, py - size * v);
    c.closePath();
    this.stroke(colours.halo, 4);
    this.fill(colours.ink);
  }

  drawChosenNode(node) {
    const { view } = this, { run, player } = view, { nodes } = run;
    if (node === null || !(run.knownBy(this.robot).since[node] <= this.time)) return;
    const x = view.x(nodes.x[node]), y = view.y(nodes.y[node]);
    this.ring(x, y, view.px(9), player.colours.halo, 5);
    this.ring(x, y, view.px(9), player.colours.link, 2.5);
  }

  diamond(x, y, size) {
    const { c, view } = this, px = view.x(x), py = view.y(y), s = view.px(size);
    c.beginPath();
    c.moveTo(px + s, py);
    c.lineTo(px, py - s);
    c.lineTo(px - s, py);
    c.lineTo(px, py + s);
    c.closePath();
  }

  drawStops() {
    const { c, view } = this, { run, player } = view, { t, robot, x, y } = run.stops;
    for (let row = lastBy(t, this.time); row >= 0; row--) {
      if (!this.isMine(robot[row])) continue;
      const isRecent = this.time - t[row] < RECENT_S, size = view.px(isRecent ? 9 : 4);
      c.beginPath();
      for (let k = 0; k < 8; k++) {
        const angle = Math.PI / 8 + (k * Math.PI) / 4;
        c.lineTo(view.x(x[row]) + size * Math.cos(angle), view.y(y[row]) + size * Math.sin(angle));
      }
      c.closePath();
      c.fillStyle = player.colours.paper;
      c.fill();
      this.stroke(player.colours.frontier, isRecent ? 3 : 1.5);
    }
  }
}
