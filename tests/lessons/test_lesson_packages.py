"""Packages for learning platforms hold what their standards ask for, and report in run-times that others wrote."""

from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

import viewer
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lappet.lessons.write_lesson_plan import write_lesson_plan
from lesson_browser import opened

PACKAGING = "{http://www.imsproject.org/xsd/imscp_rootv1p1p2}"
SCORM = "{http://www.adlnet.org/xsd/adlcp_rootv1p2}"
IN_FRAME = "document.querySelector('iframe').contentWindow"


@pytest.fixture(scope="module")
def scorm_file(plan_folder: Path) -> Path:
    return write_lesson_plan(plan_folder / "lesson.toml", plan_folder / "lesson.zip")


@pytest.fixture(scope="module")
def h5p_file(plan_folder: Path) -> Path:
    return write_lesson_plan(plan_folder / "lesson.toml", plan_folder / "lesson.h5p")


def test_the_manifest_has_the_structure_of_scorm_1_2(scorm_file: Path) -> None:
    package = zipfile.ZipFile(scorm_file)
    assert package.namelist() == ["imsmanifest.xml", "lesson.html"]
    root = ElementTree.fromstring(package.read("imsmanifest.xml"))
    assert [each.tag for each in root] == [PACKAGING + name for name in ("metadata", "organizations", "resources")]
    assert [each.text for each in root[0]] == ["ADL SCORM", "1.2"]
    organizations, resource = root[1], root[2][0]
    assert organizations.get("default") == organizations[0].get("identifier")
    title, item = organizations[0]
    assert title.text == "Slits <b> & sutures"
    assert item.get("identifierref") == resource.get("identifier")
    assert item.find(f"{SCORM}masteryscore").text == "60"
    assert (resource.get("type"), resource.get(f"{SCORM}scormtype")) == ("webcontent", "sco")
    files = [each.get("href") for each in resource]
    assert resource.get("href") in files
    assert set(files) <= set(package.namelist())


def test_the_same_plan_gives_the_same_package(scorm_file: Path, plan_folder: Path, tmp_path: Path) -> None:
    again = write_lesson_plan(plan_folder / "lesson.toml", tmp_path / "again.zip")
    assert again.read_bytes() == scorm_file.read_bytes()


@pytest.mark.parametrize("suffix", [".zip", ".h5p"])
def test_one_operation_becomes_a_package_without_questions(plan_folder: Path, tmp_path: Path, suffix: str) -> None:
    target = tmp_path / f"one{suffix}"
    assert export(ExportRequest((plan_folder / "cache.usdc",), target, {"title": "One"})) == [target]
    package = zipfile.ZipFile(target)
    pages = [name for name in package.namelist() if name.endswith(("lesson.html", "lesson.txt"))]
    page = package.read(pages[0]).decode("utf-8")
    content = json.loads(page.split('id="lesson">')[1].split("</script>")[0])
    assert (content["reports"], content["mastery"]) == ("scorm" if suffix == ".zip" else "h5p", None)
    assert [each["questions"] for each in content["chapters"]] == [[]]


def test_a_package_of_h5p_holds_its_library(h5p_file: Path) -> None:
    package = zipfile.ZipFile(h5p_file)
    about = json.loads(package.read("h5p.json"))
    (depends,) = about["preloadedDependencies"]
    folder = f"{depends['machineName']}-{depends['majorVersion']}.{depends['minorVersion']}"
    library = json.loads(package.read(f"{folder}/library.json"))
    assert library["machineName"] == about["mainLibrary"] == depends["machineName"]
    for each in (*library["preloadedJs"], *library["preloadedCss"], {"path": "semantics.json"}):
        assert f"{folder}/{each['path']}" in package.namelist()
    content = json.loads(package.read("content/content.json"))
    assert f"content/{content['page']['path']}" in package.namelist()
    allowed = {".json", ".txt"}  # what platforms let into the content of a package
    assert {Path(name).suffix for name in package.namelist() if name.startswith("content/")} <= allowed


def module(name: str) -> Path:
    return viewer.MODULES / name


