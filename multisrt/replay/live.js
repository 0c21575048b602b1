// A run that goes on: the page reloads itself from time to time, and stays as its reader left it.

const TICK_MS = 200;
const IDLE_MS = 600; // after the last touch of a key or the pointer
const CHOICE_MS = 5000; // that a list may stay open
const NEWS_S = 30; // without which the page says so
const SHOW_MS = 400; // by which the page is shown, drawn or not

class Live {
  constructor(player, address, isNew) {
    Object.assign(this, { player, address });
    this.element = byId("live");
    this.reloadS = this.element ? Number(this.element.dataset.reloadS) : 0;
    this.isGoingOn = this.reloadS > 0;
    this.since = Date.now();
    this.isHeld = false; // by scripts
    this.restore();
    if (this.isGoingOn) this.goOn(isNew);
  }

  goOn(isNew) {
    const { player } = this, settled = player.whenSettled;
    this.said = this.element.firstChild.textContent;
    this.begun = performance.now();
    this.touched = -Infinity;
    for (const kind of ["pointerdown", "pointerup", "pointercancel", "keydown", "wheel"]) {
      addEventListener(kind, (event) => this.touch(event), { capture: true, passive: true });
    }
    addEventListener("pagehide", () => this.keep());
    byId("follow").addEventListener("click", () => player.seek(player.end));
    player.whenSettled = () => {
      player.isFollowing = player.time >= player.end;
      this.tell();
      settled();
    };
    if (isNew) player.time = player.end;
    player.update();
    this.show();
    setInterval(() => this.tick(), TICK_MS);
  }

  touch(event) {
    this.touched = performance.now();
    if (event.type === "pointerdown") this.isPressed = true;
    if (event.type === "pointerup" || event.type === "pointercancel") this.isPressed = false;
  }

  // Whether reloading the page would disturb its reader.
  get isBusy() {
    const choosing = document.activeElement instanceof HTMLSelectElement ? CHOICE_MS : IDLE_MS;
    return this.player.isPlaying || document.hidden || this.isHeld || this.isPressed || byId("keys").open
      || !getSelection().isCollapsed || performance.now() - this.touched < choosing;
  }

  tick() {
    this.tell();
    if (performance.now() - this.begun < 1000 * this.reloadS || this.isBusy) return;
    this.begun = Infinity;
    history.replaceState(null, "", this.address.hash);
    location.reload();
  }

  tell() {
    const old = Math.round((Date.now() - this.since) / 1000);
    const news = old > Math.max(NEWS_S, 5 * this.reloadS) ? ` No news for ${old} s.` : "";
    const text = this.said + news, shown = this.element.firstChild;
    if (shown.textContent !== text) shown.textContent = text;
    byId("follow").hidden = this.player.time >= this.player.end;
  }

  // Show the page when its maps are drawn: until then the one before stays on the screen.
  show() {
    const isDrawn = this.player.isComplete && !this.player.isWaiting && this.areSized;
    if (isDrawn || performance.now() - this.begun > SHOW_MS) delete document.documentElement.dataset.goingOn;
    else setTimeout(() => this.show(), 20);
  }

  get areSized() {
    return this.player.views.every((view) => view.width);
  }

  get key() {
    return `multisrt replay ${location.pathname}`;
  }

  // What the address does not hold.
  keep() {
    const { player } = this, focused = document.activeElement;
    const state = {
      number: this.element.dataset.number,
      since: this.since,
      isDark: player.colours.isDark,
      node: player.panel.node,
      focus: focused ? focused.id : "",
      folds: [...document.querySelectorAll("details")].map((fold) => [fold.id, fold.open]),
      views: player.views.map(({ isWhole, camera }) => isWhole || { scale: camera.scale / camera.ratio, centre: camera.centre }),
    };
    try {
      sessionStorage.setItem(this.key, JSON.stringify(state));
    } catch {
      // Some browsers keep nothing for a file: then the map is shown whole again.
    }
  }

  restore() {
    let state = null;
    try {
      state = JSON.parse(sessionStorage.getItem(this.key));
      sessionStorage.removeItem(this.key);
    } catch {
      return;
    }
    if (!state) return;
    const { player } = this;
    if (this.element && state.number === this.element.dataset.number) this.since = state.since;
    if (state.isDark !== player.colours.isDark) player.colours.set(state.isDark);
    for (const [id, isOpen] of state.folds) if (byId(id)) byId(id).open = isOpen;
    if (state.node !== null && state.node < player.chosen.nodes.count) player.panel.showNode(state.node);
    if (state.focus && byId(state.focus)) byId(state.focus).focus();
    this.restoreViews(state.views);
  }

  restoreViews(kept) {
    if (!this.areSized) {
      requestAnimationFrame(() => this.restoreViews(kept));
      return;
    }
    this.player.views.forEach((view, number) => {
      const at = kept[number];
      if (!at || at === true) return;
      view.look(Camera.around(...at.centre, at.scale * view.camera.ratio, view.camera), false);
    });
  }
}
