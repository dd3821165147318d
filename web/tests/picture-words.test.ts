import { expect, test } from 'vitest';
import { layerNumber } from '../src/lib/intervals';
import { emptyState, type Interval, type SceneState } from '../src/lib/model';
import type { DatasetInfo } from '../src/lib/told';
import { badgeOf, emptyReason, isBlank, nanWords } from '../src/lib/picture-words';
import { newIntervalColor, hexOf, usualColor } from '../src/lib/colors';
import { stillSize } from '../src/lib/still-size';

const interval = (id: number, more: Partial<Interval> = {}): Interval => ({
  id,
  lower: 0,
  upper: 1,
  color: [1, 0, 0],
  colorMap: '',
  opacity: 0.5,
  priority: 0,
  visible: true,
  ...more,
});
const info: DatasetInfo = {
  id: 'fin',
  name: 'fin.vtu',
  grid: 'unstructured',
  points: 8750,
  cells: 12,
  cellTypes: [],
  bounds: null,
  arrays: [{ name: 'p', association: 'point', type: 'float32', components: 1, unit: '', nanCount: 0, lower: 0, upper: 9, steps: [] }],
  times: [0],
  missingRangeSteps: 0,
  nothingToShow: '',
  notes: [],
};
const view: SceneState = { ...emptyState, dataset: 'fin', array: 'p', revision: 5, intervals: [interval(1)] };
const full = { tetrahedra: 40, intervals: [] };
const none = { tetrahedra: 0, intervals: [] };

test('an empty picture is explained by what is missing, and a full one is not', () => {
  expect(emptyReason(view, info, full, false)).toBeNull();
  expect(emptyReason(view, info, null, false)).toBeNull();
  expect(emptyReason(view, { ...info, cells: 0 }, none, false)).toContain('8,750 points and no cells');
  expect(emptyReason(view, { ...info, arrays: [] }, none, false)).toContain('no array of numbers');
  expect(emptyReason({ ...view, intervals: [] }, info, none, false)).toContain('No layers yet');
  const constant = { ...info, nothingToShow: 'every array has one value everywhere' };
  expect(emptyReason({ ...view, intervals: [] }, constant, none, false)).toBe('Nothing to show: every array has one value everywhere.');
  expect(emptyReason(view, constant, full, false)).toBeNull();
  expect(emptyReason({ ...view, intervals: [interval(1, { visible: false })] }, info, full, false)).toContain('hidden');
  expect(emptyReason(view, info, none, false)).toContain('no cell has values of p in any layer');
  expect(emptyReason(view, { ...info, times: [0, 1] }, none, false)).toContain('at this time');
  expect(emptyReason(view, { ...info, arrays: [{ ...info.arrays[0]!, lower: 1, upper: -1 }] }, none, false)).toContain('no finite value');
  const flat = (area: number) => ({ tetrahedra: 0, intervals: [{ id: 1, activeCells: 3, tetrahedra: 0, volume: 0, area }] });
  expect(emptyReason(view, info, flat(2), false)).toBeNull();
  expect(emptyReason(view, info, flat(0), false)).toContain('in any layer');
  expect(emptyReason(view, info, full, true)).toContain('None of the layers can be seen');
  expect(emptyReason(view, info, none, true)).toContain('in any layer');
  // Of another dataset than the one that is chosen nobody knows yet.
  expect(emptyReason({ ...view, dataset: 'other' }, { ...info, cells: 0 }, none, false)).toBeNull();
});

test('a picture is blank if every pixel has the colour of the background', () => {
  const picture = (count: number, r: number, g: number, b: number) => new Uint8ClampedArray(Array.from({ length: count }, () => [r, g, b, 255]).flat());
  const background = [0.05, 0.06, 0.08] as const;
  const black = picture(100, 13, 15, 20);
  expect(isBlank(black, background)).toBe(true);
  expect(isBlank(picture(100, 200, 100, 0), background)).toBe(false); // within one solid layer
  for (const channel of [0, 1, 2]) {
    const speck = black.slice();
    speck[4 * 57 + channel]! += 3;
    expect(isBlank(speck, background)).toBe(false);
  }
});

