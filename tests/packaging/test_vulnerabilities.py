"""A version with a known vulnerability fails the check unless somebody judged it; what is not known is told."""

from __future__ import annotations

import datetime
import json
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

import pytest

import locked
import vulnerabilities
from vulnerabilities import Advisory, Known, Pin, check, pins, read, update, write

TODAY = datetime.date(2026, 11, 22)
PIN = Pin("pypi", "incision", "1.4")
ISSUE = Advisory("PYSEC-2026-1", "pypi", "incision", "1.4", ("CVE-2026-1",), "It cuts too deep.", ("1.5",))


def known(*advisories: Advisory, day: str = "2026-11-22", **asked: str) -> Known:
    """A file that both registries answered for on one day."""
    return Known({"pypi": day, "debian": day}, {"pypi": asked, "debian": {}}, list(advisories), [])


# --- the check -----------------------------------------------------------------------------------------------------


def test_a_pinned_version_that_is_affected_fails_with_its_names_and_its_remedy() -> None:
    failures, warnings = check(known(ISSUE, incision="1.4"), [PIN], TODAY)
    assert failures == ["incision 1.4: PYSEC-2026-1, CVE-2026-1, repaired in 1.5. It cuts too deep."]
    assert warnings == []


def test_one_that_was_judged_passes_until_it_is_about_nothing() -> None:
    file = known(ISSUE, incision="1.4")
    file.judged = [{"id": ISSUE.id, "name": "incision", "reason": "Nothing here cuts."}]
    assert check(file, [PIN], TODAY) == ([], [])
    failures, warnings = check(file, [Pin("pypi", "suture", "1.0")], TODAY)
    assert failures == []
    assert any("PYSEC-2026-1 for incision is about nothing" in line for line in warnings)


def test_a_judgment_of_another_package_helps_nobody() -> None:
    file = known(ISSUE, incision="1.4")
    file.judged = [{"id": ISSUE.id, "name": "suture", "reason": "Nothing here sews."}]
    assert len(check(file, [PIN], TODAY)[0]) == 1


@pytest.mark.parametrize(
    ("version", "fixed", "affected"),
    [
        ("1.4", ("1.5",), True),
        ("1.5", ("1.5",), False),
        ("1.10", ("1.5",), False),  # not as text
        ("1.4.1", ("1.5",), True),
        ("2.0", (), True),  # nobody knows a repaired one
        ("1.5", ("1.5", "2.1"), False),
        ("1.2", ("1.5",), True),
    ],
)
def test_a_version_that_was_raised_since_is_affected_until_it_is_repaired(
    version: str, fixed: tuple[str, ...], affected: bool
) -> None:
    advisory = Advisory("X", "pypi", "incision", "1.4", fixed_in=fixed)
    assert advisory.affects(Pin("pypi", "incision", version)) is affected


def test_versions_of_debian_are_compared_as_debian_does() -> None:
    advisory = Advisory("CVE-2026-2", "debian", "zeromq3", "4.3.4-6", fixed_in=("4.3.4-6+deb12u1",))
    assert advisory.affects(Pin("debian", "zeromq3", "4.3.4-6"))
    assert advisory.affects(Pin("debian", "zeromq3", "4.3.4-6+deb12u1~rc1"))
    assert not advisory.affects(Pin("debian", "zeromq3", "1:4.3.4-1"))
    assert not advisory.affects(Pin("pypi", "zeromq3", "4.3.4-6"))


@pytest.mark.parametrize(("day", "old"), [("2026-08-24", False), ("2026-08-23", True)])
def test_a_file_older_than_90_days_is_warned_about(day: str, old: bool) -> None:
    failures, warnings = check(known(day=day, incision="1.4"), [PIN], TODAY)
    assert failures == []
    assert [f"was last asked on {day}" in line for line in warnings] == [True] * 2 * old


