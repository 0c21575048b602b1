// Plots against time: their axes, and a cursor at the present time.

const GUTTER_PX = 46; // left of a plot: the labels of its rows or values
const TOP_PX = 6;
const RIGHT_PX = 14;
const BOTTOM_PX = 17; // labels of times
const TIME_TICK_PX = 70; // between two of them, at least
const PLOT_FONT = '11px system-ui, "Liberation Sans", sans-serif';
const STEPS = [1, 2, 5];

class Plot {
  constructor(player, element, title, label) {
    this.player = player;
    this.ratio = 1;
    this.figure = make("figure", { className: "chart" });
    this.value = make("b", {});
    this.plot = make("div", { className: "plot" });
    this.canvas = make("canvas", {});
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", label);
    this.cursor = make("div", { className: "cursor" });
    Object.assign(this.cursor.style, { top: `${TOP_PX}px`, bottom: `${BOTTOM_PX}px` });
    this.plot.append(this.canvas, this.cursor);
    this.figure.append(make("figcaption", {}, make("span", { textContent: title }), this.value), this.plot);
    element.append(this.figure);
    this.listen();
  }

  listen() {
    const seek = (event) => {
      const { left, width } = this.plot.getBoundingClientRect(), x = event.clientX - left - GUTTER_PX;
      this.player.seek((this.player.end * x) / (width - GUTTER_PX - RIGHT_PX));
    };
    this.plot.addEventListener("pointerdown", (event) => {
      this.isSeeking = event.offsetX >= GUTTER_PX;
      if (!this.isSeeking) return;
      this.plot.setPointerCapture(event.pointerId);
      seek(event);
    });
    this.plot.addEventListener("pointermove", (event) => event.buttons && this.isSeeking && seek(event));
    new ResizeObserver(() => this.redraw()).observe(this.plot);
  }

  redraw() {
    const { width, height } = this.plot.getBoundingClientRect();
    if (!width) return;
    this.ratio = Math.min(2, window.devicePixelRatio || 1);
    Object.assign(this.canvas, { width: Math.round(width * this.ratio), height: Math.round(height * this.ratio) });
    const c = this.canvas.getContext("2d");
    // All that is drawn has the pixels of the screen as its unit.
    c.scale(this.ratio, this.ratio);
    this.width = width - GUTTER_PX - RIGHT_PX;
    this.height = height - TOP_PX - BOTTOM_PX;
    this.bottom = TOP_PX + this.height;
    this.drawTimes(c);
    this.paint(c);
    this.follow(this.player.time);
  }

  x(time) {
    return GUTTER_PX + (this.player.end > 0 ? (time / this.player.end) * this.width : 0);
  }

  follow(time) {
    if (this.width) this.cursor.style.transform = `translateX(${this.x(time)}px)`;
  }

  drawTimes(c) {
    const { colours, end } = this.player, ticks = ticksTo(end, this.width / TIME_TICK_PX);
    c.strokeStyle = colours.line;
    c.lineWidth = 1;
    for (const time of ticks) this.line(c, this.x(time), this.bottom, this.x(time), this.bottom + 3);
    for (const time of ticks) {
      const text = time === ticks.at(-1) ? `${time} s` : String(time), right = GUTTER_PX + this.width + RIGHT_PX;
      const half = this.widthOf(c, text) / 2;
      this.text(c, text, Math.min(this.x(time), right - half), this.bottom + 10, "center");
    }
  }

  line(c, x0, y0, x1, y1) {
    c.beginPath();
    c.moveTo(x0, y0);
    c.lineTo(x1, y1);
    c.stroke();
  }

  widthOf(c, text) {
    c.font = PLOT_FONT;
    return c.measureText(text).width;
  }

  text(c, text, x, y, align) {
    c.font = PLOT_FONT;
    c.textAlign = align;
    c.textBaseline = "middle";
    c.fillStyle = this.player.colours.soft;
    c.fillText(text, x, y);
  }

  say() {}
}

// Round numbers from 0 up to an end, of which there are few.
function ticksTo(end, count) {
  if (!(end > 0)) return [0];
  let step = 0, k = 0;
  const first = 10 ** Math.floor(Math.log10(end / Math.max(1, count)));
  do step = first * STEPS[k % 3] * 10 ** Math.floor(k / 3);
  while (end / step > Math.max(1, count) && ++k);
  return Array.from({ length: Math.floor(end / step + 1e-9) + 1 }, (_, n) => Number((n * step).toPrecision(12)));
}
