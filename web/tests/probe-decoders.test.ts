import { expect, test } from 'vitest';
import { probeDecoders, rightPixels, tolerance } from '../src/lib/probe-decoders';
import { insideBlock, probeColor, probeSide, probeStream } from '../src/lib/probe-stream';

/** The known picture, each value changed by `change`. */
function picture(change = (value: number, _x: number) => value): Uint8ClampedArray {
  const pixels = new Uint8ClampedArray(probeSide * probeSide * 4);
  for (let y = 0; y < probeSide; y++)
    for (let x = 0; x < probeSide; x++)
      for (let c = 0; c < 3; c++) {
        pixels[4 * (y * probeSide + x) + c] = change(probeColor(x, y)[c] as number, x);
      }
  return pixels;
}
const never = () => 0;

test('the known picture is right, and a little off is, too', () => {
  expect(rightPixels(picture())).toBe(true);
  expect(rightPixels(picture((v) => v + tolerance))).toBe(true);
});

test('limited range taken for full, and the other way, are wrong', () => {
  expect(rightPixels(picture((v) => 16 + (v * 219) / 255))).toBe(false);
  expect(rightPixels(picture((v) => ((v - 16) * 255) / 219))).toBe(false);
});

test('halved chroma is wrong', () => {
  const smeared = picture((v, x) => (x === 16 ? 128 : v));
  expect(insideBlock(16, 8)).toBe(false);
  expect(rightPixels(smeared)).toBe(false);
});

test('what decodes rightly is offered, the best first and JPEG last', async () => {
  const doors = { decode: () => Promise.resolve(picture()), setTimeout: never };
  expect(await probeDecoders(doors)).toEqual([probeStream.format, 'jpeg']);
});

test('what fails, is wrong, throws or never answers is not offered', async () => {
  for (const decode of [
    () => Promise.reject(new Error('no')),
    () => Promise.resolve(new Uint8ClampedArray(probeSide * probeSide * 4)),
    () => {
      throw new Error('no');
    },
  ])
    expect(await probeDecoders({ decode, setTimeout: never })).toEqual(['jpeg']);
  const silent = { decode: () => new Promise<never>(() => {}), setTimeout: (callback: () => void) => callback() };
  expect(await probeDecoders(silent)).toEqual(['jpeg']);
  expect(await probeDecoders(null)).toEqual(['jpeg']);
});