test('the badge says exact only of the newest state, losslessly, where there is something', () => {
  const frame = { phase: 'exact' as const, revision: 5, tetrahedra: 40, height: 600 };
  const word = (change: object, revision = 5, empty = false, waits = false) =>
    badgeOf({ ...frame, ...change }, { revision, waits }, empty, 600).word;
  expect(word({})).toBe('exact');
  expect(word({}, 5, false, true)).toBe('older');
  expect(word({}, 6)).toBe('older');
  expect(word({}, 5, true)).toBe('nothing to show');
  expect(word({}, 6, true)).toBe('older');
  expect(word({ phase: 'settled' }, 5)).toBe('settled');
  expect(word({ phase: 'moving', height: 300 }, 6)).toBe('moving at 50 %');
  expect(word({ phase: 'moving' })).toBe('moving');
  expect(word({ phase: 'settled', pointStride: 4 }, 6)).toBe('first look');
  expect(word({ phase: 'moving', pointStride: 2 }, 6)).toBe('moving, coarse');
  const far = { phase: 'moving', pointStride: 2, coarseError: { largest: 0.0213, mean: 0.00049 } } as const;
  expect(word(far, 6)).toBe('moving, coarse ±0.022, mean 0.00049'); // a bound is not rounded down
  const farTitle = badgeOf({ ...frame, ...far }, { revision: 6, waits: false }, false, 600).title;
  expect(farTitle).toContain('within 0.022 of those of all points, 0.00049 in the mean');
  expect(word({ ...far, coarseError: { largest: 0, mean: 0 } }, 6)).toBe('moving, coarse ±0, mean 0');
  expect(word({ pointStride: 1 })).toBe('exact');
  const title = (samples: number) => badgeOf({ ...frame, samples }, { revision: 5, waits: false }, false, 600).title;
  expect(title(1)).not.toContain('mean');
  expect(title(4)).toContain('4 x 4');
});

test('a first look at some of the points says nothing of what is not in it', () => {
  expect(emptyReason(view, info, none, false)).toContain('Nothing to show');
  expect(emptyReason(view, info, { ...none, pointStride: 4 }, false)).toBeNull();
});

test('a layer is called by its own number, whichever others are there', () => {
  const layers = [interval(7, { number: 2 }), interval(9, { number: 5 }), interval(10)];
  expect(layers.map(({ id }) => layerNumber(layers, id))).toEqual(['Layer 2', 'Layer 5', 'Layer 3']);
});

test('a new layer takes the first of the server’s colours that is free', () => {
  const used = [0, 1, 2, 3].map(usualColor);
  expect(hexOf(newIntervalColor(used))).toBe(hexOf(usualColor(4)));
  expect(hexOf(newIntervalColor(used.slice(1)))).toBe(hexOf(usualColor(0)));
  // 32-bit floats on the wire do not hide that a colour is taken.
  expect(hexOf(newIntervalColor([usualColor(0).map(Math.fround) as never]))).toBe(hexOf(usualColor(1)));
});

test('a picture for keeping is as large as shown, twice that or as typed, within the limits', () => {
  const shown = { width: 740, height: 500 };
  const limits = { maxWidth: 16384, maxHeight: 16384 };
  expect(stillSize('shown', '', shown, limits)).toEqual(shown);
  expect(stillSize('double', '', shown, limits)).toEqual({ width: 1480, height: 1000 });
  for (const text of ['1920x1080', ' 1920 × 1080 ', '1920, 1080', '1920 1080'])
    expect(stillSize('typed', text, shown, limits), text).toEqual({ width: 1920, height: 1080 });
  for (const text of ['', 'large', '1920', '0x9', '-4x5', '1e3x5', '20000x10', '16384x16384'])
    expect(stillSize('typed', text, shown, limits), text).toBeTypeOf('string');
});

test('points without a number are counted at the shown step, or said of no step', () => {
  const array = { ...info.arrays[0]!, nanCount: 50, steps: [{ lower: 0, upper: 9 }, { lower: 2, upper: 3 }, { lower: 1, upper: -1 }] };
  const series = { ...info, times: [0, 1, 2] };
  const told = (step: number, ...counts: number[]) => ({ dataset: 'fin', step, array: 'p', lower: 0, upper: 9, counts });
  const some = 'At some steps up to 50 points of p are NaN and lie in no layer.';
  expect(nanWords(view, info, array, null)).toBe('50 points of p are NaN and lie in no layer.');
  expect(nanWords(view, info, info.arrays[0]!, null)).toBe('');
  expect(nanWords(view, series, array, told(0, 8000, 740))).toBe('10 points of p are NaN at this step and lie in no layer.');
  expect(nanWords({ ...view, step: 1 }, series, array, told(1, 8750))).toBe('');
  expect(nanWords({ ...view, step: 2 }, series, array, told(2, 0))).toContain('8,750 points of p are NaN at this step');
  expect(nanWords({ ...view, step: 1 }, series, array, told(0, 8000, 740))).toBe(some);
  expect(nanWords(view, series, array, null)).toBe(some);
  expect(nanWords({ ...view, time: 0.5, timeMode: 'interpolate' }, series, array, told(0, 8000, 740))).toBe(some);
  expect(nanWords({ ...view, values: 'whole' }, series, array, told(0, 8000, 740))).toBe(some);
  expect(nanWords({ ...view, step: 1 }, series, { ...array, steps: [{ lower: 0, upper: 9 }] }, told(1, 8000))).toBe(some); // not read by itself
  expect(nanWords({ ...view, step: 1 }, series, { ...array, steps: [{ lower: 0, upper: 9 }, { lower: 0, upper: 12 }] }, told(1, 8000))).toBe(some);
});
