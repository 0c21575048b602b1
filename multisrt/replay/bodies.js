// Bodies of robots with their numbers, which are moved apart where robots are close together.

const MIN_BODY_PX = 5;
const INSIDE_PX = 8; // radius of a body from which its number is written on it
const NUMBER_HEIGHT_PX = 13;
const NUMBER_RINGS = 4; // around a robot, on which its number is put

class Bodies extends Brush {
  constructor(view) {
    super(view);
    this.sprites = new Map();
    this.seats = [];
  }

  draw(poses, doing, areCutOff, chosen) {
    const { view } = this, { run, player } = view;
    this.shapes = poses.map((pose, robot) => this.shape(robot, pose));
    this.shapes.forEach((shape, robot) => {
      this.drawBody(shape, colourOfBody(player.colours, run, robot, doing[robot]), doing[robot], areCutOff[robot]);
      if (robot === chosen) this.ring(shape.x, shape.y, shape.size + view.px(4), player.colours.link, 3);
    });
    this.drawNumbers(doing);
  }

  // The outline of a body on the canvas, and the radius of what is drawn of it.
  shape(robot, [x, y, heading]) {
    const { view } = this, { body } = view.run.robots[robot], cos = Math.cos(heading), sin = Math.sin(heading);
    const outline = Array.from(body.x, (dx, i) => [view.x(x + cos * dx - sin * body.y[i]), view.y(y + sin * dx + cos * body.y[i])]);
    const px = view.x(x), py = view.y(y);
    const reach = Math.max(...outline.map(([ox, oy]) => distance(px, py, ox, oy)));
    const isSmall = reach < view.px(MIN_BODY_PX);
    return { robot, x: px, y: py, cos, sin, outline, isSmall, size: isSmall ? view.px(MIN_BODY_PX) : reach };
  }

  drawBody({ x, y, cos, sin, outline, isSmall, size }, { fill, edge }, doing, isCutOff) {
    const { c, view } = this, { colours } = view.player;
    c.beginPath();
    if (isSmall) c.arc(x, y, size, 0, 2 * Math.PI);
    else for (const point of outline) c.lineTo(...point);
    c.closePath();
    this.stroke(colours.halo, 4);
    this.fill(fill);
    this.stroke(edge, 1.8, doing === "not started" ? [2, 2] : []);
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(x + 1.4 * size * cos, y - 1.4 * size * sin);
    this.stroke(edge, 1.8);
    if (isCutOff) this.ring(x, y, size + view.px(5), colours.frontier, 2, [3, 3]);
    if (doing === "dead") this.cross(x, y, size + view.px(3));
  }

  cross(x, y, size) {
    const { c } = this, { colours } = this.view.player;
    c.beginPath();
    c.moveTo(x - size, y - size);
    c.lineTo(x + size, y + size);
    c.moveTo(x - size, y + size);
    c.lineTo(x + size, y - size);
    this.stroke(colours.halo, 4);
    this.stroke(colours.ink, 2);
  }

  drawNumbers(doing) {
    const { view, shapes } = this, { colours } = view.player, taken = [];
    for (const shape of shapes) {
      const { robot, x, y, size } = shape;
      if (x < 0 || y < 0 || x > view.width || y > view.height) continue;
      if (size >= view.px(INSIDE_PX)) this.label(String(robot), x, y, colours.on(colourOfBody(colours, view.run, robot, doing[robot]).fill), 10);
      else this.drawNumber(shape, this.seat(shape, taken));
    }
  }

  // A place for the number of a robot that covers no other number and no other robot: above it if
  // there is room, otherwise around it, farther and farther away. While the time runs a number
  // stays where it is as long as there is room.
  seat(shape, taken) {
    const { robot } = shape, width = this.sprite(String(robot)).width * 0.7;
    const seats = [0, ...Array.from({ length: 12 * NUMBER_RINGS - 1 }, (_, k) => k + 1)];
    const kept = this.view.player.isPlaying ? this.seats[robot] : undefined;
    const boxes = (kept === undefined ? seats : [kept, ...seats]).values();
    let found = null;
    for (const seat of boxes) {
      const box = this.box(shape, seat, width);
      if (!found) found = box;
      if (!this.isFree(box, shape, taken)) continue;
      found = box;
      break;
    }
    this.seats[robot] = found.seat;
    taken.push(found);
    return found;
  }

  box({ x, y, size }, seat, width) {
    const { view } = this, ring = Math.floor(seat / 12), turn = seat % 12;
    // Above, then in turn right and left of that.
    const angle = Math.PI / 2 + (turn % 2 ? -1 : 1) * Math.ceil(turn / 2) * (Math.PI / 6);
    const away = size + view.px(7 + 13 * ring), height = view.px(NUMBER_HEIGHT_PX);
    return { seat, ring, x: x + (away + width / 4) * Math.cos(angle), y: y - away * Math.sin(angle), width, height };
  }

  isFree(box, own, taken) {
    const { view, shapes } = this;
    if (box.x < box.width || box.y < box.height || box.x > view.width - box.width || box.y > view.height - box.height) return false;
    if (taken.some((other) => Math.abs(other.x - box.x) < (other.width + box.width) / 2 && Math.abs(other.y - box.y) < box.height)) return false;
    return shapes.every(({ robot, x, y, size }) => robot === own.robot || Math.abs(x - box.x) > size + box.width / 2 || Math.abs(y - box.y) > size + box.height / 2);
  }

  drawNumber({ robot, x, y, size }, box) {
    const { c, view } = this, sprite = this.sprite(String(robot));
    if (box.ring > 0) {
      const away = distance(x, y, box.x, box.y), share = size / away, left = 1 - view.px(6) / away;
      c.beginPath();
      c.moveTo(x + share * (box.x - x), y + share * (box.y - y));
      c.lineTo(x + left * (box.x - x), y + left * (box.y - y));
      this.stroke(view.player.colours.halo, 3);
      this.stroke(view.player.colours.ink, 1);
    }
    c.drawImage(sprite, Math.round(box.x - sprite.width / 2), Math.round(box.y - sprite.height / 2));
  }

  // Text is slow to draw: each number is drawn once.
  sprite(text) {
    const { view, sprites } = this, { ratio } = view.camera, key = `${text} ${view.player.colours.key} ${ratio}`;
    if (!sprites.has(key)) sprites.set(key, this.drawSprite(text));
    return sprites.get(key);
  }

  drawSprite(text) {
    const { view } = this, { colours } = view.player;
    const canvas = make("canvas", { width: view.px(12 + 8 * text.length), height: view.px(18) });
    const context = canvas.getContext("2d");
    context.translate(canvas.width / 2, canvas.height / 2);
    context.font = `600 ${view.px(11)}px system-ui, "Liberation Sans", sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.lineJoin = "round";
    context.strokeStyle = colours.halo;
    context.lineWidth = view.px(3);
    context.strokeText(text, 0, 0);
    context.fillStyle = colours.ink;
    context.fillText(text, 0, 0);
    return canvas;
  }
}

function colourOfBody(colours, run, robot, doing) {
  const colour = colours.bodyOf(run, robot);
  if (doing === "dead") return { fill: colours.solid, edge: colours.ink };
  return doing === "not started" ? { ...colour, fill: colours.paper } : colour;
}
