// The picture of a frontier. Tiles in which parts come or go are redrawn, all others stay.

const TILE_PX = 64;
const MAX_CHANGES = 2000; // of which the tiles are looked up one by one

class FrontierPicture extends Picture {
  constructor(frontier, colours) {
    super();
    Object.assign(this, { frontier, colours });
  }

  sheet(camera) {
    const canvas = this.canvas(camera), columns = Math.ceil(camera.width / TILE_PX), rows = Math.ceil(camera.height / TILE_PX);
    const tiles = Array.from({ length: columns * rows }, () => []);
    return { camera, canvas, context: canvas.getContext("2d"), revision: 0, columns, rows, tiles, placed: 0, time: -1, dirty: new Set() };
  }

  fill(sheet, time, until) {
    if (!this.frontier.advance(time, until) || !this.placeParts(sheet, until)) return false;
    this.markChanged(sheet, time);
    for (const tile of sheet.dirty) {
      this.drawTile(sheet, tile, time);
      sheet.dirty.delete(tile);
      sheet.revision++;
      if (performance.now() > until) break;
    }
    return sheet.dirty.size === 0;
  }

  placeParts(sheet, until) {
    const { parts } = this.frontier;
    while (sheet.placed < parts.length) {
      const part = parts[sheet.placed++];
      for (const tile of this.tilesOf(sheet, part)) sheet.tiles[tile].push(part);
      if (sheet.placed % 256 === 0 && performance.now() > until) return false;
    }
    return true;
  }

  // Mark the tiles in which parts begin or end between the time that is drawn and another one.
  markChanged(sheet, time) {
    const { parts, ended } = this.frontier, from = Math.min(time, sheet.time), to = Math.max(time, sheet.time);
    sheet.time = time;
    const changed = [[parts, BEGIN], [ended, END]].map(([list, field]) => [list, firstAfter(list, field, from), firstAfter(list, field, to)]);
    const count = changed.reduce((sum, [, first, last]) => sum + last - first, 0);
    if (count > MAX_CHANGES) for (let tile = 0; tile < sheet.tiles.length; tile++) sheet.dirty.add(tile);
    else {
      for (const [list, first, last] of changed) {
        for (let k = first; k < last; k++) for (const tile of this.tilesOf(sheet, list[k])) sheet.dirty.add(tile);
      }
    }
  }

  tilesOf({ camera, columns, rows }, [x0, y0, x1, y1]) {
    const margin = camera.px(2), found = [];
    const [ax, bx, ay, by] = [camera.x(x0), camera.x(x1), camera.y(y0), camera.y(y1)];
    const column = (x) => Math.max(0, Math.min(columns - 1, Math.floor(x / TILE_PX)));
    const row = (y) => Math.max(0, Math.min(rows - 1, Math.floor(y / TILE_PX)));
    if (Math.max(ax, bx) < 0 || Math.min(ax, bx) > camera.width || Math.max(ay, by) < 0 || Math.min(ay, by) > camera.height) return found;
    for (let j = row(Math.min(ay, by) - margin); j <= row(Math.max(ay, by) + margin); j++) {
      for (let i = column(Math.min(ax, bx) - margin); i <= column(Math.max(ax, bx) + margin); i++) found.push(j * columns + i);
    }
    return found;
  }

  drawTile({ camera, context, columns, tiles }, tile, time) {
    const x = (tile % columns) * TILE_PX, y = Math.floor(tile / columns) * TILE_PX;
    context.save();
    context.beginPath();
    context.rect(x, y, TILE_PX, TILE_PX);
    context.clip();
    context.clearRect(x, y, TILE_PX, TILE_PX);
    context.beginPath();
    for (const part of tiles[tile]) {
      if (part[BEGIN] > time || part[END] <= time) continue;
      context.moveTo(camera.x(part[0]), camera.y(part[1]));
      context.lineTo(camera.x(part[2]), camera.y(part[3]));
    }
    context.strokeStyle = this.colours.frontier;
    context.lineWidth = camera.thin(2.5);
    context.lineCap = "square";
    context.stroke();
    context.restore();
  }
}

// The number of the first of some parts, sorted by a field, of which it is later than a time.
function firstAfter(parts, field, time) {
  let low = 0, high = parts.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (parts[middle][field] <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}