HOST = """<!doctype html><meta charset="utf-8"><title>Platform</title><script src="scorm12.min.js"></script>
<script>
const kept = localStorage.getItem("cmi");
window.API = new Scorm12API({ autocommit: false, logLevel: 5 });
if (kept) API.loadFromJSON(JSON.parse(kept), "");
window.calls = [];
for (const name of ["LMSInitialize", "LMSFinish", "LMSCommit"]) API.on(name, () => calls.push(name));
window.said = {}; // what is only written, and every value that the run-time refused
window.refused = [];
const set = API.LMSSetValue.bind(API);
API.LMSSetValue = (name, value) => {
  const taken = set(name, value);
  said[name] = value;
  if (String(taken) !== "true") refused.push([name, value, API.LMSGetLastError()]);
  return taken;
};
window.value = (name) => name.split(".").reduce((at, key) => at[key], API.cmi);
window.leave = () => {
  document.querySelector("iframe").remove();
  localStorage.setItem("cmi", JSON.stringify({ core: { lesson_status: API.cmi.core.lesson_status,
    lesson_location: API.cmi.core.lesson_location, entry: "resume" }, suspend_data: API.cmi.suspend_data }));
};
</script>
<iframe src="lesson.html" title="Lesson" width="1000" height="560" allow="fullscreen"></iframe>
"""
VALUES = (
    "({...Object.fromEntries(['lesson_status', 'score.raw', 'lesson_location']"
    ".map((key) => [key, value('core.' + key)])),"
    " suspend_data: value('suspend_data'), exit: said['cmi.core.exit'], time: said['cmi.core.session_time']})"
)
INTERACTION = "['id', 'type', 'result'].map((each) => said[`cmi.interactions.${k}.${each}`])"
FRAME_READY = ("until", f"{IN_FRAME}.lappetLesson?.resting()")


def in_frame(script: str) -> tuple[str, str]:
    return "evaluate", f"{{ const page = {IN_FRAME}.document; {script} }}"


def seen(*steps: int) -> list[tuple[str, Any]]:
    """Goes to steps and waits until each is seen."""
    done: list[tuple[str, Any]] = []
    for step in steps:
        done.append(in_frame(f"page.querySelectorAll('#steps button')[{step}].click()"))
        standing = f"{IN_FRAME}.lappetLesson.standing()"
        done.append(("until", f"{standing}.seen[{standing}.c][{step}] === '1'"))
    return done


def chosen(choice: int) -> list[tuple[str, Any]]:
    return [
        in_frame(f"page.querySelectorAll('.option input')[{choice}].click()"),
        in_frame("page.querySelector('.question .primary').click()"),
    ]


def site(scorm_file: Path, folder: Path) -> Path:
    zipfile.ZipFile(scorm_file).extractall(folder)
    shutil.copyfile(module("scorm-again") / "dist" / "scorm12.min.js", folder / "scorm12.min.js")
    (folder / "index.html").write_text(HOST, encoding="utf-8")
    return folder


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_run_time_of_scorm_hears_status_score_time_and_place(scorm_file: Path, tmp_path: Path) -> None:
    second = [("evaluate", f"{IN_FRAME}.lappetLesson.open(1).then(() => 1)"), FRAME_READY]
    listed = [in_frame("page.querySelector('.question details').open = true")]
    answer = [*listed, in_frame("page.querySelectorAll('.candidates button')[1].click()")]
    done = opened(
        site(scorm_file, tmp_path),
        *(FRAME_READY, ("evaluate", VALUES), *seen(1, 2, 3), *chosen(0), ("wait", 1000), ("evaluate", VALUES)),
        *(*second, *seen(0, 2, 3), *answer, ("wait", 1000), ("evaluate", VALUES)),
        *(
            (
                "evaluate",
                "[0, 1].map((k) => ['id', 'type', 'result'].map((each) => said[`cmi.interactions.${k}.${each}`]))",
            ),
        ),
        *(("evaluate", "leave()"), ("evaluate", VALUES), ("evaluate", "calls"), ("evaluate", "refused")),
    )
    begun, halfway, complete, left = (each for each in done.results if isinstance(each, dict))
    assert begun["lesson_status"] == "incomplete"
    assert (halfway["lesson_status"], halfway["score.raw"]) == ("incomplete", "0")
    assert halfway["lesson_location"] == "1.4"
    assert (complete["lesson_status"], complete["score.raw"]) == ("failed", "50")
    assert complete["lesson_location"].startswith("2.")
    assert json.loads(complete["suspend_data"])["seen"] == ["1111", "1111"]
    assert done.results[-5] == [
        ["chapter_1_question_1", "choice", "wrong"],
        ["chapter_2_question_1", "performance", "correct"],
    ]
    assert left["time"].startswith("0000:0")
    assert (done.results[-2][0], done.results[-2][-1]) == ("LMSInitialize", "LMSFinish")
    assert done.results[-1] == []
    assert done.console == []


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_second_visit_goes_on_where_the_first_ended(scorm_file: Path, tmp_path: Path) -> None:
    standing = ("evaluate", f"{IN_FRAME}.lappetLesson.standing()")
    done = opened(
        site(scorm_file, tmp_path),
        *(FRAME_READY, *chosen(1), *seen(2), ("evaluate", "leave()"), ("evaluate", VALUES)),
        *(("evaluate", "location.reload()"), ("wait", 500), FRAME_READY, standing),
        ("evaluate", f"{IN_FRAME}.document.querySelector('.feedback').innerText"),
    )
    left, again = (each for each in done.results if isinstance(each, dict))
    assert left["exit"] == "suspend"
    assert (again["c"], again["s"], again["a"]) == (0, 2, ["1", "-"])
    assert again["seen"][0] == "1010"
    assert "Right." in done.results[-1]


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_student_who_answers_well_has_passed_and_stays_so(scorm_file: Path, tmp_path: Path) -> None:
    second = [("evaluate", f"{IN_FRAME}.lappetLesson.open(1).then(() => 1)"), FRAME_READY]
    listed = [in_frame("page.querySelector('.question details').open = true")]
    answer = [*listed, in_frame("page.querySelectorAll('.candidates button')[1].click()")]
    done = opened(
        site(scorm_file, tmp_path),
        *(FRAME_READY, *seen(1, 2, 3), *chosen(1), *second, *seen(0, 2, 3), *answer, ("wait", 1000)),
        *(("evaluate", VALUES), ("evaluate", "leave()"), ("evaluate", VALUES), ("evaluate", "calls.at(-1)")),
        *(("evaluate", "location.reload()"), ("wait", 500), FRAME_READY, ("wait", 1000), ("evaluate", VALUES)),
        ("evaluate", "refused"),
    )
    complete, left, again = (each for each in done.results if isinstance(each, dict))
    assert (complete["lesson_status"], complete["score.raw"]) == ("passed", "100")
    assert left["exit"] == ""  # over, and not put aside
    assert "LMSFinish" in done.results
    assert again["lesson_status"] == "passed"
    assert done.results[-1] == []
    assert done.console == []


