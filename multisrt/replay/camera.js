// Which part of the world is on the screen. A camera never changes: a map that is moved or zoomed
// gets a new one, and pictures that were drawn with another one can be shown in the new one's place.

class Camera {
  constructor({ left, bottom, scale, width, height, ratio }) {
    Object.assign(this, { left, bottom, scale, width, height, ratio, number: Camera.count++ });
  }

  // The whole of some bounds, with a margin around them.
  static whole([x0, y0, x1, y1], { width, height, ratio }) {
    const scale = (1 - 2 * MARGIN) * Math.min(width / (x1 - x0), height / (y1 - y0));
    return Camera.around((x0 + x1) / 2, (y0 + y1) / 2, scale, { width, height, ratio });
  }

  static around(x, y, scale, { width, height, ratio }) {
    return new Camera({ left: x - width / 2 / scale, bottom: y - height / 2 / scale, scale, width, height, ratio });
  }

  get centre() {
    return [this.left + this.width / 2 / this.scale, this.bottom + this.height / 2 / this.scale];
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

  moved(dx, dy) {
    return new Camera({ ...this, left: this.left - dx / this.scale, bottom: this.bottom + dy / this.scale });
  }

  // Zoomed to a scale; a point of the canvas stays where it is.
  zoomed(scale, px, py) {
    const x = this.left + px / this.scale, y = this.bottom + (this.height - py) / this.scale;
    return new Camera({ ...this, left: x - px / scale, bottom: y - (this.height - py) / scale, scale });
  }

  // Draw a picture that was drawn with another camera where it belongs.
  place(context, canvas, camera) {
    const zoom = this.scale / camera.scale, x = (camera.left - this.left) * this.scale;
    const y = this.height - (camera.bottom - this.bottom) * this.scale - canvas.height * zoom;
    if (camera === this) context.drawImage(canvas, 0, 0);
    else context.drawImage(canvas, x, y, canvas.width * zoom, canvas.height * zoom);
  }
}

Camera.count = 0;
