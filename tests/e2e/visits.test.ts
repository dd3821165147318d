// A dataset that is chosen again in the same tab.
import { describe, expect, test } from 'vitest';
import { Stage } from './stage';
import { difference, Viewer } from './viewer';

const stage = new Stage({ data: ['torus:48', 'sphere:24', 'cylinder:16x24x4x5'] });
let viewer: Viewer;

async function choose(name: RegExp): Promise<void> {
  const options = await viewer.page.locator('#dataset option').evaluateAll((all) => all.map((o) => [(o as HTMLOptionElement).value, o.textContent ?? ''] as const));
  const id = options.find(([, text]) => name.test(text))![0];
  await viewer.page.getByLabel('Dataset').selectOption(id);
  await viewer.until(`the dataset ${id}`, (state) => state.dataset === id && state.intervals.length > 0);
}
const back = () => viewer.page.getByText('are as you left them').count();

describe('a dataset that is chosen again', () => {
  test('is as it was left, until one starts anew; and that can be undone', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await choose(/torus/);
    const first = await viewer.exactPicture();
    await viewer.layersOfOurOwn(2);
    await viewer.page.getByRole('button', { name: 'Add cut' }).click();
    await viewer.drag(viewer.page.getByRole('application'), 80, 30);
    await viewer.until('a cut', (state) => state.clipPlanes?.length === 1);
    const own = await viewer.exactPicture();
    expect(difference(first, own)).toBeGreaterThan(0.1);

    await choose(/sphere/);
    expect(await back()).toBe(0);
    await choose(/torus/);
    await viewer.until('the layers', (state) => state.intervals.length === 2 && state.clipPlanes?.length === 1);
    expect(difference(own, await viewer.exactPicture())).toBe(0);
    await expect.poll(back).toBe(1);
    await viewer.photograph('as-you-left-them.png');

    await viewer.page.getByRole('button', { name: 'Start anew' }).click();
    await viewer.until('the first view', (state) => state.clipPlanes?.length === 0);
    expect(difference(first, await viewer.exactPicture())).toBe(0);
    expect(await back()).toBe(0);
    await viewer.page.keyboard.press('Control+z');
    await viewer.until('the own one', (state) => state.clipPlanes?.length === 1 && state.intervals.length === 2);
    await viewer.page.keyboard.press('Control+y');
    await viewer.until('the first one', (state) => state.clipPlanes?.length === 0);
    expect(viewer.problems).toEqual([]);
  });

  test('is opened by undoing the choice of another one, as it was left; what was done there is undone as well, also after a reload', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await choose(/torus/);
    const [layer] = await viewer.layersOfOurOwn(1);
    await viewer.row(layer!).locator('input[type=color]').fill('#ff00ff');
    await viewer.until('the colour', (state) => state.intervals[0]!.color[1] === 0);
    await viewer.drag(viewer.page.getByRole('application'), 60, 30);
    await viewer.page.waitForTimeout(300);
    const torus = await viewer.exactPicture();
    await choose(/sphere/);
    await viewer.exactPicture();
    await viewer.page.getByRole('button', { name: 'Add cut' }).click();
    await viewer.until('a cut', (state) => state.clipPlanes?.length === 1);
    const sphere = await viewer.exactPicture();

    const undo = viewer.page.getByRole('button', { name: 'Undo', exact: true });
    await undo.click();
    await viewer.until('no cut', (state) => state.clipPlanes?.length === 0);
    expect(await undo.getAttribute('title')).toBe('Undo opening sphere:24 (Ctrl+Z)');
    await undo.click();
    await viewer.until('the torus', (state) => state.dataset.startsWith('torus') && state.intervals[0]?.color[1] === 0);
    expect(difference(torus, await viewer.exactPicture())).toBe(0);
    await viewer.page.reload();
    await viewer.exactPicture();
    await undo.click();
    await viewer.until('the colour of before', (state) => state.intervals[0]?.color[1] !== 0);

    const redo = viewer.page.getByRole('button', { name: 'Redo', exact: true });
    for (let i = 0; i < 3; i++) await redo.click(); // the colour, the sphere, its cut; those that come too early wait
    await viewer.until('the sphere', (state) => state.dataset.startsWith('sphere') && state.clipPlanes?.length === 1);
    expect(difference(sphere, await viewer.exactPicture())).toBe(0);
    for (let i = 0; i < 3; i++) await undo.click();
    await viewer.until('all is undone', (state) => state.dataset.startsWith('torus') && state.intervals[0]?.color[1] !== 0);
    expect(viewer.problems).toEqual([]);
  });

  test('of which nothing was changed is shown as at first, without a word; a reload forgets nothing', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await choose(/sphere/);
    await choose(/torus/);
    await viewer.layersOfOurOwn(1);
    await choose(/sphere/);
    await viewer.exactPicture();
    expect(await back()).toBe(0);
    await viewer.page.reload();
    await viewer.exactPicture();
    await choose(/torus/);
    await viewer.until('the one layer', (state) => state.intervals.length === 1);
    await expect.poll(back).toBe(1);
    expect(viewer.problems).toEqual([]);
  });
});
