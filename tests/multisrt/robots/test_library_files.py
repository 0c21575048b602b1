"""Which files are libraries'."""

import json
import sysconfig
from pathlib import Path

import numpy as np
import pytest

from multisrt.robots import library_files, registry
from multisrt.robots.library_files import folders_above, is_library_file


@pytest.mark.parametrize("file", [json.__file__, np.__file__, registry.__file__, "<string>"])
def test_files_of_libraries(file):
    assert is_library_file(file)


@pytest.mark.parametrize("file", [__file__, "mine.py", "/home/me/mine.py", "/tmp/ipykernel_7/8.py"])
def test_files_of_users(file):
    assert not is_library_file(file)
    assert folders_above(file) == []


def test_a_folder_beside_a_library_is_a_users():
    library = sysconfig.get_path("stdlib")
    assert is_library_file(f"{library}/mine.py")
    assert not is_library_file(f"{library}-of-mine/mine.py")


def test_links_to_a_library_count_as_the_library(tmp_path, monkeypatch):
    (tmp_path / "lib").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "lib")
    monkeypatch.setattr(library_files, "_FOLDERS", (tmp_path / "lib",))
    assert folders_above(tmp_path / "link" / "mine.py") == [Path(tmp_path / "lib")]
