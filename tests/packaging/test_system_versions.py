"""What dpkg lists is compared with what CI last ran with, and every difference is one line."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

import system_versions
from system_versions import DebianPackage, differences, named, packages, recorded, updates, with_dependencies

LISTING = """\
installed\tcmake\t3.25.1-1\tcmake\t3.25.1-1\tamd64\t\t, libc6 (>= 2.34), cmake-data (= 3.25.1-1), curl | wget:any (>= 1)
installed\twget\t1.21\twget\t1.21\tamd64\t\t,
installed\tlibc6\t2.36-9+deb12u10\tglibc\t2.36-9+deb12u10\tamd64\tlibc6-2.36\t,
installed\tlibc6\t2.36-9+deb12u10\tglibc\t2.36-9+deb12u10\ti386\t\t,
config-files\tcurl\t7.88\tcurl\t7.88\tamd64\t\t,
installed\tgcc-12-base\t12.2.0-14\tgcc-12\t12.2.0-14\tamd64\t\t,
installed\tmawk\t1.3.4\tmawk\t1.3.4\tamd64\tawk\tlibc6-2.36, awk,
"""


def test_dependencies_are_followed_through_alternatives_and_what_packages_provide() -> None:
    there = packages(LISTING)
    assert sorted(there) == ["cmake", "gcc-12-base", "libc6", "mawk", "wget"]
    assert there["libc6"].architecture == "amd64"
    assert list(with_dependencies(["cmake"], there)) == ["cmake", "libc6", "wget"]
    assert list(with_dependencies(["awk"], there)) == ["libc6", "mawk"]


def test_each_difference_is_a_line_with_both_versions() -> None:
    now = {
        "cmake": DebianPackage("cmake", "3.31", "cmake", "3.31", "amd64"),
        "wget": DebianPackage("wget", "1.21", "wget", "1.21", "amd64"),
        "zlib1g": DebianPackage("zlib1g", "1.2", "zlib", "1.2", "amd64"),
    }
    versions = {"cmake": "3.25.1-1", "wget": "1.21", "libc6": "2.36"}
    before = {name: DebianPackage(name, version, name, version, "amd64") for name, version in versions.items()}
    assert differences(before, now) == [
        "cmake: CI had 3.25.1-1, here is 3.31",
        "libc6: CI had 2.36, here is none",
        "zlib1g: CI had none, here is 1.2",
    ]


def test_every_system_package_has_its_version_recorded() -> None:
    versions = recorded()
    assert sorted(set(named()) - versions.keys()) == []
    assert {"libcholmod3", "libzmq5", "libtbb12"} <= versions.keys(), "what the daemon links is a dependency"
    version = re.compile(r"(\d+:)?[0-9][\w.+~-]*")
    assert all(version.fullmatch(one.version) and version.fullmatch(one.source_version) for one in versions.values())
    assert versions["libcholmod3"].source == "suitesparse"


def test_an_update_that_apt_knows_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tool = tmp_path / "apt-cache"
    tool.write_text(
        "#!/bin/sh\nprintf 'libssl3:\\n  Installed: 3.0.19\\n  Candidate: 3.0.22\\n  Version table:\\n"
        "zlib1g:\\n  Installed: 1.2\\n  Candidate: 1.2\\nnorm:\\n  Installed: (none)\\n  Candidate: 1.5\\n'\n"
    )
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    assert updates(["libssl3", "zlib1g", "norm"]) == {"libssl3": "3.0.22"}


def test_what_was_written_does_not_differ(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(system_versions, "RECORDED", tmp_path / "versions.txt")
    assert system_versions.main(["--write"]) == 0
    monkeypatch.setattr(system_versions, "updates", lambda names: {})
    assert system_versions.main([]) == 0
    assert capsys.readouterr().out == ""

    text = (tmp_path / "versions.txt").read_text()
    cmake = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", "cmake"], capture_output=True, text=True).stdout
    (tmp_path / "versions.txt").write_text(text.replace(f"\ncmake {cmake} ", "\ncmake 1.0 "))
    assert system_versions.main([]) == 0
    assert capsys.readouterr().out == f"cmake: CI had 1.0, here is {cmake}\n"
