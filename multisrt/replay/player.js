// The clock of all runs, what is chosen, and the controls.

const PACES = [0.5, 1, 2, 5, 10, 20, 50, 100];
const PANEL_MS = 150; // between two updates of texts while it plays
const PANEL_S = 0.5; // of the run, by which texts may be late
const ZOOM = 1.25; // by a key
const NOTE_MS = 2000; // between two notes of the time in the address while it plays
const PLAYING_MS = 12; // of a frame, for pictures
const STANDING_MS = 40; // the same while the time stands
const AHEAD_MS = 8; // of an idle moment, for later times
const DIGITS_MS = 700; // in which a second digit belongs to the first

class Player {
  constructor(data, colours) {
    this.runs = data.runs.map((packed) => new Run(packed));
    this.notes = data.notes;
    this.colours = colours;
    this.end = Math.max(...this.runs.map((run) => run.end));
    this.time = 0;
    this.pace = 10;
    this.isPlaying = false;
    this.run = 0;
    this.robot = TEAM;
    this.layers = new Set(LAYERS.map(([name]) => name));
    this.isStill = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.frames = [];
    this.whenSettled = () => {};
    const stage = byId("stage");
    this.views = this.runs.map((run, number) => new View(run, number, this));
    stage.append(...this.views.map((view) => view.element));
    stage.classList.toggle("several", this.runs.length > 1);
    this.lines = new Lines(this, byId("curves"), byId("strips"));
    this.legend = new Legend(this, byId("legend"));
    this.panel = new Panel(this);
    this.listen();
    colours.whenChanged = () => this.recolour();
    this.recolour();
    this.update();
  }

  get chosen() {
    return this.runs[this.run];
  }

  // The robot whose map is shown of a run.
  robotOf(run) {
    return this.robot < run.count ? this.robot : TEAM;
  }

  timeOf(run) {
    return Math.min(this.time, run.end);
  }

  listen() {
    byId("play").addEventListener("click", () => this.playOrPause());
    byId("previous").addEventListener("click", () => this.step(-1));
    byId("next").addEventListener("click", () => this.step(1));
    byId("previous-decision").addEventListener("click", () => this.step(-1, true));
    byId("next-decision").addEventListener("click", () => this.step(1, true));
    const scrub = byId("scrub");
    scrub.max = this.end;
    scrub.step = "any";
    scrub.addEventListener("input", () => this.seek(Number(scrub.value)));
    const speed = byId("speed");
    for (const pace of PACES) speed.append(make("option", { value: pace, textContent: `${pace}\u00d7` }));
    speed.addEventListener("change", () => this.setPace(Number(speed.value)));
    byId("theme").addEventListener("click", () => this.colours.set(!this.colours.isDark));
    byId("help").addEventListener("click", () => byId("keys").showModal());
    addEventListener("keydown", (event) => this.press(event));
  }

  press(event) {
    const { key, target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || byId("keys").open) return;
    const isChoice = target instanceof HTMLSelectElement;
    if (isChoice || (key === " " && (target instanceof HTMLButtonElement || target.tagName === "SUMMARY" || target.type === "checkbox"))) return;
    // A table that the keyboard has gone to is scrolled by its arrows.
    if (key.startsWith("Arrow") && target.matches?.(".table:focus-visible")) return;
    const keys = this.keys(), name = key.length === 1 ? key.toLowerCase() : key;
    const act = (event.shiftKey && keys[`Shift${name}`]) || keys[name];
    if (act) act();
    else if (/^[0-9]$/.test(key)) this.digit(key);
    else return;
    event.preventDefault();
  }

  keys() {
    return {
      " ": () => this.playOrPause(),
      ArrowLeft: () => this.step(-1),
      ArrowRight: () => this.step(1),
      ShiftArrowLeft: () => this.seek(this.time - 1),
      ShiftArrowRight: () => this.seek(this.time + 1),
      ",": () => this.step(-1, true),
      ".": () => this.step(1, true),
      n: () => this.nextNode(-1),
      Shiftn: () => this.nextNode(1),
      i: () => this.focusedView.zoomBy(ZOOM),
      o: () => this.focusedView.zoomBy(1 / ZOOM),
      Home: () => this.seek(0),
      End: () => this.seek(this.end),
      "+": () => this.faster(1),
      "=": () => this.faster(1),
      "-": () => this.faster(-1),
      Escape: () => this.choose(this.run, TEAM),
      z: () => this.views.forEach((view) => view.showWhole()),
      d: () => this.colours.set(!this.colours.isDark),
      f: () => this.showRate(byId("rate").hidden),
      "?": () => byId("keys").showModal(),
    };
  }

  digit(key) {
    const now = performance.now();
    const both = this.digits && now - this.digits.at < DIGITS_MS ? this.digits.text + key : key;
    const text = Number(both) < this.chosen.count ? both : key;
    this.digits = { text, at: now };
    if (Number(text) < this.chosen.count) this.choose(this.run, Number(text));
    else this.say(`there is no robot ${text}`);
  }