PLAYER = """<!doctype html><meta charset="utf-8"><title>Platform</title><script src="player/main.bundle.js"></script>
<div id="place"></div>
<script>
window.heard = [];
new H5PStandalone.H5P(document.getElementById("place"), {
  h5pJsonPath: "/package", frameJs: "/player/frame.bundle.js", frameCss: "/player/styles/h5p.css", id: "lesson",
  saveFreq: 100, contentUserData: [{ state: localStorage.getItem("state") ?? undefined }],
}).then(() => H5P.externalDispatcher.on("xAPI", (event) => heard.push(event.data.statement)));
// What a platform does now and then, and when the student leaves.
window.keep = () => localStorage.setItem("state", JSON.stringify(
  document.querySelector("iframe.h5p-iframe").contentWindow.H5P.instances[0].getCurrentState()));
</script>
"""


OUTER = "document.querySelector('iframe.h5p-iframe')?.contentDocument"
INNER = f"{OUTER}?.querySelector('.h5p-lappet iframe')?.contentWindow"


def platform(h5p_file: Path, folder: Path) -> None:
    zipfile.ZipFile(h5p_file).extractall(folder / "package")
    shutil.copytree(module("h5p-standalone") / "dist", folder / "player")
    (folder / "index.html").write_text(PLAYER, encoding="utf-8")


def inside(actions: list[tuple[str, Any]]) -> list[tuple[str, Any]]:
    """Actions in the page that H5P shows."""
    return [(name, script.replace(IN_FRAME, INNER) if isinstance(script, str) else script) for name, script in actions]


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_second_visit_in_h5p_goes_on_where_the_first_ended(h5p_file: Path, tmp_path: Path) -> None:
    platform(h5p_file, tmp_path)
    standing = ("evaluate", f"{IN_FRAME}.lappetLesson.standing()")
    done = opened(
        tmp_path,
        *inside([FRAME_READY, standing, *chosen(1), *seen(2), ("wait", 500), standing]),
        *(("evaluate", "keep()"), ("evaluate", "location.reload()"), ("wait", 500)),
        *inside([FRAME_READY, standing, ("evaluate", f"{IN_FRAME}.document.querySelector('.feedback').innerText")]),
    )
    begun, left, again = (each for each in done.results if isinstance(each, dict))
    assert begun["a"] == ["-", "-"]
    assert (left["c"], left["s"], left["a"]) == (0, 2, ["1", "-"])
    assert again == left
    assert "Right." in done.results[-1]


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_run_time_of_h5p_shows_the_lesson_and_hears_statements(h5p_file: Path, tmp_path: Path) -> None:
    platform(h5p_file, tmp_path)
    second = [("evaluate", f"{IN_FRAME}.lappetLesson.open(1).then(() => 1)"), FRAME_READY]
    listed = in_frame("page.querySelector('.question details').open = true")
    answer = in_frame("page.querySelectorAll('.candidates button')[1].click()")
    verbs = "heard.map((each) => [each.verb.id.split('/').pop(), each.result?.score?.raw, each.result?.success])"
    done = opened(
        tmp_path,
        *inside([FRAME_READY, *seen(1, 2, 3), *chosen(1), *second, *seen(0, 2, 3), listed, answer]),
        *(("until", "heard.some((each) => each.verb.id.endsWith('completed'))"), ("evaluate", verbs)),
    )
    statements = done.results[-1]
    assert [each for each in statements if each[0] == "answered"] == [["answered", 1, True]] * 2
    assert [each for each in statements if each[0] == "completed"] == [["completed", 2, True]]
