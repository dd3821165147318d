"""Pictures to numpy: every pixel, and damage as errors."""

import io
import unittest

import numpy as np
from PIL import Image

from isostrata import IsostrataError, decode_image


def file_of(picture: np.ndarray, kind: str, **options) -> bytes:
    file = io.BytesIO()
    Image.fromarray(picture).save(file, kind, **options)
    return file.getvalue()


class Pictures(unittest.TestCase):
    def test_every_pixel_of_a_png_comes_back(self):
        random = np.random.default_rng(5)
        for shape in ((1, 1, 3), (40, 30, 4), (9, 13, 3)):
            picture = random.integers(0, 256, shape, np.uint8)
            np.testing.assert_array_equal(decode_image(file_of(picture, "png")), picture)

    def test_a_jpeg_is_a_picture_of_three_channels(self):
        ramp = np.linspace(0, 255, 60 * 50).astype(np.uint8).reshape(60, 50)
        picture = np.stack([ramp, ramp, 255 - ramp], axis=2)
        near = decode_image(file_of(picture, "jpeg", quality=95, subsampling=0))
        self.assertEqual(near.shape, picture.shape)
        self.assertLess(np.abs(near.astype(int) - picture).max(), 12)

    def test_damage_is_an_error_of_its_own_kind(self):
        picture = np.random.default_rng(1).integers(0, 256, (6, 5, 3), np.uint8)
        whole = file_of(picture, "png")
        random = np.random.default_rng(2)
        damaged = [whole[:size] for size in range(len(whole))]
        for _ in range(500):
            damaged.append(bytearray(whole))
            damaged[-1][random.integers(len(whole))] ^= 1 << random.integers(8)
        refused = 0
        for i, data in enumerate(damaged):
            try:
                self.assertEqual(decode_image(bytes(data)).shape[2] in (3, 4), True, f"seed 2, round {i}")
            except IsostrataError as error:
                refused += 1
                self.assertEqual(error.code, "bad_image", f"seed 2, round {i}")
        self.assertGreater(refused, len(damaged) // 2)
        for data in (b"", b"no picture", b"<svg/>", file_of(picture, "bmp")):
            with self.assertRaises(IsostrataError):
                decode_image(data)


if __name__ == "__main__":
    unittest.main()
