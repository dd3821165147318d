// What the axes of a dataset's space are, in words and numbers.
import type { Axis } from './told';

export const letters = ['x', 'y', 'z'] as const;

/** "longitude (degrees_east)", "z (mm)", "x". */
export function axisTitle(axes: readonly Axis[] | undefined, axis: 0 | 1 | 2): string {
  const { name, unit } = axes?.[axis] ?? { name: '', unit: '' };
  return (name || letters[axis]) + (unit ? ` (${unit})` : '');
}

/** A place along an axis as the file counts it, and back: pressures and depths are counted downwards. */
export const asInFile = (axes: readonly Axis[] | undefined, axis: number, place: number): number => (axes?.[axis]?.downward ? 0 - place : place);

/** The unit of a length ('mm'), an area (2) or a volume (3), after a blank; '' if the axes have none in common. */
export function unitOf(axes: readonly Axis[] | undefined, power: 1 | 2 | 3): string {
  const unit = axes?.[0]?.unit ?? '';
  const common = unit && axes?.every((axis, i) => axis.unit === unit || (power === 2 && i === 2));
  return common ? ` ${unit}${power === 1 ? '' : power === 2 ? '²' : '³'}` : '';
}
