// A person asks for a layer's statistics, changes the layer, measures again, and takes the numbers away.
import { readFileSync } from 'node:fs';
import { expect, test } from 'vitest';
import { Stage } from './stage';

const stage = new Stage({ data: ['torus:48', 'cylinder:16x12x8x6'] });

test("a layer's statistics are those of its solid, and say when the layer has changed since", async () => {
  const viewer = await stage.open();
  await viewer.until('layers', (state) => state.intervals.length > 0);
  await viewer.page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
  const [layer] = await viewer.layersOfOurOwn(1);
  await viewer.exactPicture();
  const numbers = viewer.page.getByRole('region', { name: 'Layer 1: statistics' });
  const said = (name: string) => numbers.locator('div', { has: viewer.page.locator(`dt:text-is("${name}")`) }).locator('dd').innerText();
  await viewer.page.getByRole('button', { name: 'Layer 1: statistics' }).click();
  await expect.poll(() => numbers.locator('dt').count()).toBeGreaterThan(4);
  const mean = Number(await said('Mean'));
  expect(mean).toBeGreaterThan(layer!.lower);
  expect(mean).toBeLessThan(layer!.upper);
  // The same volume as the picture's facts have; the torus' middle is the origin, and it is in one piece.
  const facts = viewer.events.flatMap((event) => (event.kind === 'frame' ? event.frame.intervals : [])).at(-1)!;
  expect(Number(await said('Volume')) / facts.volume).toBeCloseTo(1, 5);
  for (const at of (await said('Centroid')).split(', ')) expect(Math.abs(Number(at))).toBeLessThan(1e-3);
  expect(await said('Pieces')).toBe('1');
  await numbers.getByRole('button', { name: 'Copy' }).click();
  await expect.poll(() => numbers.innerText()).toContain('Copied');
  expect(await viewer.page.evaluate(() => navigator.clipboard.readText())).toMatch(/^layer\tLayer 1\nvolume\t[\d.]+\ncentroid(\t-?[\d.e-]+){3}\npieces\t1\n/);

  await viewer.thumb(layer!, 'upper').focus();
  await viewer.page.keyboard.press('PageDown');
  await expect.poll(() => numbers.innerText()).toContain('has changed since');
  await viewer.photograph('statistics.png');
  await numbers.getByRole('button', { name: 'Measure again' }).click();
  await expect.poll(() => said('Mean').catch(() => '')).not.toBe(String(mean));
  await expect.poll(() => numbers.innerText()).not.toContain('has changed since');
  await numbers.getByRole('button', { name: /close/ }).click();
  expect(await numbers.count()).toBe(0);
  expect(viewer.problems).toEqual([]);
});

test('a table of all layers has a row for each, with the numbers that their cards say', async () => {
  const viewer = await stage.open();
  await viewer.until('layers', (state) => state.intervals.length > 0);
  const layers = await viewer.layersOfOurOwn(3);
  await viewer.exactPicture();
  await viewer.page.getByLabel('What the mesh file holds').selectOption('csv');
  const coming = viewer.page.waitForEvent('download');
  await viewer.page.getByRole('button', { name: 'Export' }).click();
  const download = await coming;
  expect(download.suggestedFilename()).toMatch(/^isostrata-torus_48-distance-r\d+\.csv$/);
  const [head, ...rows] = readFileSync(await download.path(), 'utf8').trimEnd().split('\r\n').map((line) => line.split(','));
  expect(rows.map(([name, lower, upper]) => [name, Number(lower), Number(upper)])).toEqual(layers.map(({ lower, upper }, i) => [`Layer ${i + 1}`, lower, upper]));
  const column = (name: string) => head!.indexOf(name);
  for (const [i, row] of rows.entries()) {
    const card = viewer.page.getByRole('region', { name: `Layer ${i + 1}: statistics` });
    const said = (name: string) => card.locator('div', { has: viewer.page.locator(`dt:text-is("${name}")`) }).locator('dd').innerText();
    expect(Number(await said('Volume')) / Number(row[column('volume or area')])).toBeCloseTo(1, 5);
    expect(Number(await said('Mean')) / Number(row[column('mean')])).toBeCloseTo(1, 4);
    expect(row).toHaveLength(head!.length);
  }
  // All of them come again when the page is loaded again, though the server answers one question at a time.
  await viewer.page.reload();
  for (const i of [1, 2, 3]) await viewer.page.getByRole('region', { name: `Layer ${i}: statistics` }).getByText('Standard deviation').waitFor();
  expect(viewer.problems).toEqual([]);
});
