"""Help pages whose options stand in sections."""

from __future__ import annotations

from typing import Any

import click


class SectionedCommand(click.Command):
    """A command that lists its options in sections, in the order of `sections`.

    Parameters
    ----------
    *args, **kwargs
        As for `click.Command`.
    sections : dict of str to tuple of str
        For each heading, names of options such as ``--seed``; the others stand under "Options",
        at the end.
    """

    def __init__(self, *args: Any, sections: dict[str, tuple[str, ...]], **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._heading = {name: heading for heading, names in sections.items() for name in names}

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, one list for each section."""
        listed: dict[str, list[tuple[str, str]]] = {
            heading: [] for heading in (*self._heading.values(), "Options")
        }
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if isinstance(parameter, click.Option) and record is not None:
                listed[self._heading.get(parameter.opts[0], "Options")].append(record)
        for heading, records in listed.items():
            with formatter.section(heading):
                formatter.write_dl(records)
