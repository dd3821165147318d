// A person plots values along a line between two places of the picture, and over the steps at one.
import { describe, expect, test } from 'vitest';
import { mkdtempSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { Server } from './server';
import { Stage } from './stage';
import { launch, nearest, Viewer } from './viewer';

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
    expect(await dock().innerText()).toContain('2 long');
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

  test('on a small screen the picture keeps half of the height beside a plot and its ends, and nothing is wider than the window', async () => {
    viewer = await stage.open({ width: 1280, height: 720 });
    await viewer.until('layers', (state) => state.intervals.length > 0);
    const there = nearest(await viewer.exactPicture(), true);
    await viewer.page.getByRole('button', { name: 'Line', exact: true }).click();
    for (const dx of [0, 12]) await viewport().click({ position: { x: there.x + dx, y: there.y } });
    await dock().getByRole('button', { name: 'Ends' }).click();
    await expect.poll(() => dock().getByRole('textbox').count()).toBe(6);
    for (const [width, height] of [[1280, 720], [375, 812]] as const) {
      await viewer.page.setViewportSize({ width, height });
      await expect.poll(async () => ((await viewport().boundingBox())!.height) / height).toBeGreaterThan(0.5);
      const right = await dock().getByRole('button').evaluateAll((all) => all.map((of) => of.getBoundingClientRect().right));
      expect(Math.max(...right)).toBeLessThanOrEqual(width);
      const length = dock().getByText(/ long · /);
      expect(await length.evaluate((of) => of.scrollWidth - of.clientWidth), 'what is cut off of the length').toBeLessThanOrEqual(0);
      // The plot comes before what lies below the window.
      const [curve, histogram] = await Promise.all([dock().boundingBox(), viewer.page.getByRole('region', { name: 'distance' }).boundingBox()]);
      expect(curve!.y).toBeLessThanOrEqual(histogram!.y);
    }
    expect(viewer.problems).toEqual([]);
  });

  test('an edge makes the plots taller, by pointer and by keys, as far as the picture keeps its room; a reload remembers it', async () => {
    viewer = await stage.open({ width: 1280, height: 720 });
    await viewer.until('layers', (state) => state.intervals.length > 0);
    const there = nearest(await viewer.exactPicture(), true);
    await viewer.page.getByRole('button', { name: 'Line', exact: true }).click();
    for (const dx of [0, 12]) await viewport().click({ position: { x: there.x + dx, y: there.y } });
    await expect.poll(() => plot().count()).toBe(1);
    const edge = viewer.page.getByRole('separator', { name: 'Height of the plots' });
    const histogram = viewer.page.getByRole('img', { name: 'Histogram of distance' });
    const heights = async () => [(await plot().boundingBox())!.height, (await histogram.boundingBox())!.height];
    const before = await heights();
    await viewer.drag(edge, 0, -80);
    const after = await heights();
    expect(after).toEqual(before.map((of) => of + 80));
    await viewer.photograph('taller-plots.png');
    await edge.press('ArrowUp');
    expect(await heights()).toEqual(after.map((of) => of + 16));
    await edge.press('ArrowDown');
    await viewer.page.reload();
    await viewer.exactPicture();
    await expect.poll(() => plot().count()).toBe(1);
    expect(await heights()).toEqual(after);
    await viewer.drag(edge, 0, -600);
    expect((await viewport().boundingBox())!.height).toBeGreaterThanOrEqual(200);
    await edge.press('Home');
    expect(await heights()).toEqual(before);
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

  test('the plot and the numbers of a layer are there again after a reload', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    const [layer] = await viewer.layersOfOurOwn(1);
    const there = nearest(await viewer.exactPicture(), true);
    await viewport().click({ position: there });
    await viewer.page.getByRole('button', { name: 'Line from here' }).click();
    await viewport().click({ position: { x: there.x, y: (await viewport().boundingBox())!.height - there.y } });
    await expect.poll(() => plot().count()).toBe(1);
    const numbers = () => viewer.page.getByRole('region', { name: 'Layer 1: statistics' }).locator('dd').allInnerTexts();
    await viewer.page.getByRole('button', { name: 'Layer 1: statistics' }).click();
    await expect.poll(async () => (await numbers()).length).toBeGreaterThan(4);
    const [line, measured] = [await saved(), await numbers()];
    expect(line.length).toBeGreaterThan(2);

    await viewer.page.reload();
    await expect.poll(() => plot().count()).toBe(1);
    expect(await saved()).toEqual(line);
    await expect.poll(numbers).toEqual(measured);
    expect(viewer.state.intervals[0]?.id).toBe(layer!.id);

    await dock().getByRole('button', { name: 'Close the plot' }).click();
    await viewer.page.reload();
    await expect.poll(numbers).toEqual(measured);
    expect(await dock().count()).toBe(0);
    expect(viewer.problems).toEqual([]);
  });

  test('while another array is read nothing stands under its name; if what reads is killed it is read again', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.page.getByLabel('Dataset').selectOption('cylinder-16x12x8x6');
    await viewer.until('the cylinder', (state) => state.dataset.startsWith('cylinder') && state.intervals.length > 0);
    await viewport().click({ position: nearest(await viewer.exactPicture(), true) });
    await viewer.page.getByRole('button', { name: 'Over time' }).click();
    await expect.poll(() => plot().count()).toBe(1);
    process.kill(stage.server.ready.worker!, 'SIGSTOP');
    await dock().getByRole('combobox', { name: 'Array of the plot' }).selectOption('Energy');
    await expect.poll(() => dock().innerText()).toContain('Reading all steps');
    expect(await plot().count()).toBe(0);
    process.kill(stage.server.ready.worker!, 'SIGKILL');
    await expect.poll(() => plot().count(), { timeout: 30_000 }).toBe(1);
    expect((await saved())[0]).toEqual(['step', 'time', 'Energy']);
    expect(viewer.problems).toEqual([]);
  });

  test('by keys alone: the keyboard goes to the plot that a button opens, and back to the picture', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.page.getByLabel('Dataset').selectOption('cylinder-16x12x8x6');
    await viewer.until('the cylinder', (state) => state.dataset.startsWith('cylinder') && state.intervals.length > 0);
    await viewer.exactPicture();
    const focused = () => viewer.page.evaluate(() => document.activeElement?.getAttribute('aria-label') ?? document.activeElement?.tagName);
    await viewport().focus();
    await viewer.page.keyboard.press('p'); // in the middle
    const over = viewer.page.getByRole('button', { name: 'Over time' });
    await over.waitFor();
    await over.focus();
    await viewer.page.keyboard.press('Enter');
    await expect.poll(focused).toBe('Values over time');
    await expect.poll(() => plot().count()).toBe(1);
    await dock().getByRole('button', { name: 'Close the plot' }).focus();
    await viewer.page.keyboard.press('Enter');
    await expect.poll(focused).toMatch(/^Picture of the layers/);
    const ask = viewer.page.getByRole('button', { name: /: statistics$/ }).first();
    const name = await ask.getAttribute('aria-label');
    await ask.focus();
    await viewer.page.keyboard.press('Enter');
    await expect.poll(focused).toBe(name); // of the numbers, which have the button's place
    await viewer.page.getByRole('button', { name: /: close the statistics$/ }).focus();
    await viewer.page.keyboard.press('Enter');
    await expect.poll(focused).toBe(name);
    expect(viewer.problems).toEqual([]);
  });
});

