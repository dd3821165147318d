import struct
import unittest
import zlib

import numpy as np

import isostrata
from isostrata import IsostrataError, decode_png, encode_png


def chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(body, zlib.crc32(kind)))


def filtered(picture: np.ndarray, kinds) -> bytes:
    """A PNG whose rows are filtered by `kinds` in turn: the specification's section 9.2, pixel by pixel."""
    height, width, channels = picture.shape
    lines = bytearray()
    for y in range(height):
        kind = kinds[y % len(kinds)]
        lines.append(kind)
        for x in range(width):
            for c in range(channels):
                a = int(picture[y, x - 1, c]) if x else 0
                b = int(picture[y - 1, x, c]) if y else 0
                d = int(picture[y - 1, x - 1, c]) if x and y else 0
                p = a + b - d
                nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - d), 2, d))[2]
                lines.append((int(picture[y, x, c]) - [0, a, b, (a + b) // 2, nearest][kind]) & 255)
    header = struct.pack(">IIBBBBB", width, height, 8, {1: 0, 2: 4, 3: 2, 4: 6}[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(lines))) + chunk(b"IEND", b"")


class Png(unittest.TestCase):
    def test_every_filter_is_undone(self):
        for seed in range(3):
            random = np.random.default_rng(seed)
            for channels in (1, 2, 3, 4):
                picture = random.integers(0, 256, (7, 11, channels), np.uint8)
                for kinds in ([0], [1], [2], [3], [4], [4, 2, 3, 1, 0]):
                    with self.subTest(seed=seed, channels=channels, kinds=kinds):
                        np.testing.assert_array_equal(decode_png(filtered(picture, kinds)), picture)

    def test_what_is_encoded_is_decoded(self):
        random = np.random.default_rng(5)
        for shape in ((1, 1, 3), (40, 30, 4), (9, 13)):
            picture = random.integers(0, 256, shape, np.uint8)
            np.testing.assert_array_equal(decode_png(encode_png(picture)).reshape(shape), picture)

    def test_agrees_with_pillow(self):
        try:
            from PIL import Image
        except ImportError:
            self.skipTest("python3-pil is not installed")
        import io

        ramp = np.arange(60 * 50 * 3, dtype=np.uint32).reshape(60, 50, 3).astype(np.uint8)
        for picture in (ramp, np.random.default_rng(9).integers(0, 256, (60, 50, 3), np.uint8)):
            file = io.BytesIO()
            Image.fromarray(picture).save(file, "png")
            np.testing.assert_array_equal(decode_png(file.getvalue()), picture)
            np.testing.assert_array_equal(np.asarray(Image.open(io.BytesIO(encode_png(picture)))), picture)

    def test_damage_is_an_error_of_its_own_kind(self):
        whole = filtered(np.random.default_rng(1).integers(0, 256, (6, 5, 3), np.uint8), [4, 1, 3])
        for size in range(len(whole)):
            with self.assertRaises(IsostrataError) as caught:
                decode_png(whole[:size])
            self.assertEqual(caught.exception.code, "bad_image")
        random = np.random.default_rng(2)
        for round_ in range(500):
            damaged = bytearray(whole)
            damaged[random.integers(len(whole))] ^= 1 << random.integers(8)
            try:
                self.assertEqual(decode_png(bytes(damaged)).shape, (6, 5, 3), f"seed 2, round {round_}")
            except IsostrataError as refused:
                self.assertEqual(refused.code, "bad_image", f"seed 2, round {round_}")

    def test_a_picture_that_unpacks_to_more_than_it_says_is_refused(self):
        header = struct.pack(">IIBBBBB", 2, 2, 8, 2, 0, 0, 0)
        bomb = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(1 << 24))) + chunk(b"IEND", b"")
        with self.assertRaises(IsostrataError):
            decode_png(bomb)

    def test_what_is_no_picture_is_not_encoded(self):
        for wrong in (np.zeros((2, 2, 3)), np.zeros((2, 2, 5), np.uint8), np.zeros((0, 2, 3), np.uint8)):
            with self.assertRaises(isostrata.IsostrataError):
                encode_png(wrong)


if __name__ == "__main__":
    unittest.main()
