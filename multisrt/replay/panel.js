// The side of the page: the chosen robot and why it decided, layers, events, about.

const EVENTS_SHOWN = 9;
const MAX_KNOWERS = 12; // of a node, that are named
const NARROW = "(max-width: 52rem), (max-height: 30rem)"; // as in the style: one column
const COLUMNS = /\S {2,}\S/; // of a line of a table
const DECIDED = "What it decided"; // a heading of explanations, which a time may follow after a comma

const LAYERS = [
  ["truth", "World (truth)"],
  ["seen", "Seen by scans"],
  ["regions", "Safe regions"],
  ["delivered", "Known to the base"],
  ["trees", "Trees"],
  ["bridges", "Bridges"],
  ["paths", "Paths"],
  ["frontier", "Frontier"],
  ["goals", "Goals"],
  ["bodies", "Bodies"],
  ["groups", "Groups (GPR, GER)"],
  ["masters", "Masters"],
  ["links", "Radio links"],
  ["messages", "Messages"],
  ["stops", "Protective stops"],
];

class Panel {
  constructor(player) {
    this.player = player;
    this.node = null;
    this.eventsKey = null;
    const { runs } = player;
    this.fillRuns(runs);
    this.fillLayers();
    this.fillAbout(runs);
    if (matchMedia(NARROW).matches) {
      for (const name of ["layers", "events"]) byId(`fold-${name}`).open = false;
    }
    for (const name of ["robot", "events"]) byId(`fold-${name}`).addEventListener("toggle", () => this.update());
  }

  fillRuns(runs) {
    const select = byId("run");
    runs.forEach((run, number) => select.append(make("option", { value: number, textContent: `${number + 1}: ${run.title}` })));
    byId("which-run").hidden = runs.length < 2;
    select.addEventListener("change", () => this.player.choose(Number(select.value), this.player.robot));
    byId("robot").addEventListener("change", (event) => this.player.choose(this.player.run, Number(event.target.value)));
  }

  fillRobots() {
    const select = byId("robot"), { count } = this.player.chosen;
    if (select.length === count + 1) return;
    select.replaceChildren(make("option", { value: TEAM, textContent: "the team" }));
    for (let robot = 0; robot < count; robot++) select.append(make("option", { value: robot, textContent: `robot ${robot}` }));
  }

  fillLayers() {
    this.samples = [];
    const symbols = symbolsOf(this.player.runs), shown = new Set(symbols.map(([name]) => name));
    for (const [name, title] of LAYERS.filter(([layer]) => shown.has(layer))) {
      const box = make("input", { type: "checkbox", name, checked: this.player.layers.has(name) });
      box.addEventListener("change", () => this.player.toggle(name, box.checked));
      const [, , paint] = symbols.find(([layer]) => layer === name);
      byId("layers").append(make("label", {}, box, this.sample(paint), make("span", { textContent: title })));
    }
    for (const [, words, paint] of symbols) byId("symbols").append(make("li", {}, this.sample(paint), make("span", { textContent: words })));
  }

  sample(paint) {
    const sample = new Sample(this.player);
    this.samples.push([sample, paint]);
    return sample.canvas;
  }

  recolour() {
    for (const [sample, paint] of this.samples) sample.paint(paint);
  }

  fillAbout(runs) {
    const about = byId("about");
    for (const run of runs) {
      const { outcome, reason, digest, made, conditions, deaths } = run.packed;
      const why = reason ? ` (${reason})` : "", died = deaths.map((death) => `; ${death}`).join("");
      about.append(make("p", { textContent: `${run.title}: ${outcome} after ${run.end.toFixed(1)} s${why}${died}.` }));
      about.append(make("p", { textContent: `Set-up: ${conditions.join("; ")}.` }));
      about.append(make("p", { textContent: `Made by multisrt ${made}, digest ${digest}.` }));
      if (!run.links && (run.count > 1 || run.base)) about.append(make("p", { textContent: "The radio reaches everywhere: no links are drawn." }));
      if (!run.scans) about.append(make("p", { textContent: "The recording has no scans: what was seen is not known." }));
    }
    for (const note of this.player.notes) about.append(make("p", { textContent: note }));
  }

  update() {
    const { player } = this;
    this.fillRobots();
    byId("run").value = player.run;
    byId("robot").value = player.robot;
    for (const box of byId("layers").querySelectorAll("input")) box.checked = player.layers.has(box.name);
    this.tellRobot();
    if (byId("fold-events").open) this.list();
  }

  tellRobot() {
    if (byId("fold-robot").open) this.tell();
  }

  tell() {
    const { chosen, robot } = this.player, time = this.player.timeOf(chosen), why = byId("why");
    const text = robot === TEAM
      ? "Choose a robot, here, by its number on the keyboard or by a click on the map or below it: its own map is shown, and why it decided as it did."
      : chosen.why(robot, time);
    this.showText(why, text);
    this.tellNode(chosen);
  }

  // Tables stay as they are, all other lines are wrapped. The first line, which has the time,
  // changes far more often than the others.
  showText(element, text) {
    const end = text.indexOf("\n") < 0 ? text.length : text.indexOf("\n"), rest = text.slice(end);
    if (rest !== this.shownRest || !element.firstChild) {
      const parts = partsOf(rest).map(([part, isTable]) => (isTable ? make("span", { className: "table", tabIndex: 0, textContent: part }) : part));
      element.replaceChildren(document.createTextNode(""), ...parts);
      this.shownRest = rest;
    }
    element.firstChild.data = text.slice(0, end);
  }

