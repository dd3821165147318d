// The rules of editing intervals: pure functions from an interval and a gesture to the interval's new ends.
import type { ColorRange, Interval, Range } from './model';
import { niceStep, roundTo } from './ticks';

export type End = 'lower' | 'upper';

/** What an axis shows of an array's range: a constant array still gets an axis with some width. */
export function axisRange(range: Range): Range {
  if (!Number.isFinite(range.lower) || !Number.isFinite(range.upper)) return { lower: 0, upper: 1 };
  if (range.upper > range.lower) return { lower: range.lower, upper: range.upper };
  const pad = Math.abs(range.lower) * 0.05 || 0.5;
  return { lower: range.lower - pad, upper: range.upper + pad };
}

/** The resolution that dragging rounds to: readable numbers, finer than a pixel. */
export const dragStep = (axis: Range): number => niceStep((axis.upper - axis.lower) / 5000);
/** The steps of the arrow and the page keys. */
export const arrowStep = (axis: Range): number => niceStep((axis.upper - axis.lower) / 300);
export const pageStep = (axis: Range): number => niceStep((axis.upper - axis.lower) / 25);

/** The least width that a gesture can give: an interval must have lower < upper. */
export const leastWidth = (axis: Range): number => dragStep(axis);

/** The candidate within `tolerance` that is nearest, else the value rounded for reading. */
export function snap(value: number, candidates: readonly number[], tolerance: number, step: number): number {
  let best = roundTo(value, step);
  let distance = tolerance;
  for (const candidate of candidates) {
    const d = Math.abs(candidate - value);
    if (d <= distance) {
      best = candidate;
      distance = d;
    }
  }
  return best;
}

/** Where ends like to stop: the ends of the data and of the other intervals, so that layers can touch without a gap. */
export function snapCandidates(axis: Range, intervals: readonly Interval[], except: number): number[] {
  const others = intervals.filter((interval) => interval.id !== except);
  return [axis.lower, axis.upper, ...others.flatMap((interval) => [interval.lower, interval.upper])].filter(Number.isFinite);
}

/** Where an axis shows the ends: one that is open, at the axis' own end. */
export function shownEnds(interval: Range, axis: Range): Range {
  return {
    lower: Number.isFinite(interval.lower) ? interval.lower : Math.min(axis.lower, interval.upper),
    upper: Number.isFinite(interval.upper) ? interval.upper : Math.max(axis.upper, interval.lower),
  };
}

/** The one end that can be moved where the other is open; null if both can, or none. */
function onlyEnd(interval: Range): End | null {
  if (Number.isFinite(interval.lower) === Number.isFinite(interval.upper)) return null;
  return Number.isFinite(interval.lower) ? 'lower' : 'upper';
}
const within = (value: number, axis: Range): number => Math.min(Math.max(value, axis.lower), axis.upper);

/** Moves one end; it stops before the other end and at the ends of the axis. */
export function resize(interval: Range, end: End, value: number, axis: Range): Range {
  const gap = leastWidth(axis);
  if (end === 'lower') {
    const most = interval.upper - gap;
    return { lower: Math.min(Math.max(value, Math.min(axis.lower, interval.lower)), most), upper: interval.upper };
  }
  const least = interval.lower + gap;
  return { lower: interval.lower, upper: Math.max(Math.min(value, Math.max(axis.upper, interval.upper)), least) };
}

/** Moves the whole interval; its width stays, and it stops at the ends of the axis. Of one that is open the other end moves. */
export function move(interval: Range, delta: number, axis: Range): Range {
  const end = onlyEnd(interval);
  if (end) return { lower: interval.lower, upper: interval.upper, [end]: within(interval[end] + delta, axis) };
  if (!Number.isFinite(interval.lower)) return { lower: interval.lower, upper: interval.upper };
  const room = { lower: Math.min(axis.lower - interval.lower, 0), upper: Math.max(axis.upper - interval.upper, 0) };
  const d = Math.min(Math.max(delta, room.lower), room.upper);
  return { lower: interval.lower + d, upper: interval.upper + d };
}

