"""A plan of two chapters over a cache that is made without the solver, and the lesson of it."""

from __future__ import annotations

from pathlib import Path

import pytest

import synthetic_skin_cache as synthetic
from lappet.lessons.write_lesson_plan import write_lesson_plan
from lappet.usd.stage import pxr

PLAN = """
title = "Slits <b> & sutures"
pass = 60

[[chapter]]
title = "The slit"
cache = "cache.usdc"
text = '''
A slit is pulled open
by hooks.

It is sutured.
'''

  [[chapter.hotspot]]
  place = "landmark left apex"
  title = "The end"
  text = "Here the slit ends."

  [[chapter.question]]
  ask = "What closes it?"
  choices = ["hooks", "sutures", "glue"]
  answer = 2
  right = "They hold."
  wrong = "Look again."
  step = 4

[[chapter]]
title = "Once more"
cache = "cache.usdc"
look = "tension"
view = "top"
step = 2

  [[chapter.question]]
  ask = "Where is its right end?"
  place = "landmark right apex"
  within = 5
  right = "There it is."
  wrong = "It is on the right."
"""


@pytest.fixture(scope="session")
def plan_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the cache and the plan `lesson.toml`."""
    folder = tmp_path_factory.mktemp("plan")
    synthetic.write_cache(folder, step=4.0)
    _hold_by_anchors(folder / "procedure.usda")
    (folder / "lesson.toml").write_text(PLAN, encoding="utf-8")
    return folder


@pytest.fixture(scope="session")
def course_file(plan_folder: Path) -> Path:
    """The lesson of that plan."""
    return write_lesson_plan(plan_folder / "lesson.toml", plan_folder / "lesson.html")


def _hold_by_anchors(procedure: Path) -> None:
    """Say where sutures hold the tissue, as the add-on writes it."""
    usd = pxr()
    stage = usd.Usd.Stage.Open(str(procedure))
    for k, x in enumerate(synthetic.SUTURES):
        prim = stage.GetPrimAtPath(f"/Procedure/Timeline/suture_{k + 1}")
        anchors = prim.CreateAttribute("lappet:anchors", usd.Sdf.ValueTypeNames.Point3dArray)
        anchors.Set([usd.Gf.Vec3d(x, -0.5, 0.0), usd.Gf.Vec3d(x, 0.5, 0.0)])
    stage.GetRootLayer().Save()
