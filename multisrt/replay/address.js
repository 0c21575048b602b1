// The address of the page: #t=12.5&run=0&robot=2&layers=truth,trees&speed=10, and &live at the
// newest time of a run that goes on.

const ADDRESS_PARTS = ["t", "run", "robot", "layers", "speed", "live"];
const MAX_IGNORED = 6; // parts that are named
const MAX_PART = 40; // characters of one of them

class Address {
  constructor(player) {
    this.player = player;
    addEventListener("hashchange", () => this.read());
    byId("ignored-close").addEventListener("click", () => (byId("ignored").hidden = true));
    this.read();
    player.whenSettled = () => this.write();
    this.write();
  }

  read() {
    const { player } = this, given = new URLSearchParams(location.hash.slice(1));
    this.ignored = [];
    const run = this.number(given, "run", isOf(player.runs.length), `runs are 0 to ${player.runs.length - 1}`);
    if (run !== null) player.run = run;
    const robot = this.number(given, "robot", isOf(player.chosen.count), `robots are 0 to ${player.chosen.count - 1}`);
    if (robot !== null) player.robot = robot;
    else if (given.has("t")) player.robot = TEAM;
    player.pace = this.number(given, "speed", (pace) => PACES.includes(pace), `not one of ${PACES.join(", ")}`) ?? player.pace;
    byId("speed").value = player.pace;
    this.readLayers(given);
    const time = this.number(given, "t", (t) => t >= 0 && t <= player.end + 1e-3, `not a time from 0 to ${player.end.toFixed(1)} s`);
    if (given.has("live")) player.time = player.end;
    else if (time !== null) player.time = Math.min(player.end, time);
    for (const [name, value] of given) if (!ADDRESS_PARTS.includes(name)) this.ignored.push(`${part(name, value)} (not known)`);
    this.tell();
    player.update();
  }

  // A number in the address; null if there is none that can be used.
  number(given, name, isValid, otherwise) {
    const text = given.get(name);
    if (text === null) return null;
    const value = Number(text);
    if (text.trim() && isFinite(value) && isValid(value)) return value;
    this.ignored.push(`${part(name, text)} (${otherwise})`);
    return null;
  }

  readLayers(given) {
    if (!given.has("layers")) return;
    const known = LAYERS.map(([name]) => name), names = given.get("layers").split(",").filter(Boolean);
    this.player.layers = new Set(known.filter((name) => names.includes(name)));
    const others = names.filter((name) => !known.includes(name));
    if (others.length) this.ignored.push(`${part("layers", others.join())} (no such layer)`);
  }

  // Say what of the address was ignored.
  tell() {
    const { ignored } = this, more = ignored.length > MAX_IGNORED ? `, and ${ignored.length - MAX_IGNORED} more` : "";
    byId("ignored").hidden = !ignored.length;
    byId("ignored-text").textContent = ignored.length ? `Ignored in the address: ${ignored.slice(0, MAX_IGNORED).join("; ")}${more}.` : "";
  }

  get hash() {
    const { player } = this;
    const parts = [`t=${Number(player.time.toFixed(3))}`];
    if (player.runs.length > 1) parts.push(`run=${player.run}`);
    if (player.robot !== TEAM) parts.push(`robot=${player.robot}`);
    parts.push(`layers=${[...player.layers].join(",")}`, `speed=${player.pace}`);
    if (player.isFollowing) parts.push("live");
    return `#${parts.join("&")}`;
  }

  write() {
    const { hash } = this;
    clearTimeout(this.timer);
    // Browsers refuse more than some hundred changes in half a minute.
    this.timer = setTimeout(() => hash !== location.hash && history.replaceState(null, "", hash), 120);
  }
}

function isOf(count) {
  return (value) => Number.isInteger(value) && value >= 0 && value < count;
}

function part(name, value) {
  const text = value ? `${name}=${value}` : name;
  return text.length > MAX_PART ? `${text.slice(0, MAX_PART)}\u2026` : text;
}
