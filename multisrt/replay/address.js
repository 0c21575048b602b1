// The address of the page: #t=12.5&run=0&robot=2&layers=truth,trees&speed=10, and &live at the
// newest time of a run that goes on.

class Address {
  constructor(player) {
    this.player = player;
    addEventListener("hashchange", () => this.read());
    this.read();
    player.whenSettled = () => this.write();
    this.write();
  }

  read() {
    const { player } = this, given = new URLSearchParams(location.hash.slice(1));
    const number = (name) => (given.has(name) && given.get(name) !== "" && isFinite(given.get(name)) ? Number(given.get(name)) : null);
    const run = number("run"), robot = number("robot"), time = number("t"), pace = number("speed");
    if (given.has("layers")) {
      const names = given.get("layers").split(",");
      player.layers = new Set(LAYERS.map(([name]) => name).filter((name) => names.includes(name)));
    }
    if (PACES.includes(pace)) player.pace = pace;
    byId("speed").value = player.pace;
    if (Number.isInteger(run) && run >= 0 && run < player.runs.length) player.run = run;
    if (Number.isInteger(robot) && robot >= 0 && robot < player.chosen.count) player.robot = robot;
    else if (given.has("t")) player.robot = TEAM;
    if (given.has("live")) player.time = player.end;
    else if (time !== null) player.time = Math.max(0, Math.min(player.end, time));
    player.update();
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
    if (this.player.isPlaying) return;
    const { hash } = this;
    clearTimeout(this.timer);
    // Browsers refuse more than some hundred changes in half a minute.
    this.timer = setTimeout(() => hash !== location.hash && history.replaceState(null, "", hash), 120);
  }
}
