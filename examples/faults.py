"""A team in which one robot dies, one falls silent for a while and one starts late.

`python examples/faults.py` lists the faults, explains a robot's decision and writes a picture.
"""

from pathlib import Path

import multisrt as ms
from multisrt.events import CameBack, Died, FellSilent, Joined, PresumedLost

FAULTS = (
    ms.Death(robot=1, time_s=60.0, when="moving"),
    ms.Silence(robot=2, time_s=40.0, duration_s=80.0),
    ms.LateStart(robot=3, time_s=30.0),
)


def main(environment="apartment", folder="out/examples"):
    """Explore with four robots and three faults; list what happened."""
    run = ms.explore(environment, robots=4, faults=FAULTS, seed=1)
    print(run)
    for event in run.recording.events:
        if isinstance(event, Died | FellSilent | CameBack | Joined):
            print(f"{event.time_s:7.1f} s  robot {event.robot}: {type(event).__name__}")
        elif isinstance(event, PresumedLost):
            print(f"{event.time_s:7.1f} s  robot {event.robot} presumes {event.other} lost")
    print()
    print(run.why(robot=0, time_s=100.0))
    picture = Path(folder) / "faults.svg"
    picture.parent.mkdir(parents=True, exist_ok=True)
    run.save_svg(picture)
    print()
    print(f"The trees: {picture}")


if __name__ == "__main__":
    main()
