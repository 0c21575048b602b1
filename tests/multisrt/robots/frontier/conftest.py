"""What tests of frontier robots share."""

from collections.abc import Callable, Generator
from typing import Any

import pytest


@pytest.fixture(scope="session")
def acts_of() -> Callable[[Generator[Any, None, Any]], tuple[list[Any], Any]]:
    """Run some steps to their end, without outcomes; return the actions and the result."""

    def run(steps: Generator[Any, None, Any]) -> tuple[list[Any], Any]:
        acts = []
        try:
            while True:
                acts.append(next(steps))
        except StopIteration as end:
            return acts, end.value

    return run
