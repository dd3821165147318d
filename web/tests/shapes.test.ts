import { expect, test } from 'vitest';
import { hexOf, luminance, newIntervalColor, rgbOfHex } from '../src/lib/colors';
import { barHeights, barPath } from '../src/lib/histogram-shape';
import { RateMeter, Smoothed } from '../src/lib/meter';
import type { Rgb } from '../src/lib/model';
import { formatBytes, formatCount, formatNumber, formatRange, niceStep, roundTo, ticks, tickText, timeText, wholeText } from '../src/lib/ticks';
import { viewportPixels } from '../src/lib/viewport-size';
import { seeded } from './random';

test('ticks are multiples of a round step and lie within the axis', () => {
  for (let seed = 1; seed <= 200; seed++) {
    const r = seeded(seed);
    const lower = (r() - 0.5) * 10 ** Math.floor(r() * 20 - 10);
    const upper = lower + r() * 10 ** Math.floor(r() * 20 - 10) + Math.abs(lower) * 1e-6;
    const values = ticks(lower, upper, 6);
    expect(values.length, `seed ${seed}`).toBeLessThanOrEqual(13);
    for (const value of values) {
      expect(value, `seed ${seed}`).toBeGreaterThanOrEqual(lower - (upper - lower) * 1e-6);
      expect(value, `seed ${seed}`).toBeLessThanOrEqual(upper + (upper - lower) * 1e-6);
    }
  }
  expect(ticks(0, 1, 5)).toEqual([0, 0.2, 0.4, 0.6, 0.8, 1]);
  expect(ticks(3, 3, 5)).toEqual([]);
  expect(niceStep(0.3)).toBe(0.5);
  expect(roundTo(0.30000000004, 0.1)).toBe(0.3);
});

test('ticks are told apart, and a short range has the digits that tell its ends apart', () => {
  for (let seed = 1; seed <= 200; seed++) {
    const r = seeded(seed);
    const lower = (r() - 0.5) * 10 ** Math.floor(r() * 12 - 6);
    const upper = lower + Math.abs(lower) * 10 ** Math.floor(-r() * 8);
    const texts = ticks(lower, upper, 4).map(tickText);
    expect(new Set(texts).size, `seed ${seed}`).toBe(texts.length);
    expect(texts.map(Number), `seed ${seed}`).toEqual(ticks(lower, upper, 4));
    const [a, b] = formatRange(lower, upper);
    expect(Number(a), `seed ${seed}`).toBeLessThan(Number(b));
  }
  expect(formatRange(101325.02, 101325.07)).toEqual(['101325.02', '101325.07']);
  expect(formatRange(0.1 + 0.2, 4.97749)).toEqual(['0.3', '4.9775']);
  expect(formatRange(7, 7)).toEqual(['7', '7']);
  expect(formatRange(-Infinity, Infinity)).toEqual(['−∞', '∞']);
});

test('a number that is typed has all its digits, and those of small ones are not all zeros', () => {
  for (let power = -300; power < 300; power++) {
    const value = (power % 2 ? -1.2345678901234567 : 1 / 3) * 10 ** power;
    expect(Number(wholeText(value))).toBe(value);
  }
  expect([0, 0.25, 1e-4, 0.000001408, -7.34e-7, 1000000, Infinity, -Infinity].map(wholeText)).toEqual(['0', '0.25', '0.0001', '1.408e-6', '-7.34e-7', '1000000', 'inf', '-inf']);
});

test('numbers are short and right to the digits shown', () => {
  expect(formatNumber(0)).toBe('0');
  expect(formatNumber(4.97749)).toBe('4.9775');
  expect(formatNumber(-2.4e10)).toBe('-2.4e10');
  expect(formatNumber(0.00001234)).toBe('1.234e-5');
  expect(formatNumber(123456)).toBe('123460');
  expect([1e6, 1234567, 2451545.25, 1e21].map((value) => formatNumber(value, 9))).toEqual(['1e6', '1234567', '2451545.25', '1e21']);
  expect(formatRange(1000000.0001, 1000000.0017)).toEqual(['1000000.0001', '1000000.0017']);
  expect(formatNumber(Number.NaN)).toBe('NaN');
  expect(formatNumber(Infinity)).toBe('∞');
  expect(formatNumber(-Infinity)).toBe('−∞');
  expect(formatCount(9479)).toBe('9,479');
  expect(formatCount(60432)).toBe('60.4 k');
  expect(formatCount(5_100_000)).toBe('5.10 M');
  expect(formatBytes(900)).toBe('900 B');
  expect(formatBytes(48 * 1024)).toBe('48 KiB');
});

