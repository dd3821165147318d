// A place of the picture in words: for the card beside it, and as text to take away.
import { asInFile } from './axes';
import { layerNumber } from './intervals';
import type { SceneState } from './model';
import type { Axis, ProbeResult } from './told';

/** What the layer there is called. */
export function probedLayer(result: ProbeResult, scene: Pick<SceneState, 'intervals' | 'terms'>): string {
  const interval = scene.intervals.find(({ id }) => id === result.interval);
  if (interval) return interval.name || layerNumber(scene.intervals, interval.id);
  const term = result.term === null ? undefined : scene.terms[result.term];
  return term ? `What ${term.array} brings in` : 'A layer';
}

/** Where the line of sight comes into it. */
export const endWords: Record<ProbeResult['end'], string> = {
  lower: 'at its lower end',
  upper: 'at its upper end',
  domain: 'where the data ends',
  range: 'at the end of a combined range',
  cut: 'at a clip plane',
  eye: 'the eye is inside',
};

/** A number as it is read, of so many digits that neighbouring pixels differ, also if all values are near to each other: within `span`. */
export function precisely(value: number | null, span = 0): string {
  if (value === null) return 'no number';
  const more = span > 0 && Math.abs(value) > span ? Math.ceil(Math.log10(Math.abs(value) / span)) : 0;
  const short = Number(value.toPrecision(Math.min(7 + more, 17)));
  return Object.is(short, -0) ? '0' : String(short);
}

/** Lines of a name, a tab, and values in all their digits: what a table takes. */
export function probeText(result: ProbeResult, scene: Pick<SceneState, 'intervals' | 'terms'>, axes?: readonly Axis[]): string {
  const lines: [string, ...(string | number)[]][] = [
    ['layer', probedLayer(result, scene)],
    ['position', ...result.position.map((at, axis) => asInFile(axes, axis, at))],
  ];
  if (result.cellIndex.length) lines.push(['cell i j k', ...result.cellIndex], ['nearest point i j k', ...result.pointIndex]);
  else if (result.cell !== null) lines.push(['cell', result.cell], ['nearest point', result.point ?? '']);
  lines.push(result.time === null ? ['step', result.step] : ['time', result.time]);
  for (const { name, value, cellValue } of result.arrays) {
    lines.push([name, value ?? '']);
    if (cellValue !== null) lines.push([`${name} (cell)`, cellValue]);
  }
  return lines.map((line) => line.join('\t')).join('\n');
}
