// Undo and redo in a real browser against a real server, alone and beside somebody else.
import { describe, expect, test } from 'vitest';
import type { Interval, SceneState } from '../../web/src/lib/model';
import { Stage } from './stage';
import { difference, Viewer } from './viewer';

const stage = new Stage({ data: ['torus:48', 'cylinder:16x24x4x5'] });
let viewer: Viewer;

async function open(dataset = /torus/): Promise<void> {
  viewer = await stage.open();
  await viewer.until('layers', (state) => state.intervals.length > 0);
  const { name, id } = viewer.events.flatMap((event) => (event.kind === 'welcome' ? event.welcome.datasets : [])).find((entry) => dataset.test(entry.name))!;
  if (viewer.state.dataset !== id) await viewer.page.getByLabel('Dataset').selectOption(id);
  await viewer.until(name, (state) => state.dataset === id && state.intervals.length > 0);
  await viewer.exactPicture();
}
const undo = () => viewer.page.keyboard.press('Control+z');
const redo = () => viewer.page.keyboard.press('Control+Shift+Z');
/** What is undone: all but where one stands, and ids, which the server gives anew. Colours by no array are those by the array that is cut. */
const undone = ({ revision: _r, camera: _c, cycle: _y, intervals, ...rest }: SceneState) =>
  JSON.stringify({ ...rest, colorBy: rest.colorBy || rest.array, intervals: intervals.map(({ id: _i, priority: _p, ...layer }) => layer) });

