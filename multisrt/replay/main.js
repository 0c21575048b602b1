// Read the data, make the player, and tell what is wrong if that fails.

async function main() {
  const player = new Player(await readData(), new Colours());
  const isNew = !location.hash;
  const address = new Address(player);
  const live = new Live(player, address, isNew);
  // For scripts: what is shown, and where robots are.
  window.replay = {
    player,
    address,
    live,
    poses: (time, number = 0) => player.runs[number].robots.map((_, robot) => player.runs[number].pose(robot, time)),
    frontier: (time, robot = TEAM, number = 0) => frontierAt(player.runs[number], robot, time),
  };
}

function frontierAt(run, robot, time) {
  const frontier = run.frontier(robot);
  frontier.advance(time, Infinity);
  return frontier.at(time).map(([x0, y0, x1, y1]) => [[x0, y0], [x1, y1]]);
}

main().catch((error) => {
  const problem = byId("problem");
  problem.hidden = false;
  problem.textContent = `This replay cannot be shown. ${error.message}`;
  byId("main").hidden = true;
  throw error;
});
