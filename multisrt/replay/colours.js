// Colours by the theme, those of robots among them, and samples of them.

const DARK = "(prefers-color-scheme: dark)";

class Colours {
  constructor() {
    this.root = document.documentElement;
    this.isDark = matchMedia(DARK).matches;
    matchMedia(DARK).addEventListener("change", (event) => this.set(event.matches));
    this.whenChanged = () => {};
    this.set(this.isDark);
  }

  set(isDark) {
    this.isDark = isDark;
    this.key = this.root.dataset.theme = isDark ? "dark" : "light";
    const style = getComputedStyle(this.root);
    for (const name of ["paper", "ink", "soft", "line", "tint", "link", "solid", "wall", "free", "seen", "frontier", "message", "radio", "halo"]) {
      this[name] = style.getPropertyValue(`--${name}`).trim();
    }
    this.delivered = mixed(this.free, this.ink, this.isDark ? 0.55 : 0.6);
    this.whenChanged();
  }

  lineOf(run, robot) {
    const { colour } = run.robots[robot];
    return this.isDark ? mixed(colour, "#ffffff", 0.3) : colour;
  }

  areaOf(run, robot) {
    const { colour, area } = run.robots[robot];
    return this.isDark ? mixed(this.free, colour, 0.42) : area;
  }

  // Light, with a dark edge, also on a dark map.
  bodyOf(run, robot) {
    const { colour } = run.robots[robot];
    return { fill: mixed(colour, "#ffffff", 0.4), edge: mixed(colour, "#000000", this.isDark ? 0.65 : 0.5) };
  }

  // The colour of text on another colour.
  on(colour) {
    const [r, g, b] = channels(colour);
    return 0.299 * r + 0.587 * g + 0.114 * b > 140 ? "#1a1a1a" : "#ffffff";
  }
}

function channels(colour) {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}

function mixed(one, other, share) {
  const b = channels(other);
  const parts = channels(one).map((value, k) => Math.round(value + share * (b[k] - value)));
  return `#${parts.map((value) => value.toString(16).padStart(2, "0")).join("")}`;
}