def test_what_no_registry_answered_about_is_told() -> None:
    file = known(incision="1.3")
    file.updated["debian"] = None
    failures, warnings = check(file, [PIN], TODAY)
    assert failures == []
    assert warnings == [
        "PyPI has not answered about 1 of the versions: incision 1.4.",
        "Debian's security tracker was never asked: run vulnerabilities.py --update where it can be reached.",
    ]


# --- the file ------------------------------------------------------------------------------------------------------


def test_the_repositorys_file_is_read_and_its_packages_are_those_that_are_locked_and_carried() -> None:
    file = read()
    assert file.updated.keys() == file.asked.keys() == vulnerabilities.REGISTRIES.keys()
    there = {(pin.registry, pin.name) for pin in pins()}
    assert {("pypi", name) for name in locked.read()} <= there
    assert {("debian", name) for name in ("suitesparse", "openblas", "onetbb", "gcc-12", "eigen3")} <= there
    assert {(one.registry, one.name) for one in file.advisories} <= there
    assert {("pypi", name) for name in file.asked["pypi"]} <= there


def test_the_repositorys_pins_have_no_vulnerability_that_nobody_judged() -> None:
    assert check(read(), pins(), datetime.date.today())[0] == []


def test_what_is_written_is_what_is_read(tmp_path: Path) -> None:
    file = known(ISSUE, incision="1.4")
    file.judged = [{"id": ISSUE.id, "name": "incision", "reason": "Nothing here cuts."}]
    write(file, tmp_path / "known.json")
    assert read(tmp_path / "known.json") == file


def test_a_judgment_without_a_reason_is_refused(tmp_path: Path) -> None:
    file = known(ISSUE)
    file.judged = [{"id": ISSUE.id, "name": "incision", "reason": " "}]
    write(file, tmp_path / "known.json")
    with pytest.raises(ValueError, match="without id, name or reason"):
        read(tmp_path / "known.json")


# --- asking --------------------------------------------------------------------------------------------------------


@pytest.fixture
def registry() -> Iterator[tuple[str, dict[str, Any]]]:
    """A server on this computer and its pages, which may be changed: JSON by path, or a number for an HTTP error."""
    served: dict[str, Any] = {}

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            page = served.get(self.path, 404)
            self.send_response(page if isinstance(page, int) else 200)
            self.end_headers()
            self.wfile.write(json.dumps(page).encode())

        def log_message(self, *_: object) -> None:
            pass

    server = HTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}", served
    server.shutdown()
    thread.join()
    server.server_close()


def page(version: str, *issues: dict[str, Any]) -> dict[str, Any]:
    return {"info": {"version": version}, "vulnerabilities": list(issues)}


PAGE_OF_ISSUE = {
    "id": "PYSEC-2026-1",
    "aliases": ["CVE-2026-1"],
    "summary": None,
    "details": "It cuts too deep.\nAnd so on.",
    "fixed_in": ["1.5"],
    "withdrawn": None,
}
DEBIAN = Pin("debian", "zeromq3", "4.3.4-6")


def tracker(**issues: dict[str, Any]) -> dict[str, Any]:
    """The tracker's data about one source package, by CVE with `_` for `-`."""
    return {
        "zeromq3": {
            name.replace("_", "-"): {"description": name, "releases": {"bookworm": state} if state else {}}
            for name, state in issues.items()
        }
    }


