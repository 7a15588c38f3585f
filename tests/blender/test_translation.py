"""The interface in other languages: nothing that is translated is gone, and nothing that is shown is left out."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import bpy
import pytest

import lappet_blender
from lappet.designs.library import DESIGNS
from lappet.plates.plate_words import LANGUAGES as CATALOGUE
from lappet.procedure.threads import THREADS
from lappet_blender.interface.problem_repairs import REPAIRS
from lappet_blender.interface.sidebar_panel import SidebarPanel
from lappet_blender.translation.dictionary import CONTEXTS, LANGUAGES, blender_dictionary, messages

ADDON = Path(lappet_blender.__file__).parent
# Said alike in every language: names of people, publishers, curves and materials.
_NAMES = {"B-spline", "Bézier", "Corotated", "Elsevier", "Mooney–Rivlin", "Neo-Hookean", "Plos", "Springer"}
_NAMES |= {"Stable neo-Hookean", *THREADS}
# Fields that no panel shows: scripts set them.
_HIDDEN = {"Second Edge From", "First Inside", "Second Inside", "Told", "Last manifest", "Identifier"}


def classes() -> Iterator[Any]:
    """Every class that the add-on registers."""
    for part in lappet_blender._PARTS:
        yield from import_module(f"lappet_blender.{part}.registration").CLASSES


def labels(*kinds: type) -> set[str]:
    """The labels of the classes of some kinds."""
    return {each.bl_label for each in classes() if issubclass(each, kinds)}


def fields() -> set[str]:
    """The names of the fields of property groups, and of what can be chosen in them."""
    found = set()
    for each in classes():
        if not issubclass(each, bpy.types.PropertyGroup):
            continue
        for info in each.bl_rna.properties:
            if info.identifier in ("rna_type", "name") or info.is_hidden or info.type == "COLLECTION":
                continue
            found.add(info.name if info.name != info.identifier else "")
            if info.type == "ENUM":
                found |= {item.name for item in info.enum_items}
    return found - {""}


def spoken() -> set[str]:
    """Every text in the add-on's sources, and what Blender makes of them."""
    words: set[str] = set()
    for file in ADDON.rglob("*.py"):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        words |= {
            node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)
        }
    return words | fields() | labels(bpy.types.Operator) | flap_fields()


def flap_fields() -> set[str]:
    """The names of what the operators of the flap library ask for, and of what can be chosen there."""
    found = set()
    for name in DESIGNS:
        for operator in (f"flap_{name}", f"flap_edit_{name}"):
            for info in getattr(bpy.ops.lappet, operator.replace("-", "_")).get_rna_type().properties:
                if info.identifier != "rna_type" and not info.is_hidden:
                    found.add(info.name)
                    found |= {item.name for item in info.enum_items} if info.type == "ENUM" else set()
    return found


def test_every_label_of_a_panel_a_menu_and_an_operator_is_translated(addon: None) -> None:
    shown = labels(bpy.types.Panel, bpy.types.Menu, bpy.types.Operator)
    assert shown - set(messages()) == set()


def test_every_field_and_choice_that_is_shown_is_translated(addon: None) -> None:
    assert fields() - set(messages()) - _NAMES - _HIDDEN == set()


def test_every_flap_and_what_it_asks_for_is_translated(addon: None) -> None:
    """Each design by its title, its measures by their names, in each language of the plates' catalogue."""
    titles = {design.title for design in DESIGNS.values()}
    assert titles | flap_fields() <= set(messages())
    made = blender_dictionary()
    assert made["de_DE"]["Operator", "Limberg flap"] == "Limberg-Lappen"
    assert made["fr_FR"]["Operator", "Edit Limberg flap"] == "Modifier: Lambeau de Limberg"
    for texts in made.values():
        assert {texts["Operator", title] for title in titles if "plasty" not in title}.isdisjoint(titles)


def test_every_text_that_is_given_to_a_button_or_a_field_is_translated() -> None:
    """And what the buttons say that repair a problem."""
    said = {label for _, label, _ in REPAIRS}
    for file in ADDON.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            for word in node.keywords if isinstance(node, ast.Call) else ():
                if word.arg in ("text", "heading", "placeholder") and isinstance(word.value, ast.Constant):
                    said |= {word.value.value} if isinstance(word.value.value, str) else set()
    assert said - set(messages()) - {"", "lappet"} == set()  # the command is called so everywhere


def test_nothing_is_translated_that_the_interface_does_not_say_any_more(addon: None) -> None:
    assert set(messages()) - spoken() == set()


def test_every_message_has_every_language_of_the_catalogue() -> None:
    assert {"en", *(code for code, _ in LANGUAGES)} == set(CATALOGUE)
    for message, texts in messages().items():
        assert len(texts) == len(LANGUAGES), message
        assert all(text.strip() == text and text for text in texts), message
        assert any("\u4e00" <= letter <= "\u9fff" for letter in texts[3]) or message == "Lappet", message


@pytest.mark.parametrize("mark", ["…", "`", ".blend", "3D", "Lappet"])
def test_marks_and_names_of_a_message_stand_in_its_translations(mark: str) -> None:
    for message, texts in messages().items():
        if mark in message:
            assert all(mark in text for text in texts), message


def test_tips_are_those_of_operators_and_do_not_end_with_a_full_stop(addon: None) -> None:
    operators = [each.bl_idname.partition(".")[2] for each in classes() if issubclass(each, bpy.types.Operator)]
    tips = {getattr(bpy.ops.lappet, name).get_rna_type().description for name in operators}
    translated = [message for message in messages() if message in tips]
    assert len(translated) >= 25
    for message in translated:
        assert not any(text.endswith((".", "。")) for text in messages()[message]), message


def test_blender_gets_each_message_for_labels_and_for_buttons(addon: None) -> None:
    made = blender_dictionary()
    assert set(made) >= {"de_DE", "fr_FR", "es", "zh_HANS"}
    for texts in made.values():
        assert {message for _, message in texts} == set(messages())
        assert {context for context, _ in texts} == set(CONTEXTS)
    panels = {each.bl_translation_context for each in classes() if issubclass(each, SidebarPanel)}
    assert panels == {"Lappet"}
    assert made["de_DE"]["*", "Timeline"] == "Zeitleiste"


def test_values_of_a_sentence_stand_in_all_its_translations() -> None:
    with_values = [message for message in messages() if "{" in message]
    assert len(with_values) >= 15
    for message in with_values:
        names = sorted(re.findall(r"{(\w+)}", message))
        assert all(sorted(re.findall(r"{(\w+)}", text)) == names for text in messages()[message]), message


def composed(node: ast.AST) -> bool:
    """Whether an f-string is in it that has words of its own, which Blender cannot translate."""
    texts = [each for each in ast.walk(node) if isinstance(each, ast.JoinedStr)]
    words = [part.value for each in texts for part in each.values if isinstance(part, ast.Constant)]
    return any(re.search(r"[a-z]{3}", str(word)) for word in words)


def test_headers_the_status_bar_and_buttons_have_no_words_that_are_put_together_in_english() -> None:
    """Sentences with values go through `said`: the header while a tool is used, the status bar, labels and buttons."""
    found = []
    for file in sorted(ADDON.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            shown: list[ast.AST] = []
            if isinstance(node, ast.FunctionDef) and node.name == "text" and file.parent.name == "tools":
                shown = [node]
            elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                shown = [each.value for each in node.keywords if each.arg == "text"]
                shown += node.args if node.func.attr in ("status_text_set", "header_text_set") else []
            found += [f"{file.name}:{each.lineno}" for each in shown if composed(each)]
    assert found == []
