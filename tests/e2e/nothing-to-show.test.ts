// Files that have less to show than one hopes: the page says what is missing, and keeps no facts of the file before.
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Browser } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { Server } from './server';
import { drawnPixels, launch, Viewer } from './viewer';

let folder: string;
let server: Server;
let browser: Browser;

const range = (n: number) => Array.from({ length: n }, (_, i) => i);

/** Hexahedra, n to a side, with values and with names, which nobody can cut at. */
function block(n: number, x: number): string {
  const points = range((n + 1) ** 3).map((i) => [x + (i % (n + 1)), Math.floor(i / (n + 1)) % (n + 1), Math.floor(i / (n + 1) ** 2)]);
  const at = (i: number, j: number, k: number) => i + (n + 1) * (j + (n + 1) * k);
  const cells = range(n ** 3).map((c) => {
    const [i, j, k] = [c % n, Math.floor(c / n) % n, Math.floor(c / n ** 2)];
    return [0, 1].flatMap((up) => [at(i, j, k + up), at(i + 1, j, k + up), at(i + 1, j + 1, k + up), at(i, j + 1, k + up)]);
  });
  const numbers = (name: string, type: string, values: number[], more = '') =>
    `<DataArray type="${type}" Name="${name}" format="ascii"${more}>${values.join(' ')}</DataArray>`;
  const words = points.flatMap(() => [97, 0]).join(' ');
  return `<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="${points.length}" NumberOfCells="${cells.length}"><PointData>
${numbers('height', 'Float64', points.map(([px, py, pz]) => px! + py! / 7 + pz! / 3))}
<DataArray type="String" Name="label" format="ascii">${words}</DataArray></PointData>
<Points>${numbers('Points', 'Float64', points.flat(), ' NumberOfComponents="3"')}</Points>
<Cells>${numbers('connectivity', 'Int64', cells.flat())}${numbers('offsets', 'Int64', range(cells.length).map((i) => 8 * (i + 1)))}
${numbers('types', 'UInt8', cells.map(() => 12))}</Cells></Piece></UnstructuredGrid></VTKFile>`;
}

function points(n: number): string {
  const at = range(n).map((i) => `${i} ${i % 3} ${i % 7}`);
  return `# vtk DataFile Version 3.0\npoints\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS ${n} float\n${at.join('\n')}
CELLS ${n} ${2 * n}\n${range(n).map((i) => `1 ${i}`).join('\n')}\nCELL_TYPES ${n}\n${range(n).map(() => 1).join('\n')}
POINT_DATA ${n}\nSCALARS charge float 1\nLOOKUP_TABLE default\n${range(n).join('\n')}\n`;
}

/** One value at 8 x 8 x 8 points, in NumPy's format. */
function constant(value: number): Buffer {
  const head = "{'descr': '<f4', 'fortran_order': False, 'shape': (8, 8, 8), }".padEnd(117) + '\n';
  const values = Buffer.alloc(4 * 512);
  for (let i = 0; i < 512; i++) values.writeFloatLE(value, 4 * i);
  return Buffer.concat([Buffer.from([0x93, ...Buffer.from('NUMPY'), 1, 0, head.length, 0]), Buffer.from(head), values]);
}

beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-empty-'));
  writeFileSync(join(folder, 'a.vtu'), block(3, 0));
  writeFileSync(join(folder, 'b.vtu'), block(3, 3));
  writeFileSync(
    join(folder, 'two-parts.pvd'),
    '<?xml version="1.0"?><VTKFile type="Collection" version="0.1"><Collection>' +
      '<DataSet timestep="0" part="0" file="a.vtu"/><DataSet timestep="0" part="1" file="b.vtu"/></Collection></VTKFile>',
  );
  writeFileSync(join(folder, 'points.vtk'), points(1234));
  writeFileSync(join(folder, 'broken.vtk'), '# vtk DataFile Version 3.0\nbroken\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 9 9\n');
  writeFileSync(join(folder, 'constant.npy'), constant(4));
  writeFileSync(join(folder, 'nan.npy'), constant(Number.NaN));
  const files = ['points.vtk', 'two-parts.pvd', 'constant.npy', 'nan.npy'].map((name) => join(folder, name));
  server = await Server.start({ data: [...files, 'sphere:16', 'diamond:16'] });
  browser = await launch();
});
afterAll(async () => {
  await browser?.close();
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});

