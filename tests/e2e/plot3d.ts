// A PLOT3D flow that a test makes itself: grid and solution, 4-byte numbers, last byte first, no record marks.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';

/** Writes NAMExyz.bin and NAMEq.bin: a bent channel of `size` points whose density rises from 0.2 to 5 along it. */
export function writePlot3d(folder: string, name: string, size: readonly [number, number, number]): string {
  const [ni, nj, nk] = size;
  const points: [number, number, number][] = [];
  for (let k = 0; k < nk; k++)
    for (let j = 0; j < nj; j++)
      for (let i = 0; i < ni; i++) {
        const along = (4 * i) / (ni - 1);
        points.push([along, (2 * j) / (nj - 1) + 0.15 * along * along, (1.5 * k) / (nk - 1)]);
      }
  const write = (path: string, constants: number[], variables: ((p: [number, number, number]) => number)[]): void => {
    const bytes = new DataView(new ArrayBuffer(4 * (3 + constants.length + variables.length * points.length)));
    let at = 0;
    for (const n of size) bytes.setInt32(4 * at++, n);
    for (const c of constants) bytes.setFloat32(4 * at++, c);
    for (const variable of variables) for (const p of points) bytes.setFloat32(4 * at++, variable(p));
    writeFileSync(path, new Uint8Array(bytes.buffer));
  };
  const grid = join(folder, `${name}xyz.bin`);
  write(grid, [], [(p) => p[0], (p) => p[1], (p) => p[2]]);
  const density = (p: [number, number, number]) => 0.2 + 1.2 * p[0];
  write(join(folder, `${name}q.bin`), [0.8, 0, 1e6, 0], [density, () => 1, (p) => 0.3 * p[0], () => 0, (p) => 2 + p[2]]);
  return grid;
}
