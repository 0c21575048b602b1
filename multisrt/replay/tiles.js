// The picture of a frontier. Tiles in which parts come or go are drawn anew, all others stay.

const TILE_PX = 64;

class FrontierPicture {
  constructor(view, frontier) {
    Object.assign(this, { view, frontier, canvas: document.createElement("canvas"), key: "" });
  }

  restart(key) {
    const { width, height } = this.view;
    Object.assign(this.canvas, { width, height });
    this.context = this.canvas.getContext("2d");
    this.columns = Math.ceil(width / TILE_PX);
    this.rows = Math.ceil(height / TILE_PX);
    this.tiles = Array.from({ length: this.columns * this.rows }, () => []);
    this.placed = 0;
    this.time = -1;
    this.key = key;
  }

  // Draw the frontier at a time; returns whether all of it could be found in time.
  draw(time) {
    const { view, frontier } = this, { colours } = view.player;
    const isDone = frontier.advance(time), key = `${view.version} ${colours.key}`;
    if (key !== this.key) this.restart(key);
    const dirty = new Set();
    for (; this.placed < frontier.parts.length; this.placed++) {
      const part = frontier.parts[this.placed];
      for (const tile of this.tilesOf(part)) {
        this.tiles[tile].push(part);
        if (part[BEGIN] <= time) dirty.add(tile);
      }
    }
    this.changed(time, dirty);
    for (const tile of dirty) this.drawTile(tile, time);
    this.time = time;
    this.drawnEnds = frontier.ended.length;
    return isDone;
  }

  // Tiles in which parts begin or end between the time that is drawn and another one.
  changed(time, dirty) {
    const { parts, ended } = this.frontier, from = Math.min(time, this.time), to = Math.max(time, this.time);
    const mark = (list, field, first) => {
      for (let k = first; k < list.length && list[k][field] <= to; k++) {
        for (const tile of this.tilesOf(list[k])) dirty.add(tile);
      }
    };
    if (from !== to) mark(parts, BEGIN, firstAfter(parts, BEGIN, from));
    mark(ended, END, Math.min(firstAfter(ended, END, from), this.drawnEnds || 0));
  }

  tilesOf([x0, y0, x1, y1]) {
    const { view } = this, margin = view.px(2), found = [];
    const [ax, bx, ay, by] = [view.x(x0), view.x(x1), view.y(y0), view.y(y1)];
    const column = (x) => Math.max(0, Math.min(this.columns - 1, Math.floor(x / TILE_PX)));
    const row = (y) => Math.max(0, Math.min(this.rows - 1, Math.floor(y / TILE_PX)));
    if (Math.max(ax, bx) < 0 || Math.min(ax, bx) > view.width || Math.max(ay, by) < 0 || Math.min(ay, by) > view.height) return found;
    for (let j = row(Math.min(ay, by) - margin); j <= row(Math.max(ay, by) + margin); j++) {
      for (let i = column(Math.min(ax, bx) - margin); i <= column(Math.max(ax, bx) + margin); i++) found.push(j * this.columns + i);
    }
    return found;
  }

  drawTile(tile, time) {
    const { context, view } = this, x = (tile % this.columns) * TILE_PX, y = Math.floor(tile / this.columns) * TILE_PX;
    context.save();
    context.beginPath();
    context.rect(x, y, TILE_PX, TILE_PX);
    context.clip();
    context.clearRect(x, y, TILE_PX, TILE_PX);
    context.beginPath();
    for (const part of this.tiles[tile]) {
      if (part[BEGIN] > time || part[END] <= time) continue;
      context.moveTo(view.x(part[0]), view.y(part[1]));
      context.lineTo(view.x(part[2]), view.y(part[3]));
    }
    context.strokeStyle = view.player.colours.frontier;
    context.lineWidth = view.thin(2.5);
    context.lineCap = "square";
    context.stroke();
    context.restore();
  }
}

// The first of some parts, sorted by a field, of which it is later than a time.
function firstAfter(parts, field, time) {
  let low = 0, high = parts.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (parts[middle][field] <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}
