// A map on the screen: its canvases, which part of the world it shows, and what is under a point.

const PICK_PX = 14;
const MARGIN = 0.04;
const MAX_SCALE = 2000; // pixels of the screen per metre
const MOVING_MS = 120; // after the last move of the map
const NOTE_AFTER_MS = 300; // for which layers are missing
const STEP = 0.15; // of the map's size, by which a key moves it

class View {
  constructor(run, number, player) {
    this.run = run;
    this.number = number;
    this.player = player;
    this.element = make("div", { className: "view" });
    this.name = make("p", { className: "name", textContent: run.title });
    this.state = make("p", { className: "state", hidden: true });
    this.drawing = make("p", { className: "drawing", hidden: true, textContent: "drawing the map \u2026" });
    this.below = make("canvas", { className: "below" });
    this.top = make("canvas", { className: "top", tabIndex: 0 });
    this.below.setAttribute("aria-hidden", "true");
    this.top.setAttribute("role", "img");
    this.top.setAttribute("aria-label", `Map of ${run.title}`);
    this.element.append(make("div", { className: "chips" }, this.name, this.state), this.drawing, this.below, this.top);
    this.camera = null;
    this.movedAt = -Infinity;
    this.missingSince = null;
    this.ground = new Ground(this);
    this.marks = new Marks(this);
    this.pointers = new Map();
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  resize() {
    const { width, height } = this.element.getBoundingClientRect();
    if (!width || !height) return;
    const wasWhole = !this.camera || this.isWhole, ratio = Math.min(2, window.devicePixelRatio || 1);
    const size = { width: Math.round(width * ratio), height: Math.round(height * ratio), ratio };
    for (const canvas of [this.below, this.top]) Object.assign(canvas, { width: size.width, height: size.height });
    this.ground.painted = "";
    const before = this.camera;
    this.look(wasWhole ? Camera.whole(this.run.bounds, size) : Camera.around(...before.centre, (before.scale / before.ratio) * ratio, size), wasWhole);
  }

  // Show what a camera shows.
  look(camera, isWhole) {
    this.camera = camera;
    this.isWhole = isWhole;
    this.player.redraw();
  }

  showWhole() {
    if (this.camera) this.look(Camera.whole(this.run.bounds, this.camera), true);
  }

  get width() {
    return this.camera ? this.camera.width : 0;
  }

  get height() {
    return this.camera ? this.camera.height : 0;
  }

  x(x) {
    return this.camera.x(x);
  }

  y(y) {
    return this.camera.y(y);
  }

  px(size) {
    return this.camera.px(size);
  }

  zoom(factor, px, py) {
    const smallest = 0.3 * Camera.whole(this.run.bounds, this.camera).scale;
    const scale = Math.min(this.camera.ratio * MAX_SCALE, Math.max(smallest, this.camera.scale * factor));
    this.movedAt = performance.now();
    this.look(this.camera.zoomed(scale, px, py), false);
  }

  move(dx, dy) {
    this.movedAt = performance.now();
    this.look(this.camera.moved(dx, dy), false);
  }

  get isMoving() {
    return performance.now() - this.movedAt < MOVING_MS;
  }

  listen() {
    const { top } = this, at = (event) => [event.offsetX * this.camera.ratio, event.offsetY * this.camera.ratio];
    top.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / (event.deltaMode ? 20 : 500)), ...at(event));
    }, { passive: false });
    top.addEventListener("pointerdown", (event) => {
      top.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, at(event));
      this.isClick = this.pointers.size === 1;
      this.pressed = at(event);
    });
    top.addEventListener("pointermove", (event) => {
      const before = this.pointers.get(event.pointerId);
      if (!before) return;
      const now = at(event);
      if (distance(...now, ...this.pressed) > this.px(5)) this.isClick = false;
      if (this.isClick) return;
      if (this.pointers.size === 2) this.pinch(event.pointerId, before, now);
      else this.move(now[0] - before[0], now[1] - before[1]);
      this.pointers.set(event.pointerId, now);
    });
    const lift = (event) => {
      if (this.pointers.delete(event.pointerId) && this.isClick && event.type === "pointerup") this.click(...at(event));
      this.isClick = false;
    };
    top.addEventListener("pointerup", lift);
    top.addEventListener("pointercancel", lift);
    top.addEventListener("dblclick", () => this.showWhole());
    top.addEventListener("keydown", (event) => this.press(event));
  }

  // With the map focused, alt and an arrow move it.
  press(event) {
    const ways = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const way = event.altKey && !event.ctrlKey && !event.metaKey && ways[event.key];
    if (!way) return;
    event.preventDefault();
    this.move(way[0] * STEP * this.width, way[1] * STEP * this.height);
  }

  // Zoom about the middle of the map.
  zoomBy(factor) {
    if (this.camera) this.zoom(factor, this.width / 2, this.height / 2);
  }

  // Move the map to a place that it does not show.
  bringIn(x, y) {
    if (!this.camera) return;
    const px = this.x(x), py = this.y(y), { camera } = this;
    if (px < 0 || py < 0 || px > this.width || py > this.height) this.look(Camera.around(x, y, camera.scale, camera), false);
  }

  pinch(id, before, now) {
    const [other] = [...this.pointers].filter(([key]) => key !== id).map(([, place]) => place);
    const was = distance(...before, ...other), is = distance(...now, ...other);
    this.move((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
    if (was > 0) this.zoom(is / was, (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  }

  click(px, py) {
    this.player.pick(this.number, this.under(px, py));
  }

  // The robot or the node under a point; null if there is none.
  under(px, py) {
    const { run, player } = this, time = player.timeOf(run);
    let nearest = this.px(PICK_PX), found = null;
    for (let robot = 0; robot < run.count; robot++) {
      const [x, y] = run.pose(robot, time);
      const away = distance(this.x(x), this.y(y), px, py);
      if (away < nearest) [nearest, found] = [away, { robot }];
    }
    if (found || !player.layers.has("trees")) return found;
    const { nodes, t } = run.knownBy(player.robotOf(run));
    for (let k = lastBy(t, time); k >= 0; k--) {
      const node = nodes[k], away = distance(this.x(run.nodes.x[node]), this.y(run.nodes.y[node]), px, py);
      if (away < nearest) [nearest, found] = [away, { robot: run.nodes.robot[node], node }];
    }
    return found;
  }

  // Prepare the map of a time, until a moment.
  prepare(time, until) {
    if (this.camera) this.ground.prepare(time, until);
  }

  // Say what the map shows in place of what is chosen, and that its run has ended.
  tell() {
    const { run, player } = this, said = [];
    if (player.robot >= run.count) said.push(`no robot ${player.robot}: map of the team`);
    if (player.time > run.end) said.push(`${run.isGoingOn ? "so far until" : "ended at"} ${run.end.toFixed(1)} s`);
    this.state.hidden = !said.length;
    this.state.textContent = said.join("; ");
  }

  // Say so if layers have been missing for a while.
  tellDrawing(now) {
    if (this.isThere) this.missingSince = null;
    else this.missingSince ??= now;
    const isLate = this.missingSince !== null && now - this.missingSince > NOTE_AFTER_MS;
    if (this.drawing.hidden !== isLate) return;
    this.drawing.hidden = !isLate;
    this.element.setAttribute("aria-busy", String(isLate));
  }

  get isThere() {
    return !this.camera || this.ground.isThere;
  }

  get isDone() {
    return !this.camera || this.ground.isDone;
  }

  // Whether there is something to draw that was not there when it was drawn last.
  get hasNews() {
    return Boolean(this.camera) && this.ground.key !== this.ground.painted;
  }

  // Draw the map of the time for which it was prepared, as far as it is there.
  paint(time) {
    if (!this.camera) return;
    this.ground.paint();
    this.marks.draw(time);
  }
}

function make(tag, properties, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}
