"""The outcome, metrics and tables of a finished run."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Literal, overload

from multisrt.analysis.measuring import measure
from multisrt.analysis.metrics import Metrics
from multisrt.environments.environment import Environment
from multisrt.extras.frames import Column, DataFrame, Package, data_frame
from multisrt.recording import Recording, RunOutcome
from multisrt.spec import RunSpec

if TYPE_CHECKING:
    import pandas
    import polars


class MeasuredRun:
    """A run with its outcome, metrics and tables; see `Run`."""

    def __init__(self, recording: Recording, environment: Environment | None = None) -> None:
        self.recording = recording
        self.environment = recording.environment() if environment is None else environment
        # A recording does not have them.
        self._suggested_starts = None if environment is None else environment.starts

    @property
    def spec(self) -> RunSpec:
        """The spec of the run."""
        return self.recording.spec

    @property
    def outcome(self) -> RunOutcome:
        """Outcome of the run: `complete`, `stalled` or `out_of_time`."""
        return self.recording.footer.outcome

    @property
    def reason(self) -> str:
        """Why the run ended, as text."""
        return self.recording.footer.reason

    @property
    def digest(self) -> str:
        """SHA-256 of spec, environment and events; runs of equal specs have equal digests."""
        return self.recording.footer.digest

    @cached_property
    def metrics(self) -> Metrics:
        """The metrics of the run, computed on first use."""
        return measure(self.recording, self.environment)

    @overload
    def trajectories(self, frame: Literal["pandas"] | None = None) -> pandas.DataFrame: ...

    @overload
    def trajectories(self, frame: Literal["polars"]) -> polars.DataFrame: ...

    def trajectories(self, frame: Package | None = None) -> DataFrame:
        """Return the trajectories of all robots, as a data frame with one row per waypoint.

        Parameters
        ----------
        frame : {"pandas", "polars"}, optional
            Library of the data frame; by default pandas if it is installed, else polars.

        Returns
        -------
        pandas.DataFrame or polars.DataFrame
            Its columns `robot`, `time_s`, `x_m`, `y_m`, `heading_rad`, `motion` and `purpose` are
            described at `multisrt.analysis.run_tables.trajectories`.

        Raises
        ------
        MissingExtraError
            If neither pandas nor polars is installed (``multisrt[frames]``).

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", start=(2.0, 4.0), seed=1, max_time_s=10.0)
        >>> run.trajectories()[["robot", "time_s", "x_m", "y_m"]].head(1)
           robot  time_s  x_m  y_m
        0      0     0.0  2.0  4.0
        """
        from multisrt.analysis.run_tables import trajectories

        return data_frame(trajectories(self.recording), frame)

    @overload
    def coverage_curve(self, frame: Literal["pandas"] | None = None) -> pandas.DataFrame: ...

    @overload
    def coverage_curve(self, frame: Literal["polars"]) -> polars.DataFrame: ...

    def coverage_curve(self, frame: Package | None = None) -> DataFrame:
        """Return the area covered and seen over time, as a data frame with one row per change.

        Parameters and errors are those of `trajectories`.

        Returns
        -------
        pandas.DataFrame or polars.DataFrame
            Its columns `time_s`, `coverage`, `seen`, `covered_area_m2` and `seen_area_m2` are
            described at `multisrt.analysis.run_tables.coverage_curve`.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", seed=1)
        >>> float(run.coverage_curve()["coverage"].iloc[-1]) == run.metrics.coverage
        True
        """
        return data_frame(self._curve, frame)

    @overload
    def events(self, frame: Literal["pandas"] | None = None) -> pandas.DataFrame: ...

    @overload
    def events(self, frame: Literal["polars"]) -> polars.DataFrame: ...

    def events(self, frame: Package | None = None) -> DataFrame:
        """Return all events, as a data frame with one row per event.

        Parameters and errors are those of `trajectories`.

        Returns
        -------
        pandas.DataFrame or polars.DataFrame
            Its columns `time_s`, `robot`, `event`, `x_m`, `y_m`, `heading_rad` and `fields` are
            described at `multisrt.analysis.run_tables.events`.

        Examples
        --------
        >>> import multisrt as ms
        >>> ms.explore("open", seed=1, max_time_s=10.0).events()["event"].iloc[0]
        'sensed'
        """
        from multisrt.analysis.run_tables import events

        return data_frame(events(self.recording), frame)

    @cached_property
    def _curve(self) -> Mapping[str, Column]:
        from multisrt.analysis.run_tables import coverage_curve

        return coverage_curve(self.recording, self.environment)

    def __repr__(self) -> str:
        return (
            f"Run({self.spec.strategy!r} in {self.environment.name!r}, seed {self.spec.seed}: "
            f"{self.outcome}, {100.0 * self.metrics.coverage:.1f} % covered in "
            f"{self.metrics.makespan_s:.0f} s)"
        )
