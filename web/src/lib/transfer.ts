// The rules of editing a transfer function: pure functions from its points and a gesture to the new points. Values never fall from one point
// to the next; a step is two points of one value.
import { colorMapColors } from './color-maps';
import { arrowStep, leastWidth, pageStep, shownEnds } from './intervals';
import { placeIn, type MapRange } from './map-range';
import type { Interval, IntervalPatch, Range, Rgb, TransferPoint } from './model';
import { roundTo } from './ticks';

const mix = (a: number, b: number, t: number) => a + (b - a) * t;
const mixColor = (a: Rgb, b: Rgb, t: number): Rgb => [mix(a[0], b[0], t), mix(a[1], b[1], t), mix(a[2], b[2], t)];
const clamp = (x: number, lower: number, upper: number) => Math.min(Math.max(x, lower), upper);

/** What is straight between two points is extinction; opaque would be without end. */
const extinction = (opacity: number) => -Math.log(1 - Math.min(opacity, 0.9999));

/** The look at a value between the first point's and the last one's. */
export function lookAt(points: readonly TransferPoint[], value: number): TransferPoint {
  const above = points.findIndex((p) => p.value > value);
  if (above <= 0) return { ...(points[above === 0 ? 0 : points.length - 1] as TransferPoint), value };
  const a = points[above - 1] as TransferPoint;
  const b = points[above] as TransferPoint;
  const t = (value - a.value) / (b.value - a.value);
  const opacity = 1 - Math.exp(-mix(extinction(a.opacity), extinction(b.opacity), t));
  return { value, color: mixColor(a.color, b.color, t), opacity: t === 0 ? a.opacity : opacity };
}

/** A function that looks as the layer does: nothing jumps when it begins. over: what its colour map runs over. */
export function startPoints(interval: Interval, whole: Range, over: MapRange = { ...(interval.ownRange ? shownEnds(interval, whole) : whole), log: false }): TransferPoint[] {
  const { color, opacity } = interval;
  const { lower, upper } = shownEnds(interval, whole); // a function's ends are never open
  const opacityUpper = interval.opacityUpper ?? opacity;
  const colors = interval.colorMap ? colorMapColors(interval.colorMap) : null;
  const place = (value: number, log = false) => placeIn({ ...over, log }, value);
  const look = (value: number): TransferPoint => {
    const at = colors ? place(value, over.log) * (colors.length - 1) : 0;
    const i = Math.min(Math.floor(at), (colors?.length ?? 2) - 2);
    const own = colors ? mixColor(colors[i] as Rgb, colors[i + 1] as Rgb, at - i) : color;
    const along = 1 - Math.exp(-mix(extinction(opacity), extinction(opacityUpper), place(value)));
    return { value, color: own, opacity: opacity === opacityUpper ? opacity : along };
  };
  const parts = colors ? 4 : 2;
  return Array.from({ length: parts + 1 }, (_, i) => look(i === parts ? upper : mix(lower, upper, i / parts)));
}

/** The points between other ends, each at its place between them. */
export function stretched(points: readonly TransferPoint[], lower: number, upper: number): TransferPoint[] {
  const first = points[0] as TransferPoint;
  const last = points[points.length - 1] as TransferPoint;
  return points.map((point) => {
    const t = (point.value - first.value) / (last.value - first.value);
    return { ...point, value: t <= 0 ? lower : t >= 1 ? upper : mix(lower, upper, t) };
  });
}

/**
 * A layer's ends and the first and last point of its transfer function belong together: whichever a patch moves, the other goes along, at once and not
 * only when the server says so.
 */
export function withEnds(before: Interval, patch: IntervalPatch): IntervalPatch {
  const points = patch.transfer === undefined ? before.transfer : patch.transfer;
  const [first, last] = [points?.[0], points?.[points.length - 1]];
  if (!points || !first || !last) return patch;
  if (patch.transfer) return { ...patch, lower: first.value, upper: last.value };
  if (patch.lower === undefined && patch.upper === undefined) return patch;
  const { lower, upper } = { ...before, ...patch };
  return { ...patch, lower, upper, transfer: stretched(points, lower, upper) };
}

