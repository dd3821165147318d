// A person plots values along a line between two places of the picture, and over the steps at one.
import { describe, expect, test } from 'vitest';
import { readFile } from 'node:fs/promises';
import { Stage } from './stage';
import { nearest, type Viewer } from './viewer';

const stage = new Stage({ data: ['torus:48', 'cylinder:16x12x8x6'] });
let viewer: Viewer;

const viewport = () => viewer.page.getByRole('application');
const dock = () => viewer.page.getByRole('region', { name: /Values (along the line|over time)/ });
const plot = () => dock().getByRole('slider');

async function saved(): Promise<string[][]> {
  const download = viewer.page.waitForEvent('download');
  await dock().getByRole('button', { name: 'CSV' }).click();
  const text = await readFile(await (await download).path(), 'utf8');
  return text.trimEnd().split('\r\n').map((line) => line.split(','));
}

describe('values as curves', () => {
  test('two clicks plot a line; its ends are typed; its table is the field, and its layers follow', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    const [layer] = await viewer.layersOfOurOwn(1);
    const there = nearest(await viewer.exactPicture(), true);
    await viewer.page.getByRole('button', { name: 'Line', exact: true }).click();
    await viewport().click({ position: there });
    await expect.poll(() => viewport().getByRole('status').innerText()).toContain('where the line ends');
    const elsewhere = { x: there.x, y: (await viewport().boundingBox())!.height - there.y };
    await viewport().click({ position: elsewhere });
    await expect.poll(() => plot().count()).toBe(1);
    await dock().getByRole('button', { name: 'Ends' }).click();
    for (const [name, value] of [['x of end A', -1], ['y of end A', 0], ['z of end A', 0], ['x of end B', 1], ['y of end B', 0], ['z of end B', 0]] as const) {
      const field = dock().getByRole('textbox', { name });
      await field.fill(String(value));
      await field.press('Enter');
    }
    await expect.poll(async () => (await saved()).at(-1)?.slice(0, 4)).toEqual(['2', '1', '0', '0']);
    const table = await saved();
    expect(table[0]).toEqual(['distance', 'x', 'y', 'z', 'distance']);
    for (const [, x, , , value] of table.slice(1))
      expect(Math.abs(Math.abs(Math.abs(Number(x)) - 0.6) - Number(value))).toBeLessThan(0.03); // but for the cells, the torus' formula on its axis of x
    await plot().focus();
    for (let i = 0; i < 20; i++) await viewer.page.keyboard.press('ArrowRight');
    expect(await plot().getAttribute('aria-valuetext')).toMatch(/^at 0\.4: 0\.0\d+.*\(-0\.6, 0, 0\)$/); // in the middle of the tube

    // The bar of layers is where the curve has the layer's values.
    const bar = () => dock().getByRole('img', { name: /layer/i });
    await expect.poll(() => bar().getAttribute('aria-label')).toContain('Layer');
    const before = await bar().getAttribute('aria-label');
    await viewer.page.locator(`.thumb.lower[data-interval="${layer!.id}"]`).focus();
    await viewer.page.keyboard.press('PageUp');
    await expect.poll(() => bar().getAttribute('aria-label')).not.toBe(before);
    await viewer.photograph('line.png');

    // It stays while the camera turns, and goes when it is closed.
    await viewer.drag(viewport(), 60, 20);
    expect(await plot().count()).toBe(1);
    await dock().getByRole('button', { name: 'Close the plot' }).click();
    expect(await dock().count()).toBe(0);
    expect(viewer.problems).toEqual([]);
  });

  test('a place is followed over the steps, and a click goes to one', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.page.getByLabel('Dataset').selectOption('cylinder-16x12x8x6');
    await viewer.until('the cylinder', (state) => state.dataset.startsWith('cylinder') && state.intervals.length > 0);
    const there = nearest(await viewer.exactPicture(), true);
    await viewport().click({ position: there });
    const card = viewer.page.getByRole('region', { name: 'Values at this place' });
    await card.getByRole('button', { name: 'Over time' }).click();
    await expect.poll(() => plot().count()).toBe(1);
    const table = await saved();
    expect(table.map(([step]) => step)).toEqual(['step', '1', '2', '3', '4', '5', '6']);
    await viewer.photograph('over-time.png');
    const box = (await plot().boundingBox())!;
    await viewer.page.mouse.click(box.x + box.width - 2, box.y + 40);
    await viewer.until('the last step', (state) => state.step === 5);
    expect(await dock().count()).toBe(1);

    await dock().getByRole('combobox', { name: 'Array of the plot' }).selectOption({ index: 1 });
    await expect.poll(async () => (await saved())[0]?.[2]).not.toBe(table[0]?.[2]);
    expect(viewer.problems).toEqual([]);
  });

  test('L begins and ends a line by the keyboard, and Escape leaves it', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.layersOfOurOwn(1);
    const picture = await viewer.exactPicture();
    const there = nearest(picture, true), box = (await viewport().boundingBox())!;
    await viewer.page.mouse.move(box.x + there.x, box.y + there.y);
    await viewer.page.keyboard.press('l');
    await expect.poll(() => viewport().getByRole('status').innerText()).toContain('where the line ends');
    await viewer.page.keyboard.press('Escape');
    expect(await viewport().getByRole('status').count()).toBe(0);
    await viewer.page.keyboard.press('l');
    await expect.poll(() => viewport().getByRole('status').innerText()).toContain('where the line ends');
    await viewer.page.mouse.move(box.x + there.x, box.y + box.height - there.y);
    await viewer.page.keyboard.press('l');
    await expect.poll(() => plot().count()).toBe(1);
    expect(viewer.problems).toEqual([]);
  });
});