/** As `move`, and the end that lies nearest to a candidate stops there. */
export function moveAndSnap(
  interval: Range,
  delta: number,
  axis: Range,
  candidates: readonly number[],
  tolerance: number,
): Range {
  const free = move(interval, delta, axis);
  const step = dragStep(axis);
  const end = onlyEnd(interval);
  if (end) return { ...free, [end]: snap(free[end], candidates, tolerance, step) };
  if (!Number.isFinite(interval.lower)) return free;
  const lower = snap(free.lower, candidates, tolerance, step);
  const upper = snap(free.upper, candidates, tolerance, step);
  const pullLower = candidates.includes(lower) ? Math.abs(lower - free.lower) : Infinity;
  const pullUpper = candidates.includes(upper) ? Math.abs(upper - free.upper) : Infinity;
  const width = interval.upper - interval.lower;
  if (pullUpper < pullLower) return { lower: upper - width, upper };
  return { lower, upper: lower + width };
}

/** What two points dragged on the empty axis mean: an interval, or null if it is too thin to have been meant. */
export function drawn(from: number, to: number, axis: Range): Range | null {
  const lower = Math.max(Math.min(from, to), axis.lower);
  const upper = Math.min(Math.max(from, to), axis.upper);
  return upper - lower >= (axis.upper - axis.lower) / 400 ? { lower, upper } : null;
}

/** Where the one range's interval lies in the other, rounded for reading. Intervals that touch go on touching. */
export function fitted(interval: Range, from: Range, to: Range): Range {
  const [old, axis] = [axisRange(from), axisRange(to)];
  const place = (value: number) => axis.lower + ((value - old.lower) / (old.upper - old.lower)) * (axis.upper - axis.lower);
  const step = dragStep(axis);
  const end = (value: number) => (value === old.lower ? axis.lower : value === old.upper ? axis.upper : Number.isFinite(value) ? roundTo(place(value), step) : value);
  const { lower, upper } = { lower: end(interval.lower), upper: end(interval.upper) };
  return lower < upper ? { lower, upper } : { lower: place(interval.lower), upper: place(interval.upper) };
}

/** The least range that has all of them; ends that are open say nothing. */
export function hull(ranges: readonly Range[]): Range {
  const ends = ranges.flatMap(({ lower, upper }) => [lower, upper]).filter(Number.isFinite);
  return { lower: Math.min(...ends), upper: Math.max(...ends) };
}

function widestBetween(values: number[]): Range {
  const sorted = values.sort((a, b) => a - b);
  let widest: Range = { lower: sorted[0]!, upper: sorted[0]! };
  sorted.forEach((upper, i) => {
    const lower = sorted[Math.max(i - 1, 0)]!;
    if (upper - lower > widest.upper - widest.lower) widest = { lower, upper };
  });
  return widest;
}

/** Where the Add button puts an interval: in the middle of the widest stretch of the axis that no interval covers, else that has no end in it. */
export function proposeInterval(axis: Range, intervals: readonly Range[]): Range {
  const sorted = [...intervals].sort((a, b) => a.lower - b.lower);
  let gap: Range = { lower: axis.lower, upper: axis.lower };
  let covered = axis.lower;
  for (const next of [...sorted, { lower: axis.upper, upper: axis.upper }]) {
    const lower = Math.min(next.lower, axis.upper);
    if (lower - covered > gap.upper - gap.lower) gap = { lower: covered, upper: lower };
    covered = Math.max(covered, next.upper);
  }
  const whole = axis.upper - axis.lower;
  if (gap.upper - gap.lower < whole / 100) gap = widestBetween([axis, ...intervals].flatMap(({ lower, upper }) => [within(lower, axis), within(upper, axis)]));
  const width = Math.min((gap.upper - gap.lower) / 2, whole / 6);
  const middle = (gap.lower + gap.upper) / 2;
  const step = dragStep(axis);
  const lower = roundTo(middle - width / 2, step);
  return { lower, upper: Math.max(roundTo(middle + width / 2, step), lower + step) };
}