  // The map that has the focus, or that of the chosen run.
  get focusedView() {
    return this.views.find((view) => view.top === document.activeElement) || this.views[this.run];
  }

  // Choose the node that the chosen robot, or any, made before or after the one that is chosen: at
  // first the newest.
  nextNode(direction) {
    const { chosen, robot, panel } = this, { nodes } = chosen, time = this.timeOf(chosen), own = [];
    for (let node = 0; node < nodes.count; node++) {
      if (nodes.t[node] <= time && (robot === TEAM || nodes.robot[node] === robot)) own.push(node);
    }
    const at = own.indexOf(panel.node), node = at < 0 ? own.at(-1) : own[at + direction];
    if (node === undefined) {
      this.say(direction < 0 ? "no earlier node" : "no later node");
      return;
    }
    this.views[this.run].bringIn(nodes.x[node], nodes.y[node]);
    this.pick(this.run, { robot: nodes.robot[node], node });
  }

  playOrPause() {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  play() {
    if (this.time >= this.end) this.time = 0;
    this.isPlaying = true;
    this.last = null;
    this.say("");
    this.showPlaying();
    this.redraw();
  }

  pause() {
    this.isPlaying = false;
    this.showPlaying();
    this.say(`paused at ${this.time.toFixed(2)} s`);
    this.update();
  }

  showPlaying() {
    const button = byId("play");
    byId("play-icon").setAttribute("d", this.isPlaying ? "M3 2h4v12H3zM9 2h4v12H9z" : "M4 2l10 6-10 6z");
    button.setAttribute("aria-label", this.isPlaying ? "Pause" : "Play");
  }

  seek(time) {
    this.say(""); // an event is no longer the last one
    this.time = this.within(time);
    this.update();
  }

  within(time) {
    return Math.max(0, Math.min(this.end, time));
  }

  setPace(pace) {
    this.pace = pace;
    byId("speed").value = pace;
    this.whenSettled();
  }

  faster(by) {
    const now = PACES.indexOf(this.pace);
    this.setPace(PACES[Math.max(0, Math.min(PACES.length - 1, now + by))]);
    this.say(`speed ${this.pace}`);
  }

  // Events of a run that are stepped through: those of the chosen robot, or all.
  eventsOf(run) {
    const robot = this.robotOf(run);
    return robot === TEAM ? { t: run.log.t, rows: null } : run.log.by[robot];
  }

  // How many events of each run lie behind; `shown` is the run of the last of them.
  positions(direction) {
    const key = `${this.time} ${this.robot}`;
    if (this.steps && this.steps.key === key) return this.steps;
    const behind = this.runs.map((run) => {
      const { t } = this.eventsOf(run);
      if (direction > 0) return this.time === 0 ? 0 : lastBy(t, this.time) + 1;
      let k = lastBy(t, this.time) + 1;
      while (k > 0 && t[k - 1] >= this.time) k--;
      return k;
    });
    return { behind, shown: null };
  }

  // The next or previous event, or decision, of the chosen robot, or of any robot of any run.
  step(direction, toDecision = false) {
    if (this.isPlaying) this.pause();
    const { behind, shown } = this.positions(direction);
    let best = null;
    this.runs.forEach((run, number) => {
      const { t, rows } = this.eventsOf(run);
      let k = direction > 0 ? behind[number] : behind[number] - (shown === number ? 2 : 1);
      while (toDecision && k >= 0 && k < t.length && !run.isDecision(rows ? rows[k] : k)) k += direction;
      if (k < 0 || k >= t.length) return;
      if (!best || direction * (t[k] - best.t) < 0) best = { t: t[k], number, k, row: rows ? rows[k] : k };
    });
    if (!best) {
      this.say(`no ${direction > 0 ? "later" : "earlier"} ${toDecision ? "decision" : "event"}`);
      return;
    }
    if (direction < 0 && shown !== null && shown !== best.number) behind[shown]--;
    if (toDecision) this.passOver(behind, direction, best.t);
    behind[best.number] = best.k + 1;
    this.show(best.number, best.row, behind);
  }

  // Leave behind, or ahead, what other runs have before, or after, a time.
  passOver(behind, direction, time) {
    this.runs.forEach((run, number) => {
      const { t } = this.eventsOf(run), upTo = lastBy(t, time) + 1;
      let before = upTo;
      while (before > 0 && t[before - 1] >= time) before--;
      behind[number] = direction > 0 ? Math.max(behind[number], before) : Math.min(behind[number], upTo);
    });
  }

  goTo(number, row) {
    this.time = this.runs[number].log.t[row];
    const { behind } = this.positions(1), { rows } = this.eventsOf(this.runs[number]);
    behind[number] = (rows ? rows.indexOf(row) : row) + 1;
    this.show(number, row, behind);
  }

  show(number, row, behind) {
    const run = this.runs[number];
    this.time = this.within(run.log.t[row]);
    this.steps = { behind, shown: number, key: `${this.time} ${this.robot}` };
    this.update();
    this.say((this.runs.length > 1 ? `${run.title}: ` : "") + run.said(row));
  }

  // Choose a robot of a run, or the team.
  choose(number, robot) {
    if (number !== this.run) this.panel.showNode(null);
    this.run = number;
    this.robot = robot < this.runs[number].count ? robot : TEAM;
    this.update();
    this.say(this.panel.aboutRobot());
  }

  // Choose what is under the pointer: a robot, or a node, which leaves the robot as it is.
  pick(number, found) {
    const { node, robot } = found || {};
    this.choose(number, found && node === undefined ? robot : this.robot);
    if (!found) return;
    byId("fold-robot").open = true;
    this.panel.showNode(node === undefined ? null : node);
    if (node !== undefined) this.say(aboutNode(this.chosen, node));
  }

  toggle(name, isOn) {
    if (isOn) this.layers.add(name);
    else this.layers.delete(name);
    this.update();
  }

  say(text) {
    byId("said").textContent = text;
  }

  recolour() {
    const button = byId("theme");
    button.setAttribute("aria-pressed", String(this.colours.isDark));
    this.lines.redraw();
    this.legend.recolour();
    this.panel.recolour();
    this.redraw();
  }

  // Show what has changed, at once in texts and on the maps in the next frame.
  update() {
    this.isChanged = true;
    this.tell();
    this.redraw();
    this.note();
  }

  note() {
    this.noted = performance.now();
    this.whenSettled();
  }

  tell() {
    byId("scrub").value = this.time;
    byId("scrub").setAttribute("aria-valuetext", `${this.time.toFixed(1)} s of ${this.end.toFixed(1)} s`);
    byId("clock").textContent = `${this.time.toFixed(1)} / ${this.end.toFixed(1)} s`;
    this.views.forEach((view, number) => view.element.classList.toggle("chosen", this.runs.length > 1 && number === this.run));
    for (const view of this.views) view.tell();
    this.lines.follow(this.time);
    this.lines.say(this.time);
    this.legend.update();
    this.panel.update();
    this.told = performance.now();
    this.toldTime = this.time;
  }

  redraw() {
    this.isWanted = true;
    this.schedule();
  }

  schedule() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    this.isWaiting = false;
    if (this.isPlaying) this.goOn(now);
    const until = performance.now() + (this.isPlaying ? PLAYING_MS : STANDING_MS);
    for (const view of this.views) view.prepare(this.timeOf(view.run), until);
    this.isThere = this.views.every((view) => view.isThere);
    this.isComplete = this.views.every((view) => view.isDone);
    for (const view of this.views) view.tellDrawing(performance.now());
    if (this.isWorthPainting) this.paint(now);
    if (this.isThere) this.isChanged = false;
    if (this.isPlaying || !this.isComplete) this.schedule();
    else this.lookAhead();
  }

