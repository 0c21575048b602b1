// Plane geometry: convex hulls, points in polygons, what of a segment lies outside of polygons.

function inside(polygon, number, x, y) {
  const { first, x: xs, y: ys } = polygon;
  let within = false;
  for (let i = first[number], j = first[number + 1] - 1; i < first[number + 1]; j = i++) {
    if ((ys[i] > y) !== (ys[j] > y) && x < ((xs[j] - xs[i]) * (y - ys[i])) / (ys[j] - ys[i]) + xs[i]) {
      within = !within;
    }
  }
  return within;
}

function boxesOf(polygons) {
  const count = polygons.first.length - 1, boxes = new Float64Array(4 * count);
  for (let n = 0; n < count; n++) {
    let x0 = Infinity, y0 = Infinity, x1 = -Infinity, y1 = -Infinity;
    for (let i = polygons.first[n]; i < polygons.first[n + 1]; i++) {
      x0 = Math.min(x0, polygons.x[i]); x1 = Math.max(x1, polygons.x[i]);
      y0 = Math.min(y0, polygons.y[i]); y1 = Math.max(y1, polygons.y[i]);
    }
    boxes.set([x0, y0, x1, y1], 4 * n);
  }
  return boxes;
}

// The corners of the convex hull of some points [x, y], in order.
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1) {
        const a = chain[chain.length - 2], b = chain[chain.length - 1];
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        chain.pop();
      }
      chain.push(p);
    }
    chain.pop();
    return chain;
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

// The hull of discs of one radius around some points.
function roundHull(points, radius) {
  const around = [];
  for (const [x, y] of points) {
    for (let k = 0; k < 24; k++) {
      const angle = (k * Math.PI) / 12;
      around.push([x + radius * Math.cos(angle), y + radius * Math.sin(angle)]);
    }
  }
  return hull(around);
}

// Parts [from, to] of the segment a-b, as shares from 0 to 1, that lie outside of a polygon.
function outsideOf(polygon, number, ax, ay, bx, by) {
  const cuts = cutsOf(polygon, number, ax, ay, bx - ax, by - ay), parts = [];
  let from = 0, last = null;
  for (let k = 0; k <= cuts.length; k++) {
    const to = k < cuts.length ? cuts[k] : 1, middle = (from + to) / 2;
    if (to - from < 1e-9) continue;
    if (inside(polygon, number, ax + middle * (bx - ax), ay + middle * (by - ay))) last = null;
    else if (last) last[1] = to;
    else parts.push((last = [from, to]));
    from = to;
  }
  return parts;
}

// Where a segment crosses the outline of a polygon, as rising shares of its length.
function cutsOf({ first, x, y }, number, ax, ay, dx, dy) {
  const end = first[number + 1], cuts = [];
  let px = x[end - 1] - ax, py = y[end - 1] - ay, before = dx * py - dy * px;
  for (let i = first[number]; i < end; i++) {
    const qx = x[i] - ax, qy = y[i] - ay, side = dx * qy - dy * qx;
    // Most edges lie on one side of the line.
    if (before > 0 !== side > 0) {
      const share = before / (before - side), cx = px + share * (qx - px), cy = py + share * (qy - py);
      const along = (cx * dx + cy * dy) / (dx * dx + dy * dy);
      if (along > 0 && along < 1) cuts.push(along);
    }
    px = qx;
    py = qy;
    before = side;
  }
  return cuts.sort((a, b) => a - b);
}

function distance(ax, ay, bx, by) {
  return Math.hypot(ax - bx, ay - by);
}