test('a curve follows files that grow and are read anew, and says that the grid is not the same at all steps', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-curve-'));
  const put = (name: string, scale: number, spacing = 1) => {
    const n = 16;
    const head = `NRRD0004\ntype: float\ndimension: 3\nsizes: ${n} ${n} ${n}\nspacings: ${spacing} ${spacing} ${spacing}\nencoding: raw\nendian: little\n\n`;
    const values = Float32Array.from({ length: n ** 3 }, (_, i) => scale * Math.hypot((i % n) - 7.5, (Math.floor(i / n) % n) - 7.5, Math.floor(i / n ** 2) - 7.5));
    writeFileSync(join(folder, '.new'), Buffer.concat([Buffer.from(head), Buffer.from(values.buffer)]));
    renameSync(join(folder, '.new'), join(folder, name));
  };
  put('run_1.nrrd', 1);
  put('run_2.nrrd', 1);
  const server = await Server.start({ data: [folder] });
  const browser = await launch();
  try {
    viewer = await Viewer.open(browser, server.ready.url);
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewport().click({ position: nearest(await viewer.exactPicture(), true) });
    await viewer.page.getByRole('button', { name: 'Over time' }).click();
    const steps = async () => (await saved()).slice(1).map(([step]) => step);
    await expect.poll(() => plot().count()).toBe(1);
    expect(await steps()).toEqual(['1', '2']);
    expect(await dock().innerText()).not.toContain('not the same');
    const [before] = (await saved()).slice(1).map(([, , value]) => Number(value));
    put('run_3.nrrd', 1, 1.5);
    await expect.poll(steps, { timeout: 20_000 }).toEqual(['1', '2', '3']);
    expect(await dock().innerText()).toContain('The grid is not the same at all steps');
    put('run_1.nrrd', 3);
    await viewer.page.getByRole('button', { name: 'Reload' }).click();
    await expect.poll(async () => Number((await saved())[1]?.[2]) / before!, { timeout: 20_000 }).toBeCloseTo(3, 4);
  } finally {
    await browser.close();
    await server.stop();
    rmSync(folder, { recursive: true, force: true });
  }
});