  // What plays stays as it is until all maps of the next time are there.
  get isWorthPainting() {
    if (this.isPlaying) return this.isThere || this.isChanged;
    return this.isWanted || this.views.some((view) => view.hasNews);
  }

  // Move on by the time since the last frame, if all of that was shown.
  goOn(now) {
    if (this.last !== null && this.isThere) this.time = Math.min(this.end, this.time + (this.pace * Math.min(250, now - this.last)) / 1000);
    this.last = now;
  }

  paint(now) {
    this.isWanted = false;
    for (const view of this.views) view.paint(this.timeOf(view.run));
    this.count(now);
    if (!this.isPlaying) return;
    this.lines.follow(this.time);
    byId("clock").textContent = `${this.time.toFixed(1)} / ${this.end.toFixed(1)} s`;
    if (now - this.told > PANEL_MS || this.time - this.toldTime > PANEL_S) this.tell();
    if (now - this.noted > NOTE_MS) this.note();
    if (this.time >= this.end && this.isThere) this.pause();
  }

  // Find the frontiers of later times while there is nothing else to do, so that they are there
  // when somebody goes to these times.
  lookAhead() {
    if (this.isLooking || !this.layers.has("frontier")) return;
    this.isLooking = true;
    whenIdle(() => {
      this.isLooking = false;
      if (this.isPlaying || this.isWaiting) return;
      const until = performance.now() + AHEAD_MS;
      const isDone = this.views.map((view) => view.run.frontier(this.robotOf(view.run)).advance(view.run.end, until));
      if (!isDone.every(Boolean)) this.lookAhead();
    });
  }

  showRate(isShown) {
    byId("rate").hidden = !isShown;
    this.tellRate();
    this.redraw();
  }

  // Frames in the last second.
  count(now) {
    this.frames.push(now);
    while (this.frames[0] < now - 1000) this.frames.shift();
    if (!byId("rate").hidden) this.tellRate();
  }

  tellRate() {
    byId("rate").textContent = `${this.frames.length} frames/s`;
  }
}

// Call a function when the browser has nothing else to do.
function whenIdle(call) {
  if (window.requestIdleCallback) requestIdleCallback(call);
  else setTimeout(call, 50);
}
