// One run: its tables, and what holds at a time.

const TEAM = -1; // the map of all robots together

// The nodes that the base station knew and since when, in this order.
function deliveredOf(packed) {
  if (!packed) return { nodes: [], t: new Float64Array() };
  const times = running(packed.t, 1000), nodes = [], t = [];
  unpackLists(packed.nodes).forEach((own, row) => {
    for (const node of own) [nodes[nodes.length], t[t.length]] = [node, times[row]];
  });
  return { nodes, t: Float64Array.from(t) };
}

class Run {
  constructor(packed) {
    this.packed = packed;
    this.title = packed.label;
    this.end = packed.end / 1000;
    this.isGoingOn = packed.outcome === "still going on";
    this.bounds = packed.world.bounds.map((value) => value / 1000);
    this.rings = unpackPoints(packed.world.rings);
    this.robots = packed.robots.map((robot) => ({ ...robot, body: unpackPoints(robot.body), track: trackOf(robot.track) }));
    this.count = this.robots.length;
    this.base = packed.base && packed.base.map((value) => value / 1000);
    this.nodes = nodesOf(packed.nodes);
    this.unpackKnowledge(packed);
    this.unpackTeam(packed);
    this.unpackTexts(packed);
    this.known = new Map();
    this.frontiers = new Map();
  }

  unpackKnowledge(packed) {
    const { learned, scans, goals, bridges, arcs } = packed;
    this.learned = { t: running(learned.t, 1000), robot: learned.robot, nodes: unpackLists(learned.nodes) };
    this.delivered = deliveredOf(packed.delivered);
    this.scans = null;
    if (scans) {
      this.scans = { t: running(scans.t, 1000), robot: scans.robot, node: whole(scans.node), region: unpackPoints(scans.region) };
      let own = 0;
      this.scans.number = Int32Array.from(this.scans.node, (node) => (node < 0 ? own++ : -1));
    }
    const t = running(goals.t, 1000);
    this.goals = { t, x: running(goals.x, 1000), y: running(goals.y, 1000), none: new Set(goals.none), options: unpackPoints(goals.options), by: byRobot(goals.robot, t, this.count) };
    this.bridges = { t: running(bridges.t, 1000), robot: bridges.robot, line: unpackPoints(bridges.line) };
    const end = running(arcs.end, 1000);
    this.arcs = { begin: running(arcs.begin, 1000), end: end.map((time) => (time < 0 ? Infinity : time)), robot: arcs.robot, arc: unpackPoints(arcs.arc) };
  }

  unpackTeam(packed) {
    const { messages, links, groups, stops } = packed;
    this.messages = { ...messages, t: running(messages.t, 1000), sets: unpackLists(messages.sets) };
    this.links = links && { begin: running(links.begin, 1000), end: running(links.end, 1000), one: links.one, other: links.other };
    const t = running(groups.t, 1000), { orders } = groups;
    this.groups = { gpr: groups.gpr, ger: groups.ger, sets: unpackLists(groups.sets), by: byRobot(groups.robot, t, this.count) };
    this.orders = { master: orders.master, by: byRobot(orders.robot, running(orders.t, 1000), this.count) };
    this.stops = { t: running(stops.t, 1000), robot: stops.robot, x: running(stops.x, 1000), y: running(stops.y, 1000) };
  }

  unpackTexts(packed) {
    const { log, explanations, activities, curves } = packed;
    this.log = { ...log, t: running(log.t, 1000), text: whole(log.text) };
    this.log.by = byRobot(log.robot, this.log.t, this.count);
    this.explanations = explanations && {
      lines: explanations.lines,
      texts: unpackLists(explanations.texts),
      robots: explanations.robots.map((own) => ({ t: running(own.t, 1000), text: whole(own.text) })),
    };
    this.activities = activities.robots.map((own) => ({ t: running(own.t, 1000), what: own.what }));
    this.cutOff = activities.cut_off.map((own) => ({ begin: running(own.begin, 1000), end: running(own.end, 1000) }));
    this.coverage = curves.coverage && { t: running(curves.coverage.t, 1000), coverage: running(curves.coverage.coverage, 1e4), seen: running(curves.coverage.seen, 1e4) };
    if (this.coverage && curves.coverage.delivered) this.coverage.delivered = running(curves.coverage.delivered, 1e4);
    this.isolated = { t: running(curves.isolated.t, 1000), robots: curves.isolated.robots };
  }

  // The pose of a robot: on a leg of constant twist.
  pose(robot, time) {
    const { t, x, y, heading } = this.robots[robot].track;
    const i = Math.max(0, lastBy(t, time));
    if (i === t.length - 1) return [x[i], y[i], heading[i]];
    const share = t[i + 1] > t[i] ? Math.min(1, (time - t[i]) / (t[i + 1] - t[i])) : 1;
    return poseOn(x, y, heading, i, share);
  }

  // The way that a robot has driven by a time, in metres.
  driven(robot, time) {
    const { t, length } = this.robots[robot].track;
    const i = Math.max(0, lastBy(t, time));
    if (i === t.length - 1) return length[i];
    const share = t[i + 1] > t[i] ? Math.min(1, (time - t[i]) / (t[i + 1] - t[i])) : 1;
    return length[i] + share * (length[i + 1] - length[i]);
  }

