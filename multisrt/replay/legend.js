// The legend of robots: their colours and numbers; a click chooses a robot.

class Legend {
  constructor(player, element) {
    this.player = player;
    // Robots of a number have one colour in all runs.
    this.run = player.runs.reduce((most, run) => (run.count > most.count ? run : most));
    this.buttons = this.run.robots.map((_, robot) => {
      const swatch = make("span", { className: "swatch" });
      const button = make("button", { type: "button", title: `Robot ${robot}: its own map and its reasons` }, swatch, String(robot));
      button.setAttribute("aria-label", `Robot ${robot}`);
      button.addEventListener("click", () => player.choose(player.run, player.robot === robot ? TEAM : robot));
      return button;
    });
    element.append(...this.buttons);
  }

  recolour() {
    this.buttons.forEach((button, robot) => {
      const { fill, edge } = this.player.colours.bodyOf(this.run, robot);
      Object.assign(button.firstChild.style, { backgroundColor: fill, borderColor: edge });
    });
  }

  update() {
    const { chosen, robot, run } = this.player, shown = `${run} ${robot}`;
    if (shown === this.shown) return;
    this.shown = shown;
    this.buttons.forEach((button, number) => {
      button.setAttribute("aria-pressed", String(number === robot));
      button.disabled = number >= chosen.count;
    });
  }
}
