// What a person is told about the picture: why there is nothing in it, and how far it can be trusted.
import { formatNumber } from './ticks';
import type { SceneState } from './model';
import type { ArrayInfo, CoarseError, DatasetInfo, Frame, Histogram } from './told';

type Shown = Pick<Frame, 'phase' | 'revision' | 'tetrahedra' | 'height'> & Partial<Pick<Frame, 'pointStride' | 'coarseError' | 'samples'>>;

type Drawn = Pick<Frame, 'tetrahedra' | 'intervals'> & Partial<Pick<Frame, 'pointStride'>>;

/** Why the picture has to be empty; null if something is to be seen, or nobody knows yet. blank: a finished picture is all background. */
export function emptyReason(view: SceneState, info: DatasetInfo | null, frame: Drawn | null, blank: boolean): string | null {
  if (!view.dataset || info?.id !== view.dataset) return null;
  if (info.cells === 0)
    return `Nothing to show: ${info.name} has ${info.points.toLocaleString('en')} points and no cells. Layers are cut out of cells.`;
  if (info.arrays.length === 0) return `Nothing to show: ${info.name} has no array of numbers, so there are no values to cut at.`;
  if (view.intervals.length === 0) {
    if (info.nothingToShow) return `Nothing to show: ${info.nothingToShow}.`;
    return 'No layers yet. Drag across the histogram below to make one.';
  }
  const seen = view.intervals.filter((interval) => interval.visible);
  if (seen.length === 0 && !view.terms.some((term) => !term.hidden)) return 'Nothing to show: all layers are hidden.';
  const areas = frame?.intervals.some(({ id, area }) => area && seen.some((interval) => interval.id === id));
  const firstLook = (frame?.pointStride ?? 1) > 1; // what lies between its points is not in it
  if (frame?.tetrahedra !== 0 || areas || firstLook)
    return blank ? 'None of the layers can be seen here. Reset shows all; what is still not seen is too thin or too transparent.' : null;
  const array = info.arrays.find((a) => a.name === view.array);
  if (array && !(array.lower <= array.upper)) return `Nothing to show: ${view.array} has no finite value.`;
  const step = info.times.length > 1 ? ' at this time' : '';
  return `Nothing to show: no cell${step} has values of ${view.array} in any layer${view.terms.length ? ', as they are combined' : ''}.`;
}

/** How many points of the array lie in no layer, at the shown step if that is known; '' if none. */
export function nanWords(view: SceneState, { points, times }: DatasetInfo, array: ArrayInfo, histogram: Histogram | null): string {
  const words = (count: number, when: string) => (count > 0 ? `${count.toLocaleString('en')} points of ${array.name} are NaN${when} and lie in no layer.` : '');
  if (times.length < 2 || array.nanCount <= 0) return words(array.nanCount, '');
  const { dataset, step, time } = view;
  const here = array.steps[step];
  const counted =
    histogram?.dataset === dataset && histogram.array === array.name && histogram.step === step &&
    here && histogram.lower <= here.lower && histogram.upper >= here.upper; // none of its values is beyond the bins
  if (!counted || (time ?? null) !== null || view.values === 'whole') return `At some steps up to ${words(array.nanCount, '')}`;
  return words(points - histogram.counts.reduce((sum, count) => sum + count, 0), ' at this step');
}

/** Whether every pixel (rgba) has the background's colour, up to rounding. */
export function isBlank(pixels: Uint8ClampedArray, background: readonly [number, number, number]): boolean {
  const [r, g, b] = background.map((c) => c * 255) as [number, number, number];
  for (let i = 0; i < pixels.length; i += 4)
    if (Math.abs(pixels[i]! - r) > 1.5 || Math.abs(pixels[i + 1]! - g) > 1.5 || Math.abs(pixels[i + 2]! - b) > 1.5) return false;
  return true;
}

export interface Badge {
  word: string;
  kind: 'moving' | 'settled' | 'exact' | 'empty' | 'older';
  title: string;
}

/** Two digits that are not less than the value. */
function atMost(value: number): string {
  const unit = 10 ** (Math.floor(Math.log10(value)) - 1);
  return value > 0 ? formatNumber(Math.ceil(value / unit) * unit, 2) : '0';
}

/** Of the field between the points that went into a picture. */
function farOff(error: CoarseError | null | undefined): string {
  if (!error) return '';
  return ` Its values are within ${atMost(error.largest)} of those of all points, ${formatNumber(error.mean, 2)} in the mean.`;
}

/** "exact" only if what the controls show is in the picture, losslessly, and there is something to be exact about. */
export function badgeOf(frame: Shown, state: { revision: number; waits: boolean }, empty: boolean, viewportHeight: number): Badge {
  if (frame.pointStride && frame.pointStride > 1)
    return {
      word: frame.phase === 'moving' ? `moving, coarse${frame.coarseError ? ` ±${atMost(frame.coarseError.largest)}, mean ${formatNumber(frame.coarseError.mean, 2)}` : ''}` : 'first look',
      kind: 'moving',
      title: `One point in ${frame.pointStride} along each axis went into this picture.${farOff(frame.coarseError)} That of all points follows.`,
    };
  if (frame.phase === 'moving') {
    // Of the viewport's height, where the connection is too slow for all of it.
    const share = frame.height / viewportHeight;
    return {
      word: share < 0.98 ? `moving at ${Math.round(share * 100)} %` : 'moving',
      kind: 'moving',
      title: 'A quick picture while something changes, as good as the connection carries: its colours are not exact.',
    };
  }
  if (frame.phase === 'settled')
    return { word: 'settled', kind: 'settled', title: 'Of full size and good quality; the exact picture is on its way.' };
  if (state.waits)
    return { word: 'older', kind: 'older', title: 'The picture shows an earlier state than the controls: the server has not answered yet.' };
  if (frame.revision < state.revision)
    return { word: 'older', kind: 'older', title: 'The picture shows an earlier state than the controls. Any change draws the newest one.' };
  if (empty) return { word: 'nothing to show', kind: 'empty', title: 'The words on the picture say why.' };
  const samples = frame.samples ?? 1;
  const smooth = samples > 1 ? ` Each pixel is the mean of ${samples} x ${samples} samples.` : '';
  return { word: 'exact', kind: 'exact', title: `Lossless: the colours are exact.${smooth}` };
}

/** Of a layer's volume. Tetrahedra are cut exactly, other cells straight. */
export function sureness(error: number): string {
  return error === 0
    ? 'It is that of the interpolated field'
    : `It is estimated to be within ${formatNumber(error, 2)} of the volume that the cells' own, curved interpolation gives`;
}
