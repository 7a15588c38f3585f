"""A PDF with a printing process's profile is PDF/X-4 in its inks; other readers see the inks and the tags."""

from __future__ import annotations

import io
import subprocess
from pathlib import Path

import numpy as np
import pikepdf
import pytest
from PIL import Image, ImageCms

from lappet.core.problem_code import ProblemCode
from lappet.plates.plate_files import check_format, write_plate
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import PlatePage
from lappet.plates.plate_style import plate_style
from lappet.plates.plate_svg import plate_svg
from lappet.plates.print_checks import CHECKS, print_faults
from lappet.plates.printing_colors import PrintingColors
from refusals import refuses

# Of Debian's ghostscript: a profile of web offset printing.
PROFILE = Path("/usr/share/color/icc/ghostscript/default_cmyk.icc")
DISPLAY = PROFILE.with_name("srgb.icc")


@pytest.fixture(scope="module")
def colors() -> PrintingColors:
    return PrintingColors(PROFILE)


@pytest.fixture(scope="module")
def plain(page: PlatePage, font: PlateFont, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(page, font, tmp_path_factory.mktemp("plain") / "plate.pdf", None)


@pytest.fixture(scope="module")
def printed(page: PlatePage, font: PlateFont, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(page, font, tmp_path_factory.mktemp("printed") / "plate.pdf", PROFILE)


def written(page: PlatePage, font: PlateFont, path: Path, profile: Path | None) -> Path:
    svg = plate_svg(page, plate_style("wash"), font, 72)  # lines, text and images
    write_plate(svg, page.size, page.alt, font, path, 72, profile)
    return path


def test_a_plate_with_a_profile_is_pdf_x_4_and_one_without_is_not(plain: Path, printed: Path) -> None:
    assert print_faults(printed.read_bytes()) == []
    assert set(print_faults(plain.read_bytes())) == {
        *("is PDF 1.6, not encrypted, with an identifier", "has boxes", "has an output intent", "has metadata"),
        "has colors of the process only",
    }


def _drop_trim(pdf: pikepdf.Pdf) -> None:
    del pdf.pages[0].obj["/TrimBox"]


def _drop_profile(pdf: pikepdf.Pdf) -> None:
    pdf.Root.OutputIntents[0].DestOutputProfile.write(DISPLAY.read_bytes())


def _drop_version(pdf: pikepdf.Pdf) -> None:
    with pdf.open_metadata(update_docinfo=False) as told:
        del told["pdfxid:GTS_PDFXVersion"]


def _drop_font(pdf: pikepdf.Pdf) -> None:
    for each in pdf.objects:
        if isinstance(each, pikepdf.Dictionary):
            for key in ("/FontFile2", "/FontFile3"):
                if key in each:
                    del each[key]


def _color(pdf: pikepdf.Pdf) -> None:
    page = pdf.pages[0]
    page.obj.Contents = pdf.make_stream(b"1 0 0 rg\n" + page.Contents.read_bytes())


def _act(pdf: pikepdf.Pdf) -> None:
    pdf.Root.OpenAction = pikepdf.Dictionary(S=pikepdf.Name.JavaScript, JS="app.beep()")


def _halftone(pdf: pikepdf.Pdf) -> None:
    state = pdf.make_indirect(pikepdf.Dictionary(Type=pikepdf.Name.ExtGState, TR=pikepdf.Name.Identity))
    pdf.pages[0].Resources.ExtGState = pikepdf.Dictionary(G=state)


@pytest.mark.parametrize(
    ("harm", "fault"),
    [
        (_drop_trim, "has boxes"),
        (_drop_profile, "has an output intent"),
        (_drop_version, "has metadata"),
        (_drop_font, "has its fonts embedded"),
        (_color, "has colors of the process only"),
        (_act, "does nothing by itself"),
        (_halftone, "has plain graphics states"),
    ],
)
def test_each_check_finds_what_it_is_for(printed: Path, harm: object, fault: str) -> None:
    assert fault in CHECKS
    buffer = io.BytesIO()
    with pikepdf.open(printed) as pdf:
        harm(pdf)  # type: ignore[operator]
        pdf.save(buffer, force_version="1.6")
    assert fault in print_faults(buffer.getvalue())


def test_a_pdf_x_4_keeps_its_tags_and_its_descriptions(plain: Path, printed: Path) -> None:
    with pikepdf.open(plain) as before, pikepdf.open(printed) as after:
        assert after.Root.MarkInfo.Marked
        assert described(after) == described(before)
        assert any("step by step" in each for each in described(after))
        with after.open_metadata(update_docinfo=False) as told:
            assert told["pdfuaid:part"] == "1"


def described(pdf: pikepdf.Pdf) -> list[str]:
    """The descriptions of what its tags mark."""
    return [str(each.Alt) for each in pdf.objects if isinstance(each, pikepdf.Dictionary) and "/Alt" in each]


def test_what_has_no_color_is_black_ink_alone_and_white_is_paper(colors: PrintingColors) -> None:
    tints = [colors.of_color((grey,)) for grey in np.linspace(0.0, 1.0, 21)]
    assert all(tint[:3] == (0.0, 0.0, 0.0) for tint in tints)
    black = [tint[3] for tint in tints]
    assert (black[0], black[-1]) == (1.0, 0.0)
    assert black == sorted(black, reverse=True)
    assert colors.of_color((0.4, 0.4, 0.4)) == colors.of_color((0.4,))


def test_colors_come_back_from_the_inks_as_the_profile_sees_them(colors: PrintingColors) -> None:
    """littleCMS, asked the other way round, finds the colors of skin, wound and plan again."""
    wanted = np.array([[246, 237, 228], [215, 189, 150], [130, 92, 67], [194, 80, 74], [31, 78, 156]], np.uint8)
    inks = colors.of_picture(Image.fromarray(wanted[None], "RGB"))
    back = ImageCms.buildTransform(
        *(ImageCms.getOpenProfile(str(PROFILE)), ImageCms.createProfile("sRGB"), "CMYK", "RGB"),
        ImageCms.Intent.RELATIVE_COLORIMETRIC,
        ImageCms.Flags.BLACKPOINTCOMPENSATION,
    )
    found = np.asarray(ImageCms.applyTransform(inks, back))[0].astype(int)
    assert np.abs(found - wanted).max() <= 12


def test_ghostscript_separates_a_plate_of_ink_into_black_alone(
    page: PlatePage, font: PlateFont, tmp_path: Path
) -> None:
    svg = plate_svg(page, plate_style("ink"), font, 72)
    write_plate(svg, page.size, page.alt, font, tmp_path / "plate.pdf", 72, PROFILE)
    call = ("gs", "-q", "-dNOPAUSE", "-dBATCH", "-dSAFER", "-sDEVICE=tiffsep", "-r50", "-o", "page.tif", "plate.pdf")
    subprocess.run(call, cwd=tmp_path, check=True)
    plates = {}
    for name in ("Cyan", "Magenta", "Yellow", "Black"):
        with Image.open(tmp_path / f"page({name}).tif") as picture:
            plates[name] = 255 - np.asarray(picture).astype(int)
    assert plates["Black"].max() > 150
    assert max(plates[name].max() for name in ("Cyan", "Magenta", "Yellow")) == 0


def test_a_tiff_in_inks_has_the_profile_and_black_text(page: PlatePage, font: PlateFont, tmp_path: Path) -> None:
    svg = plate_svg(page, plate_style("ink"), font, 72)
    write_plate(svg, page.size, page.alt, font, tmp_path / "plate.tiff", 150, PROFILE)
    with Image.open(tmp_path / "plate.tiff") as picture:
        assert picture.mode == "CMYK"
        assert picture.info["icc_profile"] == PROFILE.read_bytes()
        inks = np.asarray(picture)
    assert inks[..., :3].max() == 0
    assert inks[..., 3].max() > 200


def test_a_profile_of_a_screen_is_refused_before_anything_is_drawn(tmp_path: Path) -> None:
    (tmp_path / "no.icc").write_text("no profile")
    for profile in (DISPLAY, tmp_path / "no.icc", tmp_path / "missing.icc"):
        with refuses(ProblemCode.PLATE_PROFILE) as problems:
            check_format(tmp_path / "plate.pdf", profile)
        assert str(profile) in problems[0].prim
