// Strokes and texts on the upper canvas of a map.

class Brush {
  constructor(view) {
    this.view = view;
    this.c = view.top.getContext("2d");
  }

  stroke(colour, width, dashes = []) {
    const { c, view } = this;
    c.strokeStyle = colour;
    c.lineWidth = view.px(width);
    c.setLineDash(dashes.map((length) => view.px(length)));
    c.stroke();
    c.setLineDash([]);
  }

  fill(colour) {
    this.c.fillStyle = colour;
    this.c.fill();
  }

  // Between two places in the world.
  segment(x0, y0, x1, y1) {
    const { c, view } = this;
    c.moveTo(view.x(x0), view.y(y0));
    c.lineTo(view.x(x1), view.y(y1));
  }

  ring(x, y, radius, colour, width, dashes = []) {
    this.c.beginPath();
    this.c.arc(x, y, radius, 0, 2 * Math.PI);
    this.stroke(colour, width, dashes);
  }

  label(text, x, y, colour, size) {
    const { c, view } = this;
    c.font = `600 ${view.px(size)}px system-ui, "Liberation Sans", sans-serif`;
    c.textAlign = "center";
    c.textBaseline = "middle";
    c.fillStyle = colour;
    c.fillText(text, x, y);
  }
}