def test_what_the_registries_say_is_written_down(registry: tuple[str, dict[str, Any]]) -> None:
    address, served = registry
    served["/pypi/incision/1.4/json"] = page("1.4", PAGE_OF_ISSUE, {**PAGE_OF_ISSUE, "id": "B", "withdrawn": "2026"})
    served["/debian"] = tracker(
        CVE_1={"status": "open", "repositories": {"bookworm": "4.3.4-6"}},
        CVE_2={"status": "resolved", "fixed_version": "4.3.4-6+deb12u1"},
        CVE_3={"status": "resolved", "fixed_version": "4.3.1-1"},
        CVE_4={"status": "resolved", "fixed_version": "0"},  # the release never had it
        CVE_5={},
        CVE_6={"status": "undetermined"},
    )
    file = Known()
    assert update(file, [PIN, DEBIAN], TODAY, pypi=f"{address}/pypi", debian=f"{address}/debian") == []
    assert [one.id for one in file.advisories] == ["PYSEC-2026-1", "CVE-1", "CVE-2"]
    assert file.advisories[0] == ISSUE
    assert file.advisories[2].fixed_in == ("4.3.4-6+deb12u1",)
    assert len(check(file, [PIN, DEBIAN], TODAY)[0]) == 3
    assert file.updated == {"pypi": "2026-11-22", "debian": "2026-11-22"}


def test_the_page_of_a_package_answers_about_its_newest_version_only(registry: tuple[str, dict[str, Any]]) -> None:
    address, served = registry
    served["/pypi/incision/json"] = page("1.4", PAGE_OF_ISSUE)
    served["/pypi/suture/json"] = page("3.0")
    file = Known()
    older = Pin("pypi", "suture", "2.0")
    update(file, [PIN, older], TODAY, pypi=f"{address}/pypi", debian=f"{address}/none")
    assert file.asked["pypi"] == {"incision": "1.4"}
    assert file.advisories == [ISSUE]


def test_a_registry_that_cannot_be_reached_changes_nothing_of_what_is_known(
    registry: tuple[str, dict[str, Any]],
) -> None:
    address, served = registry
    served["/pypi/incision/1.4/json"] = 503
    file = known(ISSUE, day="2026-10-01", incision="1.4")
    unreachable = update(file, [PIN, DEBIAN], TODAY, pypi=f"{address}/pypi", debian="http://127.0.0.1:9/data")
    assert [line.partition(":")[0] for line in unreachable] == ["PyPI", "Debian's security tracker"]
    assert file == known(ISSUE, day="2026-10-01", incision="1.4")

    served["/pypi/incision/1.4/json"] = 404
    (line, _) = update(file, [PIN, DEBIAN], TODAY, pypi=f"{address}/pypi", debian="http://127.0.0.1:9/data")
    assert line == "PyPI: it knows none of the versions"
    assert file.updated["pypi"] == "2026-10-01"


def test_an_advisory_goes_when_the_registry_has_no_more_or_the_package_is_gone(
    registry: tuple[str, dict[str, Any]],
) -> None:
    address, served = registry
    served["/pypi/incision/1.5/json"] = page("1.5")
    gone = Advisory("PYSEC-2026-2", "pypi", "retractor", "1.0")
    silent = Advisory("PYSEC-2026-3", "pypi", "suture", "2.0")
    file = known(ISSUE, gone, silent, incision="1.4", retractor="1.0", suture="2.0")
    pinned = [Pin("pypi", "incision", "1.5"), Pin("pypi", "suture", "2.0")]
    update(file, pinned, TODAY, pypi=f"{address}/pypi", debian=f"{address}/none")
    assert file.advisories == [silent]
    assert file.asked["pypi"] == {"incision": "1.5", "suture": "2.0"}


@pytest.mark.parametrize(("judged", "status"), [(False, 1), (True, 0)])
def test_the_command_fails_where_something_is_affected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], judged: bool, status: int
) -> None:
    click = locked.locked("click")
    file = known(Advisory("PYSEC-2026-9", "pypi", "click", click.version))
    file.judged = [{"id": "PYSEC-2026-9", "name": "click", "reason": "Not so."}] if judged else []
    write(file, tmp_path / "known.json")
    monkeypatch.setattr(vulnerabilities, "read", lambda: read(tmp_path / "known.json"))
    assert vulnerabilities.main([]) == status
    said = capsys.readouterr().err
    assert (f"click {click.version}: PYSEC-2026-9, not repaired yet" in said) is not judged
