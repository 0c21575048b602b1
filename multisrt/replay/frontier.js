// The frontier on a map: parts of the outlines of its regions, at the range of the sensor or at a
// gap, that lie in no other region of the map. Each part has a time from which and until which it
// is there. Regions are taken in the order in which they came to be known, up to the time shown.

const CELL_M = 4;
const CELLS = 1e6; // bound of the rows of cells
const MIN_PART_M = 0.02;
const BEGIN = 4, END = 5; // of a part: [x0, y0, x1, y1, begin, end]

class Frontier {
  constructor(run, robot) {
    this.run = run;
    this.known = run.knownBy(robot);
    this.taken = 0;
    this.parts = [];
    this.cells = new Map();
    this.open = new Map();
    this.ended = []; // parts, by the time of their end
  }

  // Take the regions that are known by a time, until a moment; returns whether all are taken.
  advance(time, until) {
    const { nodes, t } = this.known;
    const wanted = lastBy(t, time) + 1;
    while (this.taken < wanted) {
      this.add(nodes[this.taken], t[this.taken]);
      if (++this.taken % 8 === 0 && performance.now() > until) break;
    }
    return this.taken >= wanted;
  }

  // The parts that are there at a time up to which regions were taken.
  at(time) {
    return this.parts.filter((part) => part[BEGIN] <= time && part[END] > time);
  }

  add(node, time) {
    const near = this.neighbours(node);
    for (const other of near) this.cut(other, node, time);
    const own = [];
    for (const edge of this.edges(node)) {
      let pieces = [edge];
      for (const other of near) {
        if (!pieces.length) break;
        pieces = pieces.flatMap((piece) => this.without(piece, other));
      }
      for (const piece of pieces) own.push(this.part(piece, time));
    }
    this.open.set(node, own);
    for (const key of this.cellsOf(node)) {
      if (!this.cells.has(key)) this.cells.set(key, []);
      this.cells.get(key).push(node);
    }
  }

  edges(node) {
    const { region, tags } = this.run.nodes, { first, x, y } = region, found = [];
    for (let i = first[node]; i < first[node + 1]; i++) {
      const j = i + 1 < first[node + 1] ? i + 1 : first[node];
      if (tags[i] === "1" || tags[i] === "2") found.push([x[i], y[i], x[j], y[j]]);
    }
    return found;
  }

  part(piece, time) {
    const made = [...piece, time, Infinity];
    this.parts.push(made);
    return made;
  }

  // What a new region leaves of the open parts of another one.
  cut(other, node, time) {
    const open = this.open.get(other);
    if (!open.length) return;
    const left = [];
    for (const part of open) {
      const rest = this.without(part, node);
      if (rest[0] === part) {
        left.push(part);
        continue;
      }
      part[END] = time;
      this.ended.push(part);
      for (const smaller of rest) left.push(this.part(smaller, time));
    }
    this.open.set(other, left);
  }

  // The parts of a piece outside of the region of a node; the piece itself if that is all of it.
  without(piece, node) {
    const { region, boxes } = this.run.nodes, [ax, ay, bx, by] = piece, b = 4 * node;
    const isFar = Math.max(ax, bx) < boxes[b] || Math.min(ax, bx) > boxes[b + 2] || Math.max(ay, by) < boxes[b + 1] || Math.min(ay, by) > boxes[b + 3];
    if (isFar) return [piece];
    const parts = outsideOf(region, node, ax, ay, bx, by);
    if (parts.length === 1 && parts[0][0] === 0 && parts[0][1] === 1) return [piece];
    const length = distance(ax, ay, bx, by);
    return parts
      .filter(([from, to]) => (to - from) * length >= MIN_PART_M)
      .map(([from, to]) => [ax + from * (bx - ax), ay + from * (by - ay), ax + to * (bx - ax), ay + to * (by - ay)]);
  }

  cellsOf(node) {
    const b = 4 * node, { boxes } = this.run.nodes, keys = [];
    const [left, low, right, high] = [0, 1, 2, 3].map((k) => Math.floor(boxes[b + k] / CELL_M));
    for (let i = left; i <= right; i++) for (let j = low; j <= high; j++) keys.push(i * CELLS + j);
    return keys;
  }

  // The regions that were taken and whose boxes meet that of a node.
  neighbours(node) {
    const found = new Set(), { boxes } = this.run.nodes, a = 4 * node;
    for (const key of this.cellsOf(node)) {
      for (const other of this.cells.get(key) || []) {
        const b = 4 * other;
        if (boxes[a] <= boxes[b + 2] && boxes[b] <= boxes[a + 2] && boxes[a + 1] <= boxes[b + 3] && boxes[b + 1] <= boxes[a + 3]) found.add(other);
      }
    }
    return [...found].sort((p, q) => p - q);
  }
}
