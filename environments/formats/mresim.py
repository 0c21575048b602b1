"""Team files of the simulator MRESim: the pixels of an image in which robots start."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from multisrt.environments.environment import Environment
from multisrt.environments.formats.files import MAX_STARTS, read_text
from multisrt.environments.formats.image import opened_image
from multisrt.environments.formats.map_format import Beginning
from multisrt.geometry.errors import MapFormatError, shortened, shown

MAX_TEAM_BYTES: Final = 2**20
"""Upper bound of the size of team files, in bytes (1 MiB)."""

BASE_STATION: Final = "BaseStation"
"""Role of a robot that does not move."""

FIELDS: Final = (
    "number, name, x, y, heading, range, radio range, battery, "
    "role (BaseStation, Relay or Explorer), parent and child"
)

_REAL = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_ROBOT = re.compile(
    rf"\s*\d+\s+(?P<name>\S+)\s+(?P<x>\d{{1,8}})\s+(?P<y>\d{{1,8}})\s+{_REAL}(?:\s+\d+){{3}}"
    rf"\s+(?P<role>{BASE_STATION}|Relay|Explorer)\s+\d+\s+\d+\s*",
    re.ASCII,
)


@dataclass(frozen=True, slots=True)
class TeamMember:
    """A moving robot of a team file.

    Attributes
    ----------
    line : int
        Its line in the file, from 1.
    name : str
        Its name.
    column, row : int
        The pixel that it starts in; the first row is at the top.
    """

    line: int
    name: str
    column: int
    row: int


def read_team(path: Path) -> tuple[TeamMember, ...]:
    r"""Return the robots of a team file in the order of the file, without base stations.

    Parameters
    ----------
    path : Path
        One line for each robot: number, name, x, y (pixels), heading (rad), ranges of the sensor
        and the radio (pixels), battery, role, and the numbers of its parent and child.

    Returns
    -------
    tuple of TeamMember
        At least one.

    Raises
    ------
    MapFormatError
        If the file cannot be read, a line has other fields, or no robot moves.

    Notes
    -----
    Source: the class RobotTeamConfig of MRESim (J. de Hoog, V. Spirin, University of Oxford).
    Only the positions are used; MRESim has its own units, sensors and roles.

    Examples
    --------
    >>> with open("team.txt", "w") as file:
    ...     _ = file.write("1 Base 9 9 0.0 0 200 1000 BaseStation 1 1")
    ...     _ = file.write("\n2 A 5 8 3.14 200 200 1000 Explorer 1 1")
    >>> [(robot.name, robot.column, robot.row) for robot in read_team(Path("team.txt"))]
    [('A', 5, 8)]
    """
    members = []
    for number, line in enumerate(read_text(path, max_bytes=MAX_TEAM_BYTES).splitlines(), start=1):
        if not line.strip():
            continue
        found = _ROBOT.fullmatch(line)
        if found is None:
            raise MapFormatError(
                f"{path}, line {number} is {shown(line)}; a team file of MRESim has the fields "
                f"{FIELDS}"
            )
        if found["role"] != BASE_STATION:
            members.append(TeamMember(number, found["name"], int(found["x"]), int(found["y"])))
    if not members:
        raise MapFormatError(f"{path} has no robot that moves (Relay or Explorer)")
    return tuple(members)


def with_team(world: Environment, image: Path, resolution_m: float, team: Path) -> Environment:
    """Return the world of an image with the starts of a team file as its suggested starts.

    Parameters
    ----------
    world : Environment
        The world that was read from the image.
    image : Path
        The image.
    resolution_m : float
        Metres per pixel with which the world was read.
    team : Path
        The team file; see `read_team`.

    Returns
    -------
    Environment
        The same free space; each robot starts at the centre of its pixel.

    Raises
    ------
    MapFormatError
        If the team file cannot be read, or a robot starts outside free space.
    """
    members = read_team(team)
    with opened_image(image) as opened:
        height = opened.height
    starts = {}
    for member in members:
        x, y = (member.column + 0.5) * resolution_m, (height - member.row - 0.5) * resolution_m
        if not world.contains(x, y):
            raise MapFormatError(
                f"{team}, line {member.line}: {shortened(member.name)} starts in the "
                f"pixel ({member.column}, {member.row}), which is not free in {image.name}; "
                "is it the team of this image?"
            )
        starts[x, y] = member
    return Environment(
        world.name,
        world.free,
        starts=list(starts)[:MAX_STARTS],
        origin=f"{world.origin}, starts of {team.name}",
    )


def is_team(beginning: Beginning) -> bool:
    """Return whether a file begins as a team file."""
    return _ROBOT.fullmatch(beginning.first_line) is not None


def refuse_team_alone(path: Path) -> MapFormatError:
    """Return the error of a team file that is read as a map."""
    return MapFormatError(
        f"{path} is a team file of MRESim, which has robots and no map: read the image of its "
        "environment, and give this file with --starts-from (starts_from)"
    )
