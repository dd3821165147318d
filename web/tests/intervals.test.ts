import { describe, expect, test } from 'vitest';
import {
  axisRange,
  drawn,
  fitted,
  hull,
  keyToValue,
  leastWidth,
  move,
  moveAndSnap,
  placed,
  priorityOrder,
  proposeInterval,
  resize,
  shownEnds,
  snap,
  snapCandidates,
  typeColorEnd,
  typeEnd,
  typeNumber,
  type End,
} from '../src/lib/intervals';
import type { Interval, Range } from '../src/lib/model';
import { seeded } from './random';

const axis: Range = { lower: 0, upper: 10 };
const make = (id: number, lower: number, upper: number, priority = id): Interval => ({
  id,
  lower,
  upper,
  priority,
  color: [1, 0, 0],
  colorMap: '',
  opacity: 0.5,
  visible: true,
});

describe('whatever is done to an interval', () => {
  const random = (seed: number) => {
    const r = seeded(seed);
    const lower = r() * 9;
    return { r, interval: { lower, upper: lower + 0.1 + r() * (10 - lower - 0.1) } };
  };

  test('lower stays less than upper, and both stay on the axis', () => {
    for (let seed = 1; seed <= 300; seed++) {
      const { r, interval } = random(seed);
      const end: End = r() < 0.5 ? 'lower' : 'upper';
      const stops = [0, 10, r() * 10];
      for (const next of [
        resize(interval, end, r() * 30 - 10, axis),
        move(interval, r() * 40 - 20, axis),
        moveAndSnap(interval, r() * 40 - 20, axis, stops, 0.3),
      ]) {
        expect(next.upper - next.lower, `seed ${seed}`).toBeGreaterThan(0);
        expect(next.lower, `seed ${seed}`).toBeGreaterThanOrEqual(-0.31);
        expect(next.upper, `seed ${seed}`).toBeLessThanOrEqual(10.31);
      }
    }
  });

  test('moving keeps the width, resizing keeps the other end', () => {
    for (let seed = 1; seed <= 100; seed++) {
      const { r, interval } = random(seed);
      const moved = move(interval, r() * 40 - 20, axis);
      expect(moved.upper - moved.lower, `seed ${seed}`).toBeCloseTo(interval.upper - interval.lower, 12);
      const value = r() * 30 - 10;
      expect(resize(interval, 'lower', value, axis).upper, `seed ${seed}`).toBe(interval.upper);
      expect(resize(interval, 'upper', value, axis).lower, `seed ${seed}`).toBe(interval.lower);
    }
  });
});

test('an end stops before the other end', () => {
  expect(resize({ lower: 2, upper: 4 }, 'lower', 9, axis)).toEqual({ lower: 4 - leastWidth(axis), upper: 4 });
  expect(resize({ lower: 2, upper: 4 }, 'upper', -9, axis)).toEqual({ lower: 2, upper: 2 + leastWidth(axis) });
});

test('an interval that was typed beyond the axis is not pulled in by dragging its other end', () => {
  expect(resize({ lower: -5, upper: 4 }, 'upper', 6, axis)).toEqual({ lower: -5, upper: 6 });
  expect(move({ lower: -5, upper: 4 }, -1, axis)).toEqual({ lower: -5, upper: 4 });
  expect(move({ lower: -5, upper: 4 }, 1, axis)).toEqual({ lower: -4, upper: 5 });
});

test('an end near the end of another interval takes exactly its value, so that layers touch', () => {
  const stops = snapCandidates(axis, [make(1, 1, 3.14159265), make(2, 5, 6)], 2);
  expect(stops).not.toContain(5);
  expect(snap(3.17, stops, 0.05, 0.002)).toBe(3.14159265);
  expect(snap(3.3, stops, 0.05, 0.002)).toBe(3.3);
  expect(snap(9.98, stops, 0.05, 0.002)).toBe(10);
  expect(moveAndSnap(make(2, 5, 6), -1.84, axis, stops, 0.05)).toEqual({ lower: 3.14159265, upper: 4.14159265 });
  // Alt: no reach, no pull
  expect(snap(3.1416, stops, 0, 0.002)).toBe(3.142);
});

test('a stroke that is too thin was a click', () => {
  expect(drawn(4, 4.001, axis)).toBeNull();
  expect(drawn(6, 4, axis)).toEqual({ lower: 4, upper: 6 });
  expect(drawn(8, 40, axis)).toEqual({ lower: 8, upper: 10 });
});

test('a new interval is put where no other is', () => {
  for (let seed = 1; seed <= 100; seed++) {
    const r = seeded(seed);
    const others = Array.from({ length: Math.floor(r() * 4) }, () => {
      const lower = r() * 8;
      return { lower, upper: lower + r() * 1.5 + 0.01 };
    });
    const next = proposeInterval(axis, others);
    expect(next.lower, `seed ${seed}`).toBeLessThan(next.upper);
    for (const other of others) expect(next.lower >= other.upper || next.upper <= other.lower, `seed ${seed}`).toBe(true);
  }
});

