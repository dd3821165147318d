// A view as a file: saved by the page, drawn by `isostrata render`, opened again by the page.
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { beforeAll, describe, expect, test } from 'vitest';
import type { Interval } from '../../web/src/lib/model';
import { binary, repository } from './server';
import { Stage } from './stage';
import { difference, drawnPixels, Viewer } from './viewer';

const stage = new Stage({ data: ['torus:48', 'cylinder:16x24x4x5'] });
let viewer: Viewer;
const folder = join(repository, 'build', 'e2e');

beforeAll(() => void mkdirSync(folder, { recursive: true }));

async function open(): Promise<void> {
  viewer = await stage.open();
  await viewer.until('layers', (state) => state.intervals.length > 0);
  await viewer.exactPicture();
}
async function save(name: string): Promise<string> {
  const [download] = await Promise.all([viewer.page.waitForEvent('download'), viewer.page.getByRole('button', { name: 'Save view' }).click()]);
  expect(download.suggestedFilename()).toMatch(/^torus.*\.isostrata\.json$/);
  const path = join(folder, name);
  await download.saveAs(path);
  return path;
}
const choose = (files: string | { name: string; mimeType: string; buffer: Buffer }) => viewer.page.locator('input[type=file]').setInputFiles(files);
const text = (name: string, content: string) => ({ name, mimeType: 'application/json', buffer: Buffer.from(content) });

/** A scene that is not the first one, of the torus. */
async function ownScene(): Promise<void> {
  const [layer] = (await viewer.layersOfOurOwn(2)) as [Interval];
  await viewer.row(layer).getByLabel('colour or colour map').selectOption(' function');
  await viewer.page.getByRole('button', { name: 'Add cut' }).click();
  await viewer.page.getByRole('button', { name: 'White' }).click();
  await viewer.drag(viewer.page.getByRole('application'), 90, 30);
  await viewer.until('all of it', (state) => state.clipPlanes?.length === 1 && state.background[0] === 1 && !!state.intervals[0]?.transfer);
}

describe('a view as a file', () => {
  test('is what render draws, and what comes back over another dataset, and over other layers of the same', async () => {
    await open();
    await ownScene();
    const picture = await viewer.exactPicture();
    const path = await save('saved.isostrata.json');
    const png = join(folder, 'saved-view.png');
    execFileSync(binary, ['render', 'torus:48', '--state', path, '--size', `${picture.width}x${picture.height}`, '--out', png]);
    expect(difference(picture, await viewer.pixels(readFileSync(png)))).toBe(0);

    const { dataset } = viewer.state;
    const other = await viewer.page.locator('#dataset option').evaluateAll((all, now) => all.map((o) => (o as HTMLOptionElement).value).find((id) => id !== now)!, dataset);
    await viewer.page.getByLabel('Dataset').selectOption(other);
    await viewer.until('another one', (state) => state.dataset === other && state.intervals.length > 0);
    await choose(path);
    await viewer.until('the view', (state) => state.dataset === dataset && state.clipPlanes?.length === 1);
    expect(difference(picture, await viewer.exactPicture())).toBe(0);
    await expect.poll(() => viewer.page.getByText('The view is opened.').count()).toBe(1);

    await viewer.layersOfOurOwn(1);
    await viewer.page.getByRole('radio', { name: 'Cycle' }).click();
    const before = await viewer.until('one layer', (state) => state.intervals.length === 1 && state.mode === 'cycled');
    await choose(path);
    await viewer.until('the view', (state) => state.intervals.length === 2 && !!state.intervals[0]?.transfer && state.mode === 'sorted');
    expect(difference(picture, await viewer.exactPicture())).toBe(0);
    await viewer.page.keyboard.press('Control+z');
    await viewer.until('what was there', (state) => state.intervals.length === 1 && state.intervals[0]?.lower === before.intervals[0]?.lower);
    expect(viewer.problems).toEqual([]);
  });

  test('can be dropped on the page', async () => {
    await open();
    await ownScene();
    const picture = await viewer.exactPicture();
    const content = readFileSync(await save('dropped.isostrata.json'), 'utf8');
    await viewer.close();
    await open();
    expect(difference(picture, await viewer.exactPicture())).toBeGreaterThan(0.5);
    const drop = (type: string) =>
      viewer.page.evaluate(([what, body]) => {
        const data = new DataTransfer();
        data.items.add(new File([body as string], 'dropped.isostrata.json', { type: 'application/json' }));
        document.querySelector('.stage')?.dispatchEvent(new DragEvent(what as string, { dataTransfer: data, bubbles: true, cancelable: true }));
      }, [type, content]);
    await drop('dragover');
    await expect.poll(() => viewer.page.getByText('Drop a saved view here').count()).toBe(1);
    await viewer.photograph('drop-a-view.png');
    await drop('drop');
    await viewer.until('the view', (state) => state.clipPlanes?.length === 1 && state.intervals.length === 2);
    expect(difference(picture, await viewer.exactPicture())).toBe(0);
    expect(await viewer.page.getByText('Drop a saved view here').count()).toBe(0);
  });

  test('what is none changes nothing, and the page says why', async () => {
    await open();
    const first = await viewer.exactPicture();
    const { revision, dataset, array } = viewer.state;
    const others: [ReturnType<typeof text>, RegExp][] = [
      [text('broken.json', '{"dataset":'), /“broken\.json” is not opened: it is no JSON/],
      [text('package.json', '{"name":"x"}'), /“package\.json” is not opened: it names no dataset/],
      [text('away.isostrata.json', JSON.stringify({ dataset: 'not-there', array: 'f' })), /This server does not have the dataset “not-there” of this view/],
      [text('array.isostrata.json', JSON.stringify({ dataset, array: 'not-there' })), /The dataset does not have the array “not-there” of this view/],
      [{ ...text('head.vti', '<VTKFile>'), mimeType: 'text/xml' }, /“head\.vti” is not opened: a view ends in \.isostrata\.json/],
    ];
    for (const [file, words] of others) {
      await choose(file);
      await expect.poll(() => viewer.page.getByRole('alert').getByText(words).count(), { message: file.name }).toBe(1);
    }
    await viewer.photograph('no-view.png');
    expect(viewer.state.revision).toBe(revision);
    expect(viewer.state.array).toBe(array);
    expect(difference(first, await viewer.exactPicture())).toBe(0);
    expect(drawnPixels(first)).toBeGreaterThan(100);
    expect(viewer.problems).toEqual([]);
  });
});
