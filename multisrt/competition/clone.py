"""A clone of the competition's repository: its validation, options, maps and starts."""

from __future__ import annotations

import hashlib
import zlib
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

import numpy as np
import yaml
from scipy import ndimage

from multisrt.competition.published import SIZES
from multisrt.environments.environment import Environment
from multisrt.environments.formats.files import build_environment, grid_polygons, require_file
from multisrt.environments.formats.numpy_array import mapped
from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.geometry.numerics.arrays import BoolArray

SIMULATOR_FILES: Final = {
    "scripts/base_policy.py": "53ec2c72acedcd32c3336606fde069b55c862e7d0f831e815ee929aa1cb37925",
    "scripts/base_station.py": "1221de9748a7df782b2c9b2967ecdb636d7b943e1ac866d2039c98aee451c6b4",
    "scripts/comm.py": "208409075b820ca6accca4eaf56a36135c5d329dcc8e26c27ce182f52c0a2a18",
    "scripts/environment.py": "516af533d75f75461f1eca9c041f2fff8f737f238e047841758e62b140139ff0",
    "scripts/policy.py": "923ea9d24087f31215407d4a4af7874e9cfe8e9f7de4fe9eb0eb804ba458fd4c",
    "scripts/policy_utils.py": "f3e0d69bb31b4430e017b0549abf7811d187df5fbb71f5b768dc7b3b0f2b83de",
    "scripts/robot.py": "1c071ab47daf0658e3936e7e2737320946634a4ba4d5ef422a6d39e546fb2dc2",
    "scripts/scoring.py": "72592812af791ba11844522e205dc438e890b2eebeb99a76d4f5f840e38cf192",
    "scripts/utils.py": "72f4361def4853a58270e39901ecc727069f385ee32ea375cdda2579fd8d2886",
}
"""SHA-256 of each file of the simulator, with line feeds as line ends."""

CONFIG: Final = "configs/multi-robot.yaml"

FIXED_OPTIONS: Final = {
    "lidar_range": 15,
    "num_laser": 2500,
    "pixel_per_meter": 10,
    "comm_range": 15,
    "attenuation_constant": 10,
    "transmitted_power": 20,
    "path_loss_exponent": 3.5,
    "power_threshold": -80,
    "pd_size": 200,
}
"""Options that are the same for all participants."""

CELL_M: Final = 0.1
"""Side in metres of a cell of the simulator, which is two by two pixels of a map."""

CLEARANCE_CELLS: Final = 6
"""Minimum clearance of drawn starts, in cells."""

MAX_FILE_BYTES: Final = 1_000_000
"""Maximum size of a file of the simulator."""

REPOSITORY: Final = "https://github.com/BYU-FROST-Lab/indoor-exploration-competition"


