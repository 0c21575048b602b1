// Pictures of layers, drawn in slices of time into canvases of their own. A picture shows one time
// only: while it is not complete for the time that is wanted it shows nothing. While a map that was
// moved or zoomed is redrawn, its previous picture stands in, and goes on with the time.

const COPIES = 6; // of a picture at most, from which it goes back
const COPY_PIXELS = 3e7; // bound of the pixels of all copies of a picture
const MIN_ITEMS = 300; // between two copies

class Picture {
  // Draw what is there at a time, until a moment. While the map is moved, pictures that take more
  // than one slice wait.
  advance(time, camera, until, isMoving) {
    this.time = time;
    if (!this.front) this.front = this.sheet(camera);
    this.isThere = this.fill(this.front, time, until);
    if (this.front.camera === camera) this.back = null;
    else if (!this.isThere) [this.front, this.back] = [this.sheet(camera), null];
    else if (!isMoving || !this.isSlow) this.redraw(time, camera, until);
  }

  // Whether it is complete with the camera that is wanted.
  isDone(camera) {
    return this.isThere && this.front.camera === camera;
  }

  redraw(time, camera, until) {
    if (!this.back || this.back.camera !== camera) {
      this.back = this.sheet(camera);
      this.slices = 0;
    }
    this.slices++;
    const isFull = this.fill(this.back, time, until);
    this.isSlow = this.slices > 1 || !isFull;
    if (!isFull) return;
    this.spare = this.front.canvas;
    [this.front, this.back] = [this.back, null];
  }

  canvas(camera) {
    const canvas = this.spare || document.createElement("canvas");
    this.spare = null;
    return Object.assign(canvas, { width: camera.width, height: camera.height });
  }

  // What tells one state of the picture from another.
  get key() {
    return this.isThere ? `${this.front.camera.number} ${this.front.revision}` : "none";
  }

  show(context, camera) {
    if (this.isThere) camera.place(context, this.front.canvas, this.front.camera);
  }
}

// A picture to which items are added with time; copies from time to time make it cheap to go back.
class Growing extends Picture {
  // `items` are {t: times}; `paint(context, number, camera)` draws one of them.
  constructor(items, paint) {
    super();
    Object.assign(this, { items, paint });
  }

  sheet(camera) {
    const canvas = this.canvas(camera), room = Math.floor(COPY_PIXELS / (camera.width * camera.height));
    const copies = Math.max(1, Math.min(COPIES, room));
    const every = Math.max(MIN_ITEMS, Math.ceil(this.items.t.length / (copies + 1)));
    return { camera, canvas, context: canvas.getContext("2d"), revision: 0, every, copies: new Map() };
  }

  // `revision` of a sheet is how many items are drawn.
  fill(sheet, time, until) {
    const wanted = lastBy(this.items.t, time) + 1;
    if (wanted < sheet.revision) this.goBack(sheet, wanted);
    while (sheet.revision < wanted) {
      this.paint(sheet.context, sheet.revision++, sheet.camera);
      if (sheet.revision % sheet.every === 0) this.copy(sheet);
      if (sheet.revision % 16 === 0 && performance.now() > until) break;
    }
    return sheet.revision === wanted;
  }

  copy({ camera, canvas, revision, copies }) {
    if (copies.has(revision)) return;
    const copy = make("canvas", { width: camera.width, height: camera.height });
    copy.getContext("2d").drawImage(canvas, 0, 0);
    copies.set(revision, copy);
  }

  goBack(sheet, wanted) {
    const { context, camera, copies } = sheet, from = Math.floor(wanted / sheet.every) * sheet.every;
    context.globalCompositeOperation = "source-over";
    context.clearRect(0, 0, camera.width, camera.height);
    if (from > 0) context.drawImage(copies.get(from), 0, 0);
    sheet.revision = from;
  }
}
