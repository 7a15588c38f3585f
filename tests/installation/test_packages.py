"""Which packages are installed, told by what Lappet's metadata asks for."""

from __future__ import annotations

from lappet.installation import check_packages

NEEDED = ["numpy>=1.26", "click>=8.1"]


def test_what_every_command_needs_is_there_with_its_versions() -> None:
    (found,) = check_packages(NEEDED)
    assert (found.name, found.state) == ("packages", "ok")
    assert found.value.startswith("click ")
    assert ", numpy " in found.value


def test_a_package_that_every_command_needs_and_is_not_there_is_broken() -> None:
    (found,) = check_packages([*NEEDED, "no-such-package-of-lappet>=1"])
    assert found.state == "broken"
    assert "no-such-package-of-lappet is not installed" in found.value
    assert found.remedy == "pip install no-such-package-of-lappet"


def test_an_extra_that_is_not_there_is_missing_and_says_how_to_get_it() -> None:
    wanted = [*NEEDED, "no-such-package-of-lappet; extra == 'plates'", 'numpy<2; extra == "plates"']
    needed, extra = check_packages(wanted)
    assert needed.state == "ok"
    assert (extra.name, extra.state) == ("extra plates", "missing")
    assert "lappet plate" in extra.value
    assert extra.remedy == 'pip install "lappet[plates]"'


def test_what_developers_need_is_not_looked_at() -> None:
    assert len(check_packages([*NEEDED, "no-such-package-of-lappet; extra == 'dev'"])) == 1
