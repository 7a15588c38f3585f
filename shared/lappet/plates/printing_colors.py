"""Colors of a printing process: sRGB as CMYK by the process's ICC profile, neutral greys as black ink alone.

Black lines and text that are made of four inks show colored seams where the plates of a press do not meet exactly, so
what has no color gets none: the tint of black is the one whose lightness is that of the grey, between the lightness of
full black ink and that of the paper.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageCms

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

_LEVELS = 256
_NEUTRAL = 4  # levels by which red, green and blue of what has no color may differ
_PRINTER = "prtr"
_INTENT = ImageCms.Intent.RELATIVE_COLORIMETRIC


class PrintingColors:
    """The profile of a printing process.

    Parameters
    ----------
    path
        An ICC profile of the class of output devices, with four inks.

    Raises
    ------
    RefusedError
        If the file is no such profile.
    """

    def __init__(self, path: Path) -> None:
        try:
            self.data = path.read_bytes()
            profile = ImageCms.ImageCmsProfile(io.BytesIO(self.data))
            inks, kind = profile.profile.xcolor_space.strip(), profile.profile.device_class.strip()
            if inks != "CMYK" or kind != _PRINTER:
                raise refused(ProblemCode.PLATE_PROFILE, path)
            self.name = (ImageCms.getProfileDescription(profile) or path.stem).strip()
            display, lab = ImageCms.createProfile("sRGB"), ImageCms.createProfile("LAB")
            flags = ImageCms.Flags.BLACKPOINTCOMPENSATION
            self._to_inks = ImageCms.buildTransform(display, profile, "RGB", "CMYK", _INTENT, flags)
            black = np.zeros((1, _LEVELS, 4), np.uint8)
            black[0, :, 3] = np.arange(_LEVELS)
            grey = np.repeat(np.arange(_LEVELS, dtype=np.uint8)[None, :, None], 3, axis=2)
            tints = _lightness(Image.fromarray(black, "CMYK"), ImageCms.buildTransform(profile, lab, "CMYK", "LAB"))
            wanted = _lightness(Image.fromarray(grey, "RGB"), ImageCms.buildTransform(display, lab, "RGB", "LAB"))
        except (OSError, ImageCms.PyCMSError) as error:
            raise refused(ProblemCode.PLATE_PROFILE, path) from error
        tints = np.minimum.accumulate(tints)
        share = (wanted - wanted.min()) / np.ptp(wanted)
        heights = tints[-1] + share * (tints[0] - tints[-1])
        self._black = np.rint(np.interp(-heights, -tints, np.arange(_LEVELS))).astype(np.uint8)

    def of_picture(self, picture: Image.Image) -> Image.Image:
        """Convert a picture.

        Parameters
        ----------
        picture
            A picture in sRGB, or in grey.

        Returns
        -------
        Image.Image
            The same in the inks of the process, of mode "CMYK"; grey pixels have black ink alone.
        """
        display = np.asarray(picture.convert("RGB"))
        made = ImageCms.applyTransform(Image.fromarray(display, "RGB"), self._to_inks)
        assert made is not None
        inks = np.array(made)
        # Where lines are smoothed against the paper, grey comes out a level or two off.
        neutral = np.ptp(display, axis=-1) <= _NEUTRAL
        inks[neutral] = 0
        inks[..., 3][neutral] = self._black[display[..., 1][neutral]]
        return Image.fromarray(inks, "CMYK")

    def of_color(self, color: tuple[float, ...]) -> tuple[float, ...]:
        """Convert a color.

        Parameters
        ----------
        color
            One value of grey, or three of sRGB, from 0 to 1.

        Returns
        -------
        tuple[float, ...]
            The tints of cyan, magenta, yellow and black, from 0 to 1.
        """
        wide = color * 3 if len(color) == 1 else color
        pixel: NDArray[np.uint8] = np.rint(255.0 * np.clip(np.array(wide), 0.0, 1.0)).astype(np.uint8)
        inks = np.asarray(self.of_picture(Image.fromarray(pixel.reshape(1, 1, 3), "RGB")))[0, 0]
        return tuple(round(float(ink) / 255.0, 4) for ink in inks)


def _lightness(picture: Image.Image, transform: ImageCms.ImageCmsTransform) -> NDArray[np.float64]:
    """CIE L* of the pixels of one row, from 0 to 100."""
    lab = ImageCms.applyTransform(picture, transform)
    assert lab is not None
    values: NDArray[np.float64] = np.asarray(lab)[0, :, 0].astype(np.float64) / 2.55
    return values
