// Over which values a layer's colour map runs, as the server has it (server/scene/color_range.h).
import { colorMapColors } from './color-maps';
import { shownEnds } from './intervals';
import { stepRange, type Interval, type Range, type Rgb, type SceneState } from './model';
import type { ArrayInfo } from './told';

export interface MapRange extends Range {
  log: boolean; // colours run with the value's logarithm
}

const logFloor = 1e-4; // of the upper end: where a logarithmic range begins that would begin at 0 or below

/** Of the array that colours run over. */
export function mapRange(scene: SceneState, array: ArrayInfo, interval: Interval): MapRange {
  const range = scene.colorRange ?? stepRange;
  const step = array.steps[scene.step];
  const here = range.span === 'own' ? range : range.span === 'step' && step && step.lower <= step.upper && (scene.time ?? null) === null ? step : array;
  const { lower, upper } = interval.ownRange ? shownEnds(interval, array) : here;
  const log = range.log && upper > 0;
  return { lower: log && !(lower > 0) ? logFloor * upper : lower, upper, log };
}

/** How far a value is along the range, from 0 to 1. */
export function placeIn({ lower, upper, log }: MapRange, value: number): number {
  const share = log ? Math.log(Math.max(value, lower) / lower) / Math.log(upper / lower) : (value - lower) / (upper - lower);
  return Number.isNaN(share) ? 0 : Math.min(Math.max(share, 0), 1);
}

/** The map's colours and the values that have them, from the range's lower end to its upper one; none of a map that has no preview here. */
export function mapStops(map: string, { lower, upper, log }: MapRange): { value: number; color: Rgb }[] {
  const colors = colorMapColors(map) ?? [];
  return colors.map((color, i) => {
    const t = i / (colors.length - 1);
    return { value: log ? lower * (upper / lower) ** t : lower + (upper - lower) * t, color };
  });
}