test('where the whole axis is covered a new interval is put in the middle', () => {
  const next = proposeInterval(axis, [{ lower: -1, upper: 11 }]);
  expect((next.lower + next.upper) / 2).toBeCloseTo(5, 1);
});

test('where the whole axis is covered every further interval lies elsewhere', () => {
  const all: Range[] = [{ lower: -Infinity, upper: 4 }, { lower: 4, upper: 11 }];
  for (let i = 0; i < 12; i++) {
    const next = proposeInterval(axis, all);
    expect(next.lower < next.upper && next.lower >= axis.lower && next.upper <= axis.upper).toBe(true);
    for (const other of all) expect(Math.abs(next.lower - other.lower) + Math.abs(next.upper - other.upper), `interval ${i}`).toBeGreaterThan(0.02);
    all.push(next);
  }
});

test('a constant array still has an axis with a width', () => {
  for (const value of [0, 3.5, -2e9]) {
    const wide = axisRange({ lower: value, upper: value });
    expect(wide.lower).toBeLessThan(value);
    expect(wide.upper).toBeGreaterThan(value);
    const next = proposeInterval(wide, []);
    expect(next.lower < next.upper).toBe(true);
  }
  expect(axisRange({ lower: Number.NaN, upper: 1 })).toEqual({ lower: 0, upper: 1 });
});

test('typed numbers are taken exactly, and what cannot be taken is said in words', () => {
  expect(typeEnd({ lower: 0, upper: 5 }, 'lower', ' 1.2345678901 ')).toEqual({ lower: 1.2345678901, upper: 5 });
  expect(typeEnd({ lower: 0, upper: 5 }, 'upper', '-3e-2')).toContain('greater than 0');
  expect(typeEnd({ lower: 0, upper: 5 }, 'lower', '5')).toContain('less than 5');
  expect(typeEnd({ lower: 0, upper: 5 }, 'lower', 'abc')).toContain('not a number');
  expect(typeEnd({ lower: 0, upper: 5 }, 'lower', '')).toContain('not a number');
  expect(typeEnd({ lower: 0, upper: 5 }, 'upper', 'infinite')).toContain('not a number');
  expect(typeEnd({ lower: 0, upper: 5 }, 'upper', '1e400')).toContain('not a number');
});

test('a comma is a decimal point where it is none between thousands, which is asked', () => {
  for (const [text, value] of [['200,5', 200.5], ['0,125', 0.125], ['1,2345', 1.2345], ['−1,5', -1.5], ['1234,567', 1234.567]] as const) expect(typeNumber(text)).toBe(value);
  expect(typeNumber('1,234')).toBe('Is “1,234” 1234 or 1.234? Type it without a comma.');
  expect(typeNumber('-12,288')).toContain('-12288 or -12.288');
  expect(typeNumber('1,234,567')).toBe('“1,234,567” is not a number.');
  expect(typeEnd({ lower: 0, upper: 5000 }, 'upper', '1,234')).toContain('1234 or 1.234');
});

test('colours run over two finite numbers, above 0 by the logarithm', () => {
  const range = { span: 'own', lower: 1, upper: 5, log: false } as const;
  expect(typeColorEnd(range, 'upper', '7,5')).toMatchObject({ lower: 1, upper: 7.5 });
  for (const [end, text] of [['upper', 'inf'], ['lower', '-∞']] as const) expect(typeColorEnd(range, end, text)).toBe('Colours need two finite numbers.');
  expect(typeColorEnd(range, 'lower', '-1')).toMatchObject({ lower: -1 });
  expect(typeColorEnd({ ...range, log: true }, 'lower', '-1')).toContain('above 0');
  expect(typeColorEnd(range, 'lower', '6')).toContain('less than 5');
});

test('keys move a thumb: arrows a little, pages more, Home and End as far as it goes', () => {
  const interval = { lower: 4, upper: 6 };
  const right = keyToValue('ArrowRight', false, interval, 'lower', axis) as number;
  expect(right).toBeGreaterThan(4);
  expect(keyToValue('PageUp', false, interval, 'lower', axis)).toBeGreaterThan(right);
  expect(keyToValue('ArrowRight', true, interval, 'lower', axis)).toBeLessThan(right);
  expect(keyToValue('Home', false, interval, 'lower', axis)).toBe(0);
  expect(keyToValue('End', false, interval, 'lower', axis)).toBeCloseTo(6, 2);
  expect(keyToValue('End', false, interval, 'upper', axis)).toBe(10);
  expect(keyToValue('a', false, interval, 'upper', axis)).toBeNull();
});