test('a time has the digits that tell it apart from the others', () => {
  expect(timeText(20010101.5, [20010101, 20010101.5, 20010102])).toBe('20010101.5');
  expect(timeText(2451545.25, [2451545, 2451545.25])).toBe('2451545.25');
  expect(timeText(2451545.25, [2451545.25])).toBe('2451545.25');
  expect(timeText(0.1 + 0.2, [0, 0.1, 0.2, 0.1 + 0.2])).toBe('0.3');
  expect(timeText(1 / 3, [0, 1 / 3, 2 / 3])).toBe('0.333333');
  expect(timeText(0, [0, 1])).toBe('0');
  for (let i = 0; i < 1000; i++) {
    const [t, gap] = [2e9 * Math.random(), 10 ** (-3 + 6 * Math.random())];
    expect(Number(timeText(t, [t - gap, t, t + gap]))).not.toBe(Number(timeText(t + gap, [t - gap, t, t + gap])));
  }
});

test('the fullest bar is full, empty bars are empty, and the logarithm keeps the order', () => {
  const counts = [0, 1, 10, 100000];
  for (const log of [false, true]) {
    const heights = barHeights(counts, log);
    expect(heights[0]).toBe(0);
    expect(heights[3]).toBe(1);
    expect([...heights].sort((a, b) => a - b)).toEqual(heights);
  }
  expect(barHeights([0, 0], true)).toEqual([0, 0]);
  expect(barPath([], 100, 50)).toBe('');
  // A value that is there at all can be seen.
  expect(barPath([1, 1e-9], 100, 50)).toBe('M0 50V0H50V49.5H100V50Z');
});

test('colours survive the way to the picker and back', () => {
  for (const hex of ['#000000', '#ffffff', '#e6392f', '#0a0b0c']) expect(hexOf(rgbOfHex(hex) as Rgb)).toBe(hex);
  expect(rgbOfHex('red')).toBeNull();
  expect(luminance([1, 1, 1])).toBeCloseTo(1, 6);
  expect(luminance([0, 0, 0])).toBe(0);
});

test('the first eight new intervals have eight colours', () => {
  const used: Rgb[] = [];
  for (let i = 0; i < 8; i++) used.push(newIntervalColor(used));
  expect(new Set(used.map(hexOf)).size).toBe(8);
  expect(newIntervalColor(used)).toHaveLength(3);
});

test('the picture is asked for in device pixels, within the limits, in the shape of the box', () => {
  const most = { width: 4096, height: 4096 };
  expect(viewportPixels(800, 600, 1, most)).toEqual({ width: 800, height: 600 });
  expect(viewportPixels(800, 600, 1.5, most)).toEqual({ width: 1200, height: 900 });
  for (const [w, h, ratio] of [[3840, 2160, 2], [9000, 100, 1], [100, 9000, 3], [0, 0, 1]] as const) {
    const size = viewportPixels(w, h, ratio, most);
    expect(size.width).toBeLessThanOrEqual(4096);
    expect(size.height).toBeLessThanOrEqual(4096);
    expect(size.width * size.height).toBeLessThanOrEqual(4_200_000);
    expect(Math.min(size.width, size.height)).toBeGreaterThanOrEqual(16);
  }
  const wide = viewportPixels(3840, 2160, 2, most);
  expect(wide.width / wide.height).toBeCloseTo(3840 / 2160, 2);
});

test('the rate is that of the last two seconds, and a still picture has none', () => {
  const meter = new RateMeter();
  for (let t = 0; t <= 1000; t += 50) meter.tick(t);
  expect(meter.rate(1000)).toBeCloseTo(20, 6);
  expect(meter.rate(9000)).toBe(0);
  const smoothed = new Smoothed();
  expect(smoothed.add(10)).toBe(10);
  expect(smoothed.add(20)).toBe(12);
});
