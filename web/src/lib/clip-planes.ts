// Clip planes as the panel shows them: along an axis, kept below or above a place in the box. Others keep their normal.
import type { Box, ClipPlane } from './model';

export const sides = ['x<', 'x>', 'y<', 'y>', 'z<', 'z>'] as const;
export type Side = (typeof sides)[number];

/** Which axis and side a plane keeps; null if it is oblique. */
export function sideOf({ normal }: ClipPlane): Side | null {
  const axis = [0, 1, 2].filter((a) => normal[a] !== 0);
  if (axis.length !== 1) return null;
  const a = axis[0] as number;
  return sides[2 * a + ((normal[a] as number) > 0 ? 1 : 0)] as Side;
}

/** Where an axis-aligned plane stands on its axis. */
export function placeOf(plane: ClipPlane): number {
  const n = plane.normal.find((v) => v !== 0) ?? 1;
  return plane.offset / n;
}

export function planeAt(side: Side, place: number): ClipPlane {
  const a = Math.floor(sides.indexOf(side) / 2);
  const sign = side.endsWith('>') ? 1 : -1;
  const normal = [0, 1, 2].map((axis) => (axis === a ? sign : 0)) as [number, number, number];
  return { normal, offset: sign * place };
}

/** The values that `dot(normal, position)` takes in the box: what a slider for the offset runs over. */
export function offsetsIn({ normal }: ClipPlane, box: Box): { lower: number; upper: number } {
  let [lower, upper] = [0, 0];
  for (const a of [0, 1, 2]) {
    const n = normal[a] as number;
    const ends = [n * (box.lower[a] as number), n * (box.upper[a] as number)];
    lower += Math.min(...ends);
    upper += Math.max(...ends);
  }
  return { lower, upper };
}

/** A new plane: the half, nearer to its lower end, of the axis that is drawn the longest. */
export function firstPlane(box: Box, factors: readonly number[] = [1, 1, 1]): ClipPlane {
  const extent = [0, 1, 2].map((a) => ((box.upper[a] as number) - (box.lower[a] as number)) * (factors[a] as number));
  const a = extent.indexOf(Math.max(...extent));
  return planeAt(sides[2 * a] as Side, ((box.lower[a] as number) + (box.upper[a] as number)) / 2);
}