describe('undo', () => {
  test('a drag is one step; the picture of before comes back to the last bit', async () => {
    await open();
    const [layer] = (await viewer.layersOfOurOwn(1)) as [Interval];
    const before = await viewer.exactPicture();
    await viewer.drag(viewer.thumb(layer, 'upper'), 60, 0);
    await viewer.until('a wider layer', ({ intervals }) => intervals[0]!.upper > layer.upper);
    const after = await viewer.exactPicture();
    expect(difference(before, after)).toBeGreaterThan(0.1);
    await undo();
    await viewer.until('the end of before', ({ intervals }) => intervals[0]!.upper === layer.upper);
    expect(difference(before, await viewer.exactPicture())).toBe(0);
    await viewer.page.getByRole('button', { name: 'Redo' }).click();
    await viewer.until('the wider one', ({ intervals }) => intervals[0]!.upper > layer.upper);
    expect(difference(after, await viewer.exactPicture())).toBe(0);
    expect(viewer.problems).toEqual([]);
  });

  test('a page that is loaded again undoes what was done before', async () => {
    await open();
    const [layer] = (await viewer.layersOfOurOwn(1)) as [Interval];
    await viewer.drag(viewer.thumb(layer, 'upper'), 60, 0);
    await viewer.until('a wider layer', ({ intervals }) => intervals[0]!.upper > layer.upper);
    await viewer.exactPicture();
    await viewer.page.waitForTimeout(500); // until it is written down
    await viewer.page.reload();
    await expect.poll(() => viewer.page.getByRole('button', { name: /^Undo/ }).isEnabled()).toBe(true);
    await viewer.exactPicture();
    await undo();
    await viewer.until('the end of before', ({ intervals }) => intervals[0]!.upper === layer.upper);
    await viewer.page.getByRole('button', { name: 'Redo' }).click();
    await viewer.until('the wider one', ({ intervals }) => intervals[0]!.upper > layer.upper);
    expect(viewer.problems).toEqual([]);
  });

  test('everything that was done goes back step by step, and forth again', async () => {
    await open(/cylinder/);
    const { page } = viewer;
    const states = [undone(viewer.state)];
    const layers = () => page.locator('[data-layer]');
    const arrays = await page.getByLabel('Layers of').locator('option').evaluateAll((all) => all.map((option) => (option as HTMLOptionElement).value));
    const acts: [string, () => Promise<unknown>][] = [
      ['visibility', () => layers().first().getByRole('button', { name: /visible/ }).click()],
      ['colour map', () => layers().first().getByLabel('colour or colour map').selectOption('viridis')],
      ['function', () => layers().first().getByLabel('colour or colour map').selectOption(' function')],
      ['opacity', () => layers().last().getByLabel(/opacity/).first().press('ArrowRight')],
      ['another array', () => page.getByLabel('Layers of').selectOption(arrays.at(-1)!)],
      ['a new layer', () => page.getByRole('button', { name: 'Add layer' }).click()],
      ['deleted', () => layers().first().getByRole('button', { name: /delete/ }).click()],
      ['cut', () => page.getByRole('button', { name: 'Add cut' }).click()],
      ['another cut', () => page.getByRole('button', { name: 'Add cut' }).click()],
      ['step', () => page.getByRole('button', { name: 'Step on' }).click()],
      ['between steps', () => page.getByLabel('Between steps').selectOption('interpolate')],
      ['mode', () => page.getByRole('radio', { name: 'Priority' }).click()],
      ['white', () => page.getByRole('button', { name: 'White' }).click()],
    ];
    const done: string[] = [];
    for (const [name, act] of acts) {
      const { revision } = viewer.state;
      await act();
      await viewer.until(name, (state) => state.revision > revision);
      await page.waitForTimeout(750); // a pause is the end of a step, and States follow
      if (undone(viewer.state) !== states.at(-1)) {
        states.push(undone(viewer.state));
        done.push(name);
      }
    }
    expect(done.length).toBeGreaterThan(10);
    for (let i = states.length - 2; i >= 0; i--) {
      await undo();
      await viewer.until(`${done[i]} undone, to ${states[i]}`, (state) => undone(state) === states[i]);
    }
    expect(await page.getByRole('button', { name: 'Undo' }).isDisabled()).toBe(true);
    for (let i = 1; i < states.length; i++) {
      await redo();
      await viewer.until(`${done[i - 1]} redone, to ${states[i]}`, (state) => undone(state) === states[i]);
    }
    expect(viewer.problems).toEqual([]);
  });

  test('what somebody else has changed since stays, and the page says so', async () => {
    await open();
    const [layer] = (await viewer.layersOfOurOwn(1)) as [Interval];
    await viewer.row(layer).getByRole('button', { name: /visible/ }).click();
    await viewer.until('hidden', ({ intervals }) => !intervals[0]!.visible);
    await viewer.thumb(layer, 'upper').press('ArrowRight');
    await viewer.until('wider', ({ intervals }) => intervals[0]!.upper > layer.upper);
    const address = new URL(`api/v1/sessions/${viewer.sessionId}/intervals/${layer.id}`, stage.server.ready.url);
    address.search = new URL(stage.server.ready.url).search;
    const answer = await fetch(address, { method: 'PATCH', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ upper: layer.upper + 0.125, opacity: 0.75 }) });
    expect(answer.status).toBe(200);
    await viewer.until('the other’s', ({ intervals }) => intervals[0]!.opacity === 0.75);
    await undo();
    await expect.poll(() => viewer.page.getByText(/Not undone.*the range of Layer 1/).count()).toBe(1);
    await undo();
    await viewer.until('shown again', ({ intervals }) => intervals[0]!.visible);
    expect(viewer.state.intervals[0]).toMatchObject({ upper: layer.upper + 0.125, opacity: 0.75 });
  });

  test('a layer that somebody else deletes while one types in its field says what is lost; one at which nothing was typed goes without a word', async () => {
    await open();
    const [first, second] = (await viewer.layersOfOurOwn(2)) as [Interval, Interval];
    const remove = async (layer: Interval) => {
      const address = new URL(`api/v1/sessions/${viewer.sessionId}/intervals/${layer.id}`, stage.server.ready.url);
      address.search = new URL(stage.server.ready.url).search;
      expect((await fetch(address, { method: 'DELETE' })).status).toBeLessThan(300);
      await expect.poll(() => viewer.row(layer).count()).toBe(0);
    };
    const word = viewer.page.getByText(/Somebody else has deleted/);
    await viewer.row(second).getByLabel(/upper end/).focus();
    await remove(second);
    expect(await word.count()).toBe(0);
    await viewer.row(first).getByLabel(/upper end/).focus();
    await viewer.page.keyboard.type('0.7512');
    await remove(first);
    await viewer.page.getByText('Somebody else has deleted “Layer 1”. What you were typing there is lost: “0.7512”.').waitFor();
    await viewer.photograph('typed-and-lost.png');
    expect(await viewer.page.evaluate(() => document.activeElement?.id)).toBe('add-layer');
    expect(viewer.problems).toEqual([]);
  });

  test('in a text that is being typed the keys are the text’s', async () => {
    await open();
    const [layer] = (await viewer.layersOfOurOwn(1)) as [Interval];
    const upper = viewer.row(layer).getByLabel(/upper end/);
    await upper.fill(String(layer.upper + 0.01));
    await undo();
    await viewer.page.waitForTimeout(300);
    expect(viewer.state.intervals).toHaveLength(1); // the layer that was added last is there
    await upper.fill(String(layer.upper + 0.02));
    await upper.press('Enter');
    await viewer.until('typed', ({ intervals }) => intervals[0]!.upper > layer.upper);
    await undo();
    await viewer.until('back', ({ intervals }) => intervals[0]!.upper === layer.upper);
  });
});
