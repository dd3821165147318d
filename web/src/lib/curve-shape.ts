// A curve of values: its ends, its path, its value at a place, and as a table.
import { asInFile } from './axes';
import type { Range, Vec3 } from './model';
import type { Axis, ProbedCurve } from './told';
import { add, length, scale, sub } from './vec';

/** Of the finite values; null if there is none. */
export function curveRange(values: readonly number[]): Range | null {
  let lower = Infinity;
  let upper = -Infinity;
  for (const value of values) {
    if (!Number.isFinite(value)) continue;
    lower = Math.min(lower, value);
    upper = Math.max(upper, value);
  }
  return lower <= upper ? { lower, upper } : null;
}

/** An SVG path; a value that is none begins a gap. A value alone between two gaps is a dot. */
export function curvePath(xs: readonly number[], values: readonly number[], x: (at: number) => number, y: (value: number) => number): string {
  const parts: string[] = [];
  let pen = false;
  values.forEach((value, i) => {
    if (!Number.isFinite(value)) return (pen = false);
    parts.push(`${pen ? 'L' : 'M'}${x(xs[i] as number).toFixed(2)} ${y(value).toFixed(2)}`);
    if (!pen && !Number.isFinite(values[i + 1] ?? NaN)) parts.push('h0.01');
    return (pen = true);
  });
  return parts.join('');
}

/** The value at a place along a line: straight between the samples; null in a gap and beyond the ends. */
export function valueAt(curve: Pick<ProbedCurve, 'at' | 'values'>, at: number): number | null {
  const { at: xs, values } = curve;
  let low = 0;
  let high = xs.length - 1;
  if (high < 0 || !(at >= (xs[0] as number) && at <= (xs[high] as number))) return null;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if ((xs[middle] as number) <= at) low = middle;
    else high = middle;
  }
  const [a, b] = [values[low] as number, values[high] as number];
  const [p, q] = [xs[low] as number, xs[high] as number];
  const value = at === q ? b : at === p ? a : a + ((b - a) * (at - p)) / (q - p);
  return Number.isFinite(value) ? value : null;
}

/** The sample that is nearest to a place. */
export function nearestSample(xs: readonly number[], at: number): number {
  let best = 0;
  xs.forEach((x, i) => {
    if (Math.abs(x - at) < Math.abs((xs[best] as number) - at)) best = i;
  });
  return best;
}

export const alongLine = (from: Vec3, to: Vec3, distance: number): Vec3 => {
  const way = sub(to, from);
  return add(from, scale(way, distance / (length(way) || 1)));
};

const cell = (text: string): string => (/[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
/** Of a table with commas. */
export const row = (cells: readonly (string | number)[]): string => cells.map((of) => (typeof of === 'number' ? (Number.isFinite(of) ? String(of) : '') : cell(of))).join(',');

/** Numbers in all their digits; a cell without a value is empty, which along a line is a gap. */
export function lineTable(curve: ProbedCurve, from: Vec3, to: Vec3, axes?: readonly Axis[]): string {
  const rows = curve.at.map((at, i) => row([at, ...alongLine(from, to, at).map((of, axis) => asInFile(axes, axis, of)), curve.values[i] as number]));
  return [row(['distance', 'x', 'y', 'z', curve.array]), ...rows, ''].join('\r\n');
}
/** Steps are counted from 1, as the page counts them. */
export function stepsTable(curve: ProbedCurve, times: readonly number[]): string {
  const rows = curve.at.map((step, i) => row([step + 1, times[step] ?? '', curve.values[i] as number]));
  return [row(['step', 'time', curve.array]), ...rows, ''].join('\r\n');
}
