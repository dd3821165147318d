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
