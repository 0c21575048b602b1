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
  const { first, x, y } = polygon;
  const cuts = [0, 1];
  const dx = bx - ax, dy = by - ay;
  for (let i = first[number], j = first[number + 1] - 1; i < first[number + 1]; j = i++) {
    const ex = x[i] - x[j], ey = y[i] - y[j];
    const cross = dx * ey - dy * ex;
    if (cross === 0) continue;
    const qx = x[j] - ax, qy = y[j] - ay;
    const along = (qx * ey - qy * ex) / cross, across = (qx * dy - qy * dx) / cross;
    if (along > 0 && along < 1 && across >= -1e-9 && across <= 1 + 1e-9) cuts.push(along);
  }
  cuts.sort((a, b) => a - b);
  const parts = [];
  for (let k = 1; k < cuts.length; k++) {
    const from = cuts[k - 1], to = cuts[k];
    if (to - from < 1e-9) continue;
    const middle = (from + to) / 2;
    if (inside(polygon, number, ax + middle * dx, ay + middle * dy)) continue;
    const last = parts[parts.length - 1];
    if (last && last[1] === from) last[1] = to;
    else parts.push([from, to]);
  }
  return parts;
}

function distance(ax, ay, bx, by) {
  return Math.hypot(ax - bx, ay - by);
}
