// A map on the screen: its canvases, which part of the world it shows, and what is under a point.

const PICK_PX = 14;
const MARGIN = 0.04;

class View {
  constructor(run, number, player) {
    this.run = run;
    this.number = number;
    this.player = player;
    this.element = make("div", { className: "view" });
    this.name = make("p", { className: "name", textContent: run.title });
    this.below = make("canvas", { className: "below" });
    this.top = make("canvas", { className: "top", tabIndex: 0 });
    this.top.setAttribute("role", "img");
    this.top.setAttribute("aria-label", `Map of ${run.title}`);
    this.element.append(this.name, this.below, this.top);
    this.version = 0;
    this.scale = 1;
    this.left = 0;
    this.bottom = 0;
    this.ground = new Ground(this);
    this.marks = new Marks(this);
    this.pointers = new Map();
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  resize() {
    const { width, height } = this.element.getBoundingClientRect();
    if (!width || !height) return;
    const wasWhole = this.version === 0 || this.isWhole;
    this.ratio = Math.min(2, window.devicePixelRatio || 1);
    this.width = Math.round(width * this.ratio);
    this.height = Math.round(height * this.ratio);
    for (const canvas of [this.below, this.top]) Object.assign(canvas, { width: this.width, height: this.height });
    if (wasWhole) this.showWhole();
    else this.changed();
  }

  showWhole() {
    if (!this.width) return;
    const [x0, y0, x1, y1] = this.run.bounds;
    const share = 1 - 2 * MARGIN;
    this.scale = share * Math.min(this.width / (x1 - x0), this.height / (y1 - y0));
    this.left = (x0 + x1) / 2 - this.width / 2 / this.scale;
    this.bottom = (y0 + y1) / 2 - this.height / 2 / this.scale;
    this.isWhole = true;
    this.changed();
  }

  changed() {
    this.version++;
    this.player.redraw();
  }

  x(x) {
    return (x - this.left) * this.scale;
  }

  y(y) {
    return this.height - (y - this.bottom) * this.scale;
  }

  // Pixels of the screen as pixels of the canvas.
  px(size) {
    return size * this.ratio;
  }

  // The same, and less where much of the world is on the screen.
  thin(size) {
    return this.px(size) * Math.min(1, Math.max(0.3, this.scale / this.ratio / 15));
  }

  zoom(factor, px, py) {
    const [x0, y0, x1, y1] = this.run.bounds;
    const smallest = 0.3 * Math.min(this.width / (x1 - x0), this.height / (y1 - y0));
    const scale = Math.min(this.ratio * 2000, Math.max(smallest, this.scale * factor));
    const x = this.left + px / this.scale, y = this.bottom + (this.height - py) / this.scale;
    this.left = x - px / scale;
    this.bottom = y - (this.height - py) / scale;
    this.scale = scale;
    this.isWhole = false;
    this.changed();
  }

  move(dx, dy) {
    this.left -= dx / this.scale;
    this.bottom += dy / this.scale;
    this.isWhole = false;
    this.changed();
  }

  listen() {
    const { top } = this, at = (event) => [event.offsetX * this.ratio, event.offsetY * this.ratio];
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

  // Draw the run at a time; returns whether all of it could be drawn in time.
  draw(time) {
    if (!this.width) return true;
    const isDone = this.ground.draw(time);
    this.marks.draw(time);
    return isDone && this.marks.isDone;
  }
}

function make(tag, properties, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}