/** A typed number, with a point or a comma before its decimals, or what is wrong with it in words. */
export function typeNumber(text: string): number | string {
  const typed = text.trim().replace('−', '-');
  if (/^[+-]?[1-9]\d{0,2},\d{3}$/.test(typed)) return `Is “${text}” ${typed.replace(',', '')} or ${typed.replace(',', '.')}? Type it without a comma.`;
  const value = typed === '' ? Number.NaN : Number(typed.replace(',', '.'));
  return Number.isFinite(value) ? value : `“${text}” is not a number.`;
}

/** A typed number as an end: the new ends, or what is wrong with it in words. “inf” leaves it open. */
export function typeEnd(interval: Range, end: End, text: string): Range | string {
  const open = /^([+−-]?)(∞|inf|infinity)$/i.exec(text.trim());
  const value = open ? (/[−-]/.test(open[1]!) ? -Infinity : Infinity) : typeNumber(text);
  if (typeof value === 'string') return value;
  if (value === (end === 'lower' ? Infinity : -Infinity)) return `The ${end} end can be open to the other side only.`;
  if (end === 'lower' && value >= interval.upper) return `The lower end must be less than ${interval.upper}.`;
  if (end === 'upper' && value <= interval.lower) return `The upper end must be greater than ${interval.lower}.`;
  return { ...interval, [end]: value };
}

/** As `typeEnd` for the values that colours run over, which are not open, and above 0 if they run by the logarithm. */
export function typeColorEnd(range: ColorRange, end: End, text: string): Range | string {
  const ends = typeEnd(range, end, text);
  if (typeof ends === 'string') return ends;
  if (!Number.isFinite(ends[end])) return 'Colours need two finite numbers.';
  if (range.log && !(ends.lower > 0)) return 'A number above 0 has a logarithm.';
  return ends;
}

/** What a key does to a thumb; null for a key that means nothing here. */
export function keyToValue(key: string, fine: boolean, interval: Range, end: End, axis: Range): number | null {
  const value = shownEnds(interval, axis)[end];
  const small = arrowStep(axis) * (fine ? 0.1 : 1);
  switch (key) {
    case 'ArrowRight':
    case 'ArrowUp':
      return roundTo(value + small, small);
    case 'ArrowLeft':
    case 'ArrowDown':
      return roundTo(value - small, small);
    case 'PageUp':
      return roundTo(value + pageStep(axis), small);
    case 'PageDown':
      return roundTo(value - pageStep(axis), small);
    case 'Home':
      return end === 'lower' ? axis.lower : interval.lower + leastWidth(axis);
    case 'End':
      return end === 'upper' ? axis.upper : interval.upper - leastWidth(axis);
    default:
      return null;
  }
}

/** The ids with the highest priority first; of equal ones the later added first, as it is painted later. */
export function priorityOrder(intervals: readonly Interval[]): number[] {
  return intervals
    .map((interval, added) => ({ interval, added }))
    .sort((a, b) => b.interval.priority - a.interval.priority || b.added - a.added)
    .map(({ interval }) => interval.id);
}

/** The order with the id at another place; places beyond the ends mean the ends. */
export function placed(order: readonly number[], id: number, place: number): number[] {
  const rest = order.filter((other) => other !== id);
  const at = Math.min(Math.max(place, 0), rest.length);
  return [...rest.slice(0, at), id, ...rest.slice(at)];
}

/** What a layer is called by if it has no name. Its number stays when another one is deleted. */
export function layerNumber(intervals: readonly Interval[], id: number): string {
  const at = intervals.findIndex((interval) => interval.id === id);
  return `Layer ${intervals[at]?.number || at + 1}`;
}