  tellNode(run) {
    const element = byId("node"), { nodes } = run, node = this.node;
    element.hidden = node === null;
    if (node === null || this.shownNode === node) return;
    this.shownNode = node;
    const decision = this.decisionFor(run, node), robot = nodes.robot[node];
    const go = make("button", { type: "button", textContent: decision === null ? "Go to its time" : `Why robot ${robot} went there` });
    go.addEventListener("click", () => {
      this.player.seek(decision === null ? nodes.t[node] : decision);
      if (decision !== null) this.player.choose(this.player.run, robot);
    });
    const close = make("button", { type: "button", textContent: "Close" });
    close.addEventListener("click", () => this.showNode(null));
    element.replaceChildren(make("p", { textContent: aboutNode(run, node) }), make("p", { textContent: whoKnows(run, node) }), go, " ", close);
  }

  // The robot that is chosen, in a few words that are read out.
  aboutRobot() {
    const { chosen, robot } = this.player, time = this.player.timeOf(chosen);
    if (robot === TEAM) return "map of the team";
    const [about, ...sections] = chosen.why(robot, time).split("\n\n");
    const decided = sections.map((section) => section.split("\n")).find(([title]) => title.split(",")[0] === DECIDED);
    return decided ? `${about} ${decided.slice(1).map((line) => line.trim()).join("; ")}` : about;
  }

  // The time of the decision after which a robot came to a node.
  decisionFor(run, node) {
    if (!run.explanations) return null;
    const { log } = run, by = log.by[run.nodes.robot[node]];
    for (let k = lastBy(by.t, run.nodes.t[node] - 0.0005); k >= 0; k--) if (run.isDecision(by.rows[k])) return by.t[k];
    return null;
  }

  showNode(node) {
    this.node = node;
    this.shownNode = null;
    this.update();
  }

  // The events about the present time, those of the chosen robot if there is one.
  list() {
    const { chosen, robot } = this.player, { log } = chosen;
    const own = robot === TEAM ? { t: log.t, rows: null } : log.by[robot];
    const at = this.player.positions(1).behind[this.player.run] - 1, first = Math.max(0, Math.min(at - 4, own.t.length - EVENTS_SHOWN));
    const key = `${this.player.run} ${robot} ${first} ${at}`;
    if (key === this.eventsKey) return;
    this.eventsKey = key;
    const items = [];
    for (let k = first; k < Math.min(own.t.length, first + EVENTS_SHOWN); k++) {
      const row = own.rows ? own.rows[k] : k;
      const said = `robot ${log.robot[row]}: ${log.texts[log.text[row]]}`;
      const button = make("button", { type: "button" }, make("span", { className: "time", textContent: log.t[row].toFixed(2) }), make("span", { textContent: said }));
      button.addEventListener("click", () => this.player.goTo(this.player.run, row));
      const item = make("li", {}, button);
      if (k === at) item.setAttribute("aria-current", "true");
      items.push(item);
    }
    const focused = [...byId("events").children].findIndex((item) => item.contains(document.activeElement));
    byId("events").replaceChildren(...items);
    if (focused >= 0 && items[focused]) items[focused].firstChild.focus();
  }
}

// The parts of a text that are tables, with the lines between their rows, and those that are not.
function partsOf(text) {
  const parts = [];
  for (const section of text.split(/(?<=\n)(?=\n)/)) {
    const lines = section.split(/(?<=\n)/), rows = lines.flatMap((line, k) => (COLUMNS.test(line.trim()) ? [k] : []));
    const [first, last] = rows.length > 1 ? [rows[0], rows.at(-1) + 1] : [lines.length, lines.length];
    parts.push([lines.slice(0, first).join(""), false], [lines.slice(first, last).join(""), true], [lines.slice(last).join(""), false]);
  }
  return parts.filter(([part]) => part);
}

function aboutNode(run, node) {
  const { serial, robot, parent, x, y, t, stage, stageName } = run.nodes, from = parent[node];
  const where = `of robot ${robot[node]} at (${x[node].toFixed(2)}, ${y[node].toFixed(2)})`;
  if (stage[node] === "scan") return `Scan ${serial[node]} ${where}: made at ${t[node].toFixed(2)} s; it showed something new.`;
  const origin = from < 0 ? "a root" : `found by: ${stageName[node]}; its parent is node ${serial[from]} of robot ${robot[from]}`;
  return `Node ${serial[node]} ${where}: added at ${t[node].toFixed(2)} s, ${origin}.`;
}

function whoKnows(run, node) {
  const known = [];
  for (let robot = 0; robot < run.count; robot++) {
    const since = run.knownBy(robot).since[node];
    if (robot !== run.nodes.robot[node] && since < Infinity) known.push(`${robot} (${since.toFixed(1)} s)`);
  }
  const more = known.length > MAX_KNOWERS ? `, and ${known.length - MAX_KNOWERS} more` : "";
  return `Known to robots: ${known.slice(0, MAX_KNOWERS).join(", ") || "no other"}${more}.`;
}

function byId(id) {
  return document.getElementById(id);
}
