// A person asks for a layer's statistics, changes the layer, measures again, and takes the numbers away.
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
