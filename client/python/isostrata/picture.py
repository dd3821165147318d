"""The bytes of pictures to numpy, by Pillow."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image

from .errors import IsostrataError


def decode_image(data: bytes) -> np.ndarray:
    """A PNG or a JPEG as uint8 [height, width, channels], 3 channels or, with alpha, 4. Raises IsostrataError "bad_image"."""
    try:
        with Image.open(io.BytesIO(data), formats=("PNG", "JPEG")) as picture:
            return np.asarray(picture.convert("RGBA" if "A" in picture.getbands() else "RGB"))
    except Exception as wrong:  # Pillow's readers raise many kinds, OSError to SyntaxError
        raise IsostrataError("bad_image", f"this is not a whole PNG or JPEG: {wrong}") from wrong