  // The remaining waypoints of the motion that a robot is on: their first and last numbers.
  ahead(robot, time) {
    const { t, begin } = this.robots[robot].track;
    const i = lastBy(t, time);
    if (i < 0 || i === t.length - 1) return null;
    const motion = lastBy(begin, i);
    if (motion < 0) return null;
    const last = motion + 1 < begin.length ? begin[motion + 1] - 1 : t.length - 1;
    return i < last ? [i + 1, last] : null;
  }

  // The nodes on a map and since when: of the team, or those that a robot made or learned of.
  knownBy(robot) {
    if (!this.known.has(robot)) this.known.set(robot, this.findKnown(robot));
    return this.known.get(robot);
  }

  findKnown(robot) {
    const { t, robot: makers, count } = this.nodes;
    const since = new Float64Array(count).fill(Infinity);
    for (let i = 0; i < count; i++) if (robot === TEAM || makers[i] === robot) since[i] = t[i];
    if (robot !== TEAM) {
      this.learned.robot.forEach((who, row) => {
        if (who !== robot) return;
        for (const node of this.learned.nodes[row]) since[node] = Math.min(since[node], this.learned.t[row]);
      });
    }
    const order = [];
    for (let i = 0; i < count; i++) if (since[i] < Infinity) order.push(i);
    order.sort((a, b) => since[a] - since[b] || a - b);
    return { nodes: Int32Array.from(order), t: Float64Array.from(order, (i) => since[i]), since };
  }

  scansOf(robot) {
    const rows = [];
    if (this.scans) this.scans.robot.forEach((who, row) => (robot === TEAM || who === robot) && rows.push(row));
    return { rows, t: Float64Array.from(rows, (row) => this.scans.t[row]) };
  }

  frontier(robot) {
    if (!this.frontiers.has(robot)) this.frontiers.set(robot, new Frontier(this, robot));
    return this.frontiers.get(robot);
  }

  // What `multisrt why` tells of a robot at a time.
  why(robot, time) {
    if (!this.explanations) return this.packed.unexplained || "This page has no explanations: use multisrt why.";
    const { lines, texts, robots } = this.explanations;
    const { t, text } = robots[robot];
    const row = lastBy(t, time + 1e-6);
    if (row < 0) {
      if (!t.length) return `Robot ${robot} put no decision on record in this run.`;
      return `Robot ${robot} had not decided anything by ${time.toFixed(2)} s; its first decision is at ${t[0].toFixed(2)} s.`;
    }
    const said = Array.from(texts[text[row]], (line) => lines[line]);
    return `Robot ${robot} at ${time.toFixed(2)} s: ${said.join("\n")}`;
  }

  activity(robot, time) {
    const { t, what } = this.activities[robot];
    const row = lastBy(t, time);
    return row < 0 ? null : what[row];
  }

  // Whether a robot is cut off from all others.
  isCutOff(robot, time) {
    const { begin, end } = this.cutOff[robot], row = lastBy(begin, time);
    return row >= 0 && (end[row] > time || end[row] >= this.end);
  }

  // What a robot is doing, in words.
  doing(robot, time) {
    const what = this.activity(robot, time);
    return (what === null ? "" : this.packed.activities.names[what]) + (this.isCutOff(robot, time) ? ", cut off" : "");
  }

  // Whether an event is a decision.
  isDecision(row) {
    return ["decision", "goal_chosen", "decided"].includes(this.log.kinds[this.log.kind[row]]);
  }

  said(row) {
    const { t, robot, text, texts } = this.log;
    return `${t[row].toFixed(2)} s, robot ${robot[row]}: ${texts[text[row]]}`;
  }
}

function trackOf(packed) {
  const track = {
    t: running(packed.t, 1000), x: running(packed.x, 1000), y: running(packed.y, 1000),
    heading: running(packed.heading, 10000), begin: running(packed.begin),
  };
  const { x, y, heading } = track, length = new Float64Array(x.length);
  for (let i = 1; i < x.length; i++) {
    const chord = distance(x[i - 1], y[i - 1], x[i], y[i]), half = Math.abs(heading[i] - heading[i - 1]) / 2;
    const arc = chord > 0 && half > 1e-4 && half <= Math.PI / 2 + 1e-3 ? (chord * half) / Math.sin(half) : chord;
    length[i] = length[i - 1] + arc;
  }
  return Object.assign(track, { length });
}

function poseOn(x, y, heading, i, share) {
  const dx = x[i + 1] - x[i], dy = y[i + 1] - y[i], turn = heading[i + 1] - heading[i];
  if (Math.abs(turn) < 1e-4) return [x[i] + share * dx, y[i] + share * dy, heading[i] + share * turn];
  const part = Math.sin((share * turn) / 2) / Math.sin(turn / 2), back = ((share - 1) * turn) / 2;
  const c = part * Math.cos(back), s = part * Math.sin(back);
  return [x[i] + c * dx - s * dy, y[i] + s * dx + c * dy, heading[i] + share * turn];
}

function nodesOf(packed) {
  const region = unpackPoints(packed.region);
  return {
    count: packed.robot.length,
    t: running(packed.t, 1000), robot: packed.robot, serial: whole(packed.serial), parent: whole(packed.parent),
    stage: packed.stage.map((stage) => packed.stages[stage]),
    stageName: packed.stage.map((stage) => packed.stage_names[stage]),
    x: running(packed.x, 1000), y: running(packed.y, 1000),
    region, boxes: boxesOf(region), tags: packed.tags,
  };
}