test('the highest priority comes first, of equal ones the later added', () => {
  expect(priorityOrder([make(1, 0, 1, 0), make(2, 0, 1, 5), make(3, 0, 1, 5), make(4, 0, 1, -1)])).toEqual([3, 2, 1, 4]);
});

test('an id can be put at every place of an order and the others keep theirs', () => {
  expect(placed([1, 2, 3], 3, 0)).toEqual([3, 1, 2]);
  expect(placed([1, 2, 3], 1, 1)).toEqual([2, 1, 3]);
  expect(placed([1, 2, 3], 1, 99)).toEqual([2, 3, 1]);
  expect(placed([1, 2, 3], 2, -1)).toEqual([2, 1, 3]);
});

describe('an interval that is open', () => {
  const axis = { lower: 0, upper: 10 };
  const above = { lower: 4, upper: Infinity };
  const below = { lower: -Infinity, upper: 4 };

  test('is typed, and stays what it is on the other side', () => {
    for (const text of ['inf', '∞', 'Infinity', ' +inf ']) expect(typeEnd({ lower: 4, upper: 6 }, 'upper', text)).toEqual(above);
    for (const text of ['-inf', '−∞', '-Infinity']) expect(typeEnd({ lower: 2, upper: 4 }, 'lower', text)).toEqual(below);
    expect(typeEnd(above, 'lower', '5')).toEqual({ lower: 5, upper: Infinity });
    expect(typeEnd(above, 'upper', '7')).toEqual({ lower: 4, upper: 7 });
    for (const [end, text] of [['lower', 'inf'], ['upper', '-inf'], ['upper', 'infinite']] as [End, string][])
      expect(typeof typeEnd({ lower: 2, upper: 4 }, end, text)).toBe('string');
  });
  test('is shown to the end of the axis', () => {
    expect(shownEnds(above, axis)).toEqual({ lower: 4, upper: 10 });
    expect(shownEnds(below, axis)).toEqual({ lower: 0, upper: 4 });
    expect(shownEnds({ lower: 12, upper: Infinity }, axis)).toEqual({ lower: 12, upper: 12 });
  });
  test('keeps its open end under every gesture but one on that end', () => {
    for (const delta of [-20, -1, 0.25, 3, 20]) {
      for (const moved of [move(above, delta, axis), moveAndSnap(above, delta, axis, [7], 0.1)]) {
        expect(moved.upper).toBe(Infinity);
        expect(moved.lower).toBeGreaterThanOrEqual(0);
        expect(moved.lower).toBeLessThanOrEqual(10);
      }
      expect(move(below, delta, axis).lower).toBe(-Infinity);
      expect(move({ lower: -Infinity, upper: Infinity }, delta, axis)).toEqual({ lower: -Infinity, upper: Infinity });
    }
    expect(moveAndSnap(above, 2.95, axis, [7], 0.1)).toEqual({ lower: 7, upper: Infinity });
    expect(keyToValue('ArrowLeft', false, above, 'upper', axis)).toBeLessThan(10);
    expect(resize(above, 'upper', 9, axis)).toEqual({ lower: 4, upper: 9 });
    expect(snapCandidates(axis, [{ ...above, id: 1 } as Interval], 2).every(Number.isFinite)).toBe(true);
  });
});

describe('fitting to other values', () => {
  test('keeps the places of the ends, what touches, and what is open; there and back is where it was', () => {
    for (let seed = 1; seed <= 200; seed++) {
      const random = seeded(seed);
      const range = (): Range => {
        const lower = (random() - 0.5) * 10 ** Math.floor(random() * 6 - 3);
        return { lower, upper: lower + 10 ** Math.floor(random() * 6 - 3) };
      };
      const [from, to] = [range(), range()];
      const at = [0, random(), 1].sort((a, b) => a - b).map((t) => from.lower + t * (from.upper - from.lower)) as [number, number, number];
      const [low, high] = [fitted({ lower: from.lower, upper: at[1] }, from, to), fitted({ lower: at[1], upper: from.upper }, from, to)];
      expect(low.upper, `seed ${seed}`).toBe(high.lower);
      expect([low.lower, high.upper], `seed ${seed}`).toEqual([to.lower, to.upper]);
      const back = fitted(low, to, from);
      expect(Math.abs(back.upper - at[1]) / (from.upper - from.lower), `seed ${seed}`).toBeLessThan(0.004); // rounded twice
    }
    expect(fitted({ lower: 2, upper: Infinity }, { lower: 0, upper: 4 }, { lower: 100, upper: 200 })).toEqual({ lower: 150, upper: Infinity });
    expect(hull([{ lower: 1, upper: Infinity }, { lower: -2, upper: 3 }])).toEqual({ lower: -2, upper: 3 });
  });
});
