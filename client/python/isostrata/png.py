"""PNG to numpy and back, without a library for pictures: W3C, "Portable Network Graphics (PNG) Specification", second edition, 2003."""

from __future__ import annotations

import struct
import zlib
from typing import NoReturn

import numpy as np

from .errors import IsostrataError

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_CHANNELS = {0: 1, 2: 3, 4: 2, 6: 4}  # by colour type: grey, RGB, grey and alpha, RGBA
_MAX_PIXELS = 1 << 28


def decode_png(data: bytes) -> np.ndarray:
    """A PNG of 8 bits a channel, not interlaced and without a palette, as uint8 [height, width, channels]. Raises IsostrataError
    "bad_image"."""
    if data[:8] != _SIGNATURE:
        _refuse("not a PNG")
    width = height = channels = 0
    packed = []
    at = 8
    while True:
        if len(data) - at < 12:
            _refuse("truncated")
        (size,) = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + size]
        if len(data) - at - 12 < size:
            _refuse("truncated")
        if zlib.crc32(body, zlib.crc32(kind)) != struct.unpack_from(">I", data, at + 8 + size)[0]:
            _refuse("a chunk's checksum is wrong")
        at += size + 12
        if kind == b"IHDR":
            if size != 13:
                _refuse("its header is not 13 bytes")
            width, height, depth, color, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            if depth != 8 or color not in _CHANNELS or interlaced:
                _refuse("not 8 bits a channel, or a palette, or interlaced")
            if not 0 < width * height <= _MAX_PIXELS:
                _refuse(f"a picture of {width}x{height} pixels")
            channels = _CHANNELS[color]
        elif kind == b"IDAT":
            packed.append(body)
        elif kind == b"IEND":
            break
    if not channels:
        _refuse("no header")
    stride = width * channels
    try:
        engine = zlib.decompressobj()
        lines = engine.decompress(b"".join(packed), (stride + 1) * height + 1)
    except zlib.error as wrong:
        _refuse(str(wrong))
    if len(lines) != (stride + 1) * height:
        _refuse(f"{len(lines)} bytes of rows; expected {(stride + 1) * height}")
    rows = np.frombuffer(lines, np.uint8).reshape(height, stride + 1)
    filters = rows[:, 0]
    if filters.max() > 4:
        _refuse(f"unknown filter {filters.max()}")
    return _unfilter(filters, rows[:, 1:].reshape(height, width, channels))


def _unfilter(filters: np.ndarray, raw: np.ndarray) -> np.ndarray:
    """Section 9. None, Sub and Up are sums over whole rows; Average and Paeth need the pixel before, one after the other."""
    out = np.empty_like(raw)
    above = np.zeros(raw.shape[1:], np.uint8)
    for y, kind in enumerate(filters):
        row = raw[y]
        if kind == 0:
            out[y] = row
        elif kind == 1:
            np.cumsum(row, axis=0, dtype=np.uint8, out=out[y])
        elif kind == 2:
            np.add(row, above, out=out[y])
        else:
            out[y] = _average(row, above) if kind == 3 else _paeth(row, above)
        above = out[y]
    return out


def _average(row: np.ndarray, above: np.ndarray) -> np.ndarray:
    lines = []
    for values, ups in zip(row.T.tolist(), above.T.tolist()):
        left, line = 0, []
        for value, up in zip(values, ups):
            left = (value + (left + up) // 2) & 255
            line.append(left)
        lines.append(line)
    return np.array(lines, np.uint8).T


def _paeth(row: np.ndarray, above: np.ndarray) -> np.ndarray:
    lines = []
    for values, ups in zip(row.T.tolist(), above.T.tolist()):
        left = corner = 0
        line = []
        for value, up in zip(values, ups):
            pa, pb, pc = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
            nearest = left if pa <= pb and pa <= pc else up if pb <= pc else corner
            left, corner = (value + nearest) & 255, up
            line.append(left)
        lines.append(line)
    return np.array(lines, np.uint8).T


def encode_png(picture: np.ndarray) -> bytes:
    """uint8 [height, width], or with 1 to 4 channels, as a PNG file's bytes."""
    picture = np.ascontiguousarray(picture)
    if picture.ndim == 2:
        picture = picture[:, :, None]
    if picture.dtype != np.uint8 or picture.ndim != 3 or not 1 <= picture.shape[2] <= 4 or 0 in picture.shape:
        raise IsostrataError("bad_image", f"{picture.dtype} {picture.shape}; expected uint8 [height, width, 1 to 4]")
    height, width, channels = picture.shape
    rows = np.zeros((height, width * channels + 1), np.uint8)
    rows[:, 0] = 2  # Up
    rows[:, 1:] = picture.reshape(height, -1)
    rows[1:, 1:] -= picture.reshape(height, -1)[:-1]
    color = {1: 0, 2: 4, 3: 2, 4: 6}[channels]

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(body, zlib.crc32(kind)))

    header = struct.pack(">IIBBBBB", width, height, 8, color, 0, 0, 0)
    return _SIGNATURE + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + chunk(b"IEND", b"")


def _refuse(why: str) -> NoReturn:
    raise IsostrataError("bad_image", f"PNG: {why}")