test('facts are those of the dataset that is open, also where two notes are equal and where there are no cells', async () => {
  const viewer = await Viewer.open(browser, server.ready.url);
  const panel = viewer.page.getByRole('region', { name: 'Data' });
  const choose = async (label: RegExp | string) => {
    const option = viewer.page.getByLabel('Dataset').locator('option').filter({ hasText: label });
    await viewer.page.getByLabel('Dataset').selectOption((await option.getAttribute('value')) as string);
  };
  const badge = viewer.page.locator('footer .phase');
  await choose('two-parts');
  await expect.poll(() => panel.innerText()).toContain('54 cells');
  const notes = (await panel.innerText()).split('\n').filter((line) => line.includes("array 'label'"));
  expect(notes.length, notes.join()).toBe(1);
  expect(notes[0]).toContain('(× 2)');
  await expect.poll(() => badge.innerText()).toBe('exact');

  await choose('points');
  await expect.poll(() => panel.innerText()).toContain('0 cells');
  expect(await panel.innerText()).not.toContain('54 cells');
  expect(await panel.innerText()).toContain('1,234 points');
  await expect.poll(() => viewer.page.locator('.viewport').innerText()).toContain('1,234 points and no cells');
  await expect.poll(() => badge.innerText()).toBe('nothing to show');
  await viewer.photograph('no-cells.png');

  await choose('sphere');
  await viewer.until('layers', (state) => state.dataset.startsWith('sphere') && state.intervals.length > 0);
  await expect.poll(() => badge.innerText()).toBe('exact');
  expect(drawnPixels(await viewer.exactPicture())).toBeGreaterThan(0);

  // A layer where no value is.
  const first = viewer.state.intervals[0]!;
  for (const { id } of viewer.state.intervals.slice(1))
    await viewer.page.locator(`[data-layer="${id}"]`).getByRole('button', { name: /delete/ }).click();
  const upper = viewer.row(first).getByRole('textbox', { name: /upper end/ });
  await upper.fill('1000');
  await upper.press('Enter');
  const lower = viewer.row(first).getByRole('textbox', { name: /lower end/ });
  await lower.fill('999');
  await lower.press('Enter');
  await expect.poll(() => viewer.page.locator('.viewport').innerText()).toContain('no cell has values');
  await expect.poll(() => badge.innerText()).toBe('nothing to show');
  expect(viewer.problems).toEqual([]);
  await viewer.close();
});

test('a flat grid is a picture of areas, and its layers say theirs', async () => {
  const viewer = await Viewer.open(browser, server.ready.url);
  const option = viewer.page.getByLabel('Dataset').locator('option').filter({ hasText: 'diamond' });
  await viewer.page.getByLabel('Dataset').selectOption((await option.getAttribute('value')) as string);
  await viewer.until('layers', (state) => state.dataset.startsWith('diamond') && state.intervals.length > 0);
  await expect.poll(() => viewer.page.locator('footer .phase').innerText()).toBe('exact');
  expect(drawnPixels(await viewer.exactPicture())).toBeGreaterThan(1000);
  expect(await viewer.page.locator('.viewport').innerText()).not.toContain('Nothing to show');
  await expect.poll(() => viewer.row(viewer.state.intervals[0]!).locator('.facts').innerText()).toMatch(/area [\d.]+/);
  await viewer.photograph('areas.png');
  expect(viewer.problems).toEqual([]);
  await viewer.close();
});

test('values that are all the same, or no numbers, are said to be that', async () => {
  const viewer = await Viewer.open(browser, server.ready.url);
  for (const [name, reason] of [['constant', 'every array has one value everywhere'], ['nan', 'no array has a finite value']] as const) {
    const option = viewer.page.getByLabel('Dataset').locator('option').filter({ hasText: `${name}.npy` });
    await viewer.page.getByLabel('Dataset').selectOption((await option.getAttribute('value')) as string);
    await expect.poll(() => viewer.page.locator('.viewport').innerText()).toContain(`Nothing to show: ${reason}.`);
    await expect.poll(() => viewer.page.locator('footer .phase').innerText()).toBe('nothing to show');
    await viewer.photograph(`${name}.png`);
  }
  expect(viewer.problems).toEqual([]);
  await viewer.close();
});

test('a picture beside which the layers lie says so until they are in it again', async () => {
  const viewer = await Viewer.open(browser, server.ready.url);
  const option = viewer.page.getByLabel('Dataset').locator('option').filter({ hasText: 'sphere' });
  await viewer.page.getByLabel('Dataset').selectOption((await option.getAttribute('value')) as string);
  await viewer.until('layers', (state) => state.dataset.startsWith('sphere') && state.intervals.length > 0);
  await viewer.exactPicture();
  const viewport = viewer.page.locator('.viewport');
  expect(await viewport.innerText()).not.toContain('None of the layers');
  await viewport.focus();
  for (let i = 0; i < 60; i++) await viewer.page.keyboard.press('Shift+ArrowLeft');
  await expect.poll(() => viewport.innerText()).toContain('None of the layers can be seen here');
  expect(drawnPixels(await viewer.exactPicture())).toBe(0);
  await viewer.page.getByRole('button', { name: 'Reset' }).click();
  await expect.poll(() => viewport.innerText()).not.toContain('None of the layers');
  expect(drawnPixels(await viewer.exactPicture())).toBeGreaterThan(0);
  await viewer.close();
});

test('where nothing can be opened no button works on a picture, and nothing is said of layers to draw', async () => {
  const broken = await Server.start({ data: [join(folder, 'broken.vtk')] });
  try {
    const viewer = await Viewer.open(browser, broken.ready.url);
    await viewer.page.getByRole('alert').first().waitFor();
    const working = await viewer.page.getByRole('group', { name: 'Views' }).getByRole('button', { disabled: false }).evaluateAll((all) => all.map((of) => of.getAttribute('aria-label') ?? of.textContent));
    expect(working).toEqual(['Full screen']);
    expect(await viewer.page.getByText('Drag across the histogram').count()).toBe(0);
    expect(await viewer.page.getByText('Choose a dataset to begin.').count()).toBe(1);
    await viewer.close();
  } finally {
    await broken.stop();
  }
});