class Clone:
    """A clone of the competition's repository.

    Parameters
    ----------
    folder : Path
        Folder of the clone.
    any_version : bool
        Whether the simulator may differ from the version of the published scores.

    Attributes
    ----------
    folder : Path
        Folder of the clone.
    changed : tuple of str
        Files of the simulator that differ from the known version; empty unless `any_version`.

    Raises
    ------
    InvalidInputError
        If the folder is not a clone, or one of another version.
    """

    def __init__(self, folder: Path, *, any_version: bool = False) -> None:
        self.folder = folder
        missing = [
            name for name in (*SIMULATOR_FILES, CONFIG, "test_maps") if not (folder / name).exists()
        ]
        if missing:
            raise InvalidInputError(
                f"{folder} is not a clone of the competition: it has no {missing[0]}; clone it "
                f"with: git clone {REPOSITORY}"
            )
        self.changed = tuple(
            name for name, known in SIMULATOR_FILES.items() if self._digest(name) != known
        )
        if self.changed and not any_version:
            raise InvalidInputError(
                f"{folder / self.changed[0]} is not that of the known version of the competition"
                f"{_and_others(self.changed)}; restore it (git checkout), or run it as it is with "
                "--any-version: its scores may not be comparable with the published ones"
            )

    def _digest(self, name: str) -> str:
        path = self.folder / name
        if path.stat().st_size > MAX_FILE_BYTES:
            return "too large"
        return hashlib.sha256(path.read_bytes().replace(b"\r\n", b"\n")).hexdigest()

    @property
    def digest(self) -> str:
        """Digest of the simulator's files."""
        return hashlib.sha256("".join(map(self._digest, SIMULATOR_FILES)).encode()).hexdigest()[:16]

    def options(self) -> SimpleNamespace:
        """Return the options of the clone's configuration.

        Raises
        ------
        InvalidInputError
            If the file is not a mapping, or one of `FIXED_OPTIONS` has another value.
        """
        path = self.folder / CONFIG
        require_file(path)
        try:
            entries: Any = yaml.safe_load(path.read_text(encoding="utf-8"))
        except (yaml.YAMLError, UnicodeError) as error:
            raise InvalidInputError(f"{path} cannot be read: {error}") from error
        if not isinstance(entries, dict):
            raise InvalidInputError(f"{path} has no options")
        for name, value in FIXED_OPTIONS.items():
            if entries.get(name) != value:
                raise InvalidInputError(
                    f"{path} has {name}: {entries.get(name)}; it is {value} for all participants"
                )
        return SimpleNamespace(**{str(name): value for name, value in entries.items()})

    def maps(self, names: tuple[str, ...] = ()) -> tuple[str, ...]:
        """Return the given names of released maps, or all if none are given.

        Raises
        ------
        InvalidInputError
            If there is no map of one of the names.
        """
        for name in names:
            if name not in SIZES or not (self.folder / "test_maps" / name).is_dir():
                raise InvalidInputError(
                    f"the competition has no map {name!r}{did_you_mean(name, SIZES)}; it has "
                    f"{', '.join(SIZES)}"
                )
        return names or tuple(SIZES)

    def cells(self, name: str) -> tuple[BoolArray, BoolArray]:
        """Return which cells of a map are occupied, and which are inside the building.

        Parameters
        ----------
        name : str
            The map.

        Returns
        -------
        occupied, inside : (rows, columns) arrays of bool
            As in the simulator: a cell of two by two pixels is occupied if one of its pixels is, or
            if it extends beyond the edge of the map.

        Raises
        ------
        MapFormatError
            If a file is not an array of the expected kind.
        """
        folder = self.folder / "test_maps" / name
        occupancy, valid = (
            np.asarray(mapped(folder / f"{part}.npy")) for part in ("occ_map", "valid_space")
        )
        if occupancy.shape != valid.shape:
            raise InvalidInputError(
                f"{folder}: occ_map.npy has the shape {occupancy.shape}, and valid_space.npy "
                f"{valid.shape}"
            )
        return ~_all_of_blocks(occupancy != 0), _all_of_blocks(valid > 0)

    def starts(self, name: str, number: int, seed: int) -> tuple[tuple[int, int], ...]:
        """Draw starts: cells with clearance in the largest connected part of the building.

        Parameters
        ----------
        name : str
            The map.
        number : int
            Number of starts.
        seed : int
            Seed of the draws, which are independent for each map.

        Returns
        -------
        tuple of (column, row)
            In the order that ``--start_pose`` of the competition's ``main.py`` takes.

        Examples
        --------
        A hall of 4 m by 3 m:

        >>> occupied, inside = np.zeros((30, 40), bool), np.ones((30, 40), bool)
        >>> _drawn_starts(occupied, inside, 2, np.random.default_rng(3))
        ((26, 6), (11, 21))
        """
        occupied, inside = self.cells(name)
        generator = np.random.default_rng([seed, zlib.crc32(name.encode())])
        return _drawn_starts(occupied, inside, number, generator)

    def require_start(self, name: str, start: tuple[int, int]) -> None:
        """Raise `InvalidInputError` unless a cell (column, row) of a map is free."""
        occupied, _ = self.cells(name)
        column, row = start
        rows, columns = occupied.shape
        if not (0 <= column < columns and 0 <= row < rows):
            raise InvalidInputError(
                f"the start {column},{row} is not on {name}, which has {columns} columns and "
                f"{rows} rows of cells"
            )
        if occupied[row, column]:
            raise InvalidInputError(f"the start {column},{row} is in a wall of {name}")

    def environment(self, name: str) -> Environment:
        """Return a map as a world: the free cells inside the building, in metres.

        Raises
        ------
        MapFormatError
            If a file is not an array of the expected kind, or no cell is free.
        """
        (name,) = self.maps((name,))
        path = self.folder / "test_maps" / name / "occ_map.npy"
        occupied, inside = self.cells(name)
        free = ~occupied & inside
        return build_environment(
            path,
            grid_polygons(path, free, CELL_M),
            name=name,
            origin=f"{name} of the indoor exploration competition",
        )


def _all_of_blocks(pixels: BoolArray) -> BoolArray:
    """Return which blocks of two by two pixels are all true; pixels beyond the edge are false."""
    rows, columns = pixels.shape
    padded = np.pad(pixels, ((0, rows % 2), (0, columns % 2)))
    blocks = padded.reshape((rows + 1) // 2, 2, (columns + 1) // 2, 2)
    return np.asarray(blocks.all(axis=(1, 3)))


def _drawn_starts(
    occupied: BoolArray, inside: BoolArray, number: int, generator: np.random.Generator
) -> tuple[tuple[int, int], ...]:
    """Return starts (column, row), as `Clone.starts` draws them."""
    clearance = ndimage.distance_transform_cdt(np.pad(~occupied, 1))[1:-1, 1:-1]
    parts, count = ndimage.label((clearance > 1) & inside)
    sizes = np.bincount(parts.ravel(), minlength=count + 1)
    sizes[0] = 0
    cells = np.argwhere((parts == sizes.argmax()) & (clearance >= CLEARANCE_CELLS))
    if not count or len(cells) < number:
        raise InvalidInputError(f"the map has no {number} free cells for starts")
    drawn = cells[generator.choice(len(cells), number, replace=False)]
    return tuple((int(column), int(row)) for row, column in drawn)


def _and_others(names: tuple[str, ...]) -> str:
    return f" ({len(names) - 1} more differ)" if len(names) > 1 else ""