/** Moves one point; it stops at its neighbours, and the first and the last one leave the layer some width. */
export function movePoint(points: readonly TransferPoint[], index: number, value: number, opacity: number, axis: Range): TransferPoint[] {
  const point = points[index];
  const first = points[0];
  const last = points[points.length - 1];
  if (!point || !first || !last) return [...points];
  let least = points[index - 1]?.value ?? Math.min(axis.lower, first.value);
  let most = points[index + 1]?.value ?? Math.max(axis.upper, last.value);
  if (index === 0) most = Math.min(most, last.value - leastWidth(axis));
  if (index === points.length - 1) least = Math.max(least, first.value + leastWidth(axis));
  const moved = { ...point, value: clamp(value, least, most), opacity: clamp(opacity, 0, 1) };
  return points.map((p, i) => (i === index ? moved : p));
}

/** A new point at a value inside, in the colour that is there, and as opaque unless that is said; and its index. */
export function addPoint(
  points: readonly TransferPoint[],
  value: number,
  opacity?: number,
): { points: TransferPoint[]; index: number } | null {
  const above = points.findIndex((p) => p.value > value);
  if (above < 1) return null;
  const point = lookAt(points, value);
  if (opacity !== undefined) point.opacity = clamp(opacity, 0, 1);
  return { points: [...points.slice(0, above), point, ...points.slice(above)], index: above };
}

/** In the middle between this point and the next one, or the one before the last. */
export function addBeside(points: readonly TransferPoint[], index: number): { points: TransferPoint[]; index: number } | null {
  const from = Math.min(index, points.length - 2);
  const [a, b] = [points[from], points[from + 1]];
  return a && b && a.value < b.value ? addPoint(points, mix(a.value, b.value, 0.5)) : null;
}

/** Null if nothing would be left: two points of different values. */
export function removePoint(points: readonly TransferPoint[], index: number): TransferPoint[] | null {
  const left = points.filter((_, i) => i !== index);
  const [first, last] = [left[0], left[left.length - 1]];
  return left.length >= 2 && first && last && first.value < last.value ? left : null;
}

/** What a key does to a point: left and right its value, up and down its opacity; null for a key that means nothing here. */
export function keyToPoint(key: string, fine: boolean, point: TransferPoint, axis: Range): { value: number; opacity: number } | null {
  const scale = fine ? 0.1 : 1;
  const along = (by: number) => ({ value: roundTo(point.value + by, arrowStep(axis) * scale), opacity: point.opacity });
  const up = (by: number) => ({ value: point.value, opacity: clamp(roundTo(point.opacity + by, 0.01 * scale), 0, 1) });
  switch (key) {
    case 'ArrowRight':
      return along(arrowStep(axis) * scale);
    case 'ArrowLeft':
      return along(-arrowStep(axis) * scale);
    case 'PageUp':
      return along(pageStep(axis));
    case 'PageDown':
      return along(-pageStep(axis));
    case 'ArrowUp':
      return up(0.02 * scale);
    case 'ArrowDown':
      return up(-0.02 * scale);
    case 'Home':
      return { value: point.value, opacity: 0 };
    case 'End':
      return { value: point.value, opacity: 1 };
    default:
      return null;
  }
}

/** The curve of opacity, as it is between the points too: screen coordinates, a few to a stretch. */
export function curve(points: readonly TransferPoint[], x: (value: number) => number, y: (opacity: number) => number): [number, number][] {
  const steps = 8;
  return points.flatMap((b, i): [number, number][] => {
    const a = points[i - 1];
    if (!a || a.value === b.value || a.opacity === b.opacity) return [[x(b.value), y(b.opacity)]];
    return Array.from({ length: steps }, (_, k): [number, number] => {
      const t = (k + 1) / steps;
      const opacity = t === 1 ? b.opacity : 1 - Math.exp(-mix(extinction(a.opacity), extinction(b.opacity), t));
      return [x(mix(a.value, b.value, t)), y(opacity)];
    });
  });
}
