"""SRT-Star against SRT-Radial over environments, team sizes and seeds, on all cores.

`python examples/compare_star_radial.py` prints a table and writes a figure; it takes a minute.
"""

import multisrt as ms


def main(environments=("apartment", "open"), robots=(1, 2, 4), seeds=5, folder="out/examples"):
    """Compare the strategies; print an overview and draw the times to 95 % coverage."""
    found = ms.compare(environments, ["srt-star", "srt-radial"], robots=robots, seeds=seeds)
    print(found.overview())
    found.plot("time_to_95_s").save(folder)


if __name__ == "__main__":
    main()
