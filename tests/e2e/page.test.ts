// The page in a real browser against a real server: what a person does, and what becomes of the picture.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, expect, test } from 'vitest';
import type { Interval } from '../../web/src/lib/model';
import { repository } from './server';
import { Stage } from './stage';
import { difference, drawnPixels, Viewer } from './viewer';

const stage = new Stage({ data: ['torus:48', 'sphere:24', 'cylinder:16x24x4x5'] });
let viewer: Viewer;

async function open(options: Parameters<typeof Viewer.open>[2] = {}): Promise<void> {
  viewer = await stage.open(options);
  await viewer.until('layers', (state) => state.intervals.length > 0);
  await viewer.exactPicture();
}
async function openWithLayers(count: number): Promise<Interval[]> {
  await open();
  const layers = await viewer.layersOfOurOwn(count);
  await viewer.exactPicture();
  return layers;
}
/** One broad layer in the middle of the range: a scene in which every edit can be seen. */
const openWithOneLayer = async () => (await openWithLayers(1))[0] as Interval;
const folder = () => {
  const path = join(repository, 'build', 'e2e');
  mkdirSync(path, { recursive: true });
  return path;
};
const focused = () => viewer.page.evaluate(() => document.activeElement?.id);
const only = () => viewer.state.intervals[0] as Interval;

describe('the page', () => {
  test('connects, shows a picture, asks nobody but its server, and takes the token out of sight', async () => {
    await open();
    const picture = await viewer.exactPicture();
    expect(drawnPixels(picture)).toBeGreaterThan(1000);
    expect(viewer.page.url()).not.toContain('token');
    const origin = new URL(stage.server.ready.url).origin;
    for (const url of viewer.requests) expect(url.startsWith(origin) || url.startsWith('blob:'), url).toBe(true);
    await expect.poll(() => viewer.page.locator('footer').innerText()).toMatch(/Connected.*exact/s);
    // Hexahedra are cut straight: the card says how far the volume may be off.
    await expect.poll(() => viewer.row(viewer.state.intervals[0]!).locator('.facts').innerText()).toMatch(/volume [\d.]+ ± [\d.]/);
    expect(viewer.problems).toEqual([]);
  });

  test('a picture that nobody touches becomes smooth, and again after it was turned', async () => {
    await open();
    const plain = await viewer.exactPicture();
    await viewer.close();
    await open({ refines: true });
    const smooth = async () => {
      await expect.poll(() => viewer.page.locator('canvas').getAttribute('data-samples'), { timeout: 20_000 }).toBe('4');
      return viewer.exactPicture();
    };
    const first = await smooth();
    const changed = difference(plain, first);
    expect(changed).toBeGreaterThan(0.01);
    expect(changed).toBeLessThan(3); // edges alone
    await viewer.photograph('smooth.png');
    await viewer.drag(viewer.page.getByRole('application'), 60, 20);
    expect(await viewer.page.locator('canvas').getAttribute('data-samples')).toBe('1');
    expect(difference(first, await smooth())).toBeGreaterThan(0.1);
    expect(viewer.problems).toEqual([]);
  });

  test('turns by dragging: box and axes at once, then the picture', async () => {
    await open();
    const before = await viewer.exactPicture();
    const camera = viewer.state.camera;
    const lines = () => viewer.page.locator('svg.overlay line.edge').first().getAttribute('x1');
    const line = await lines();
    const viewport = viewer.page.getByRole('application');
    await viewer.drag(viewport, 120, 40);
    expect(await lines()).not.toBe(line);
    await viewer.until('a turned camera', (state) => JSON.stringify(state.camera) !== JSON.stringify(camera));
    expect(difference(before, await viewer.exactPicture())).toBeGreaterThan(0.1);

    await viewport.dblclick({ position: { x: 30, y: 200 } });
    await viewer.until('the camera of before', (state) => JSON.stringify(state.camera) === JSON.stringify(camera));
    expect(difference(before, await viewer.exactPicture())).toBe(0);
  });

  test('draws its box where the server draws the data', async () => {
    // A layer that holds all values fills the box: its outline on the picture is the box’s outline in the overlay.
    await open();
    const first = viewer.state.dataset;
    await viewer.page.getByLabel('Dataset').selectOption({ index: 1 });
    await viewer.until('the other dataset', (state) => state.dataset !== first && state.intervals.length > 0);
    const [layer] = (await viewer.layersOfOurOwn(1)) as [Interval];
    const least = Number(await viewer.thumb(layer, 'lower').getAttribute('aria-valuemin'));
    const most = Number(await viewer.thumb(layer, 'upper').getAttribute('aria-valuemax'));
    await viewer.thumb(layer, 'lower').press('Home');
    await viewer.thumb(layer, 'upper').press('End');
    await viewer.until('all values', ({ intervals }) => intervals[0]?.lower === least && intervals[0].upper === most);
    const plus = () => viewer.page.getByRole('button', { name: 'View from +z' }).click();
    const turn = () => viewer.drag(viewer.page.getByRole('application'), 110, 60);
    for (const [side, look] of [['+z', plus], ['turned', turn]] as const) {
      const { revision } = viewer.state;
      await look();
      await viewer.until(`the view ${side}`, (state) => state.revision > revision);
      const { width, height, pixels } = await viewer.exactPicture();
      let [left, right, top, bottom] = [width, 0, height, 0];
      for (let y = 0; y < height; y++)
        for (let x = 0; x < width; x++) {
          const i = (y * width + x) * 4;
          if (![0, 1, 2].some((c) => Math.abs((pixels[i + c] as number) - (pixels[c] as number)) > 3)) continue;
          left = Math.min(left, x);
          right = Math.max(right, x + 1);
          top = Math.min(top, y);
          bottom = Math.max(bottom, y + 1);
        }
      const edges = await viewer.page.locator('svg.overlay line.edge').evaluateAll((lines) =>
        lines.map((line) => ['x1', 'y1', 'x2', 'y2'].map((name) => Number(line.getAttribute(name)))),
      );
      const xs = edges.flatMap(([x1, , x2]) => [x1 as number, x2 as number]);
      const ys = edges.flatMap(([, y1, , y2]) => [y1 as number, y2 as number]);
      const tolerance = 4;
      expect(Math.abs(left - Math.min(...xs)), `${side}: left`).toBeLessThan(tolerance);
      expect(Math.abs(right - Math.max(...xs)), `${side}: right`).toBeLessThan(tolerance);
      expect(Math.abs(top - Math.min(...ys)), `${side}: top`).toBeLessThan(tolerance);
      expect(Math.abs(bottom - Math.max(...ys)), `${side}: bottom`).toBeLessThan(tolerance);
    }
  });
});

describe('a layer', () => {
  test('is resized by dragging an end: the numbers follow and the picture changes', async () => {
    const interval = await openWithOneLayer();
    const before = await viewer.exactPicture();
    await viewer.drag(viewer.thumb(interval, 'upper'), 60, 0);
    await viewer.until('a higher upper end', (s) => (s.intervals[0]?.upper ?? 0) > interval.upper);
    const shown = async () => Number(await viewer.thumb(interval, 'upper').getAttribute('aria-valuenow'));
    await expect.poll(async () => (await shown()) === only().upper).toBe(true);
    expect(only().lower).toBe(interval.lower);
    expect(difference(before, await viewer.exactPicture())).toBeGreaterThan(0.1);
  });

  test('is moved by dragging its body, and put back by Escape', async () => {
    const interval = await openWithOneLayer();
    await viewer.drag(viewer.page.locator('.band'), -50, 0);
    await viewer.until('a lower place', (s) => (s.intervals[0]?.lower ?? 9) < interval.lower);
    await viewer.exactPicture(); // at rest
    const moved = only();
    expect(moved.upper - moved.lower).toBeCloseTo(interval.upper - interval.lower, 9);
    const box = (await viewer.page.locator('.band').boundingBox()) as { x: number; y: number; width: number; height: number };
    await viewer.page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await viewer.page.mouse.down();
    await viewer.page.mouse.move(box.x + box.width / 2 + 40, box.y + 20, { steps: 4 });
    await viewer.until('it moving', (s) => s.intervals[0]?.lower !== moved.lower);
    await viewer.page.keyboard.press('Escape');
    await viewer.page.mouse.up();
    await viewer.until('it back', (s) => s.intervals[0]?.lower === moved.lower && s.intervals[0]?.upper === moved.upper);
  });

  test('is added by drawing on the empty histogram', async () => {
    const interval = await openWithOneLayer();
    const plot = (await viewer.page.locator('.plot').boundingBox()) as { x: number; y: number; width: number; height: number };
    await viewer.dragFrom(plot.x + plot.width * 0.05, plot.y + 60, plot.width * 0.15, 0);
    const state = await viewer.until('two layers', (s) => s.intervals.length === 2);
    expect(state.intervals[0]?.id).toBe(interval.id);
    const added = state.intervals[1] as Interval;
    expect(added.upper).toBeLessThan(interval.lower);
    expect(await viewer.page.locator('[data-layer]').count()).toBe(2);
  });

  test('takes typed numbers exactly, and says beside the field what cannot be taken', async () => {
    const interval = await openWithOneLayer();
    const upper = viewer.row(interval).getByRole('textbox', { name: /upper end/ });
    const exact = interval.upper - (interval.upper - interval.lower) * 0.123456789;
    await upper.fill(String(exact));
    await upper.press('Enter');
    await viewer.until('the typed number', (s) => s.intervals[0]?.upper === exact);
    expect(await upper.inputValue()).toBe(String(exact)); // all of it, as long as it is focused
    await upper.fill('-100');
    await upper.press('Enter');
    const alert = viewer.row(interval).getByRole('alert');
    await expect.poll(() => alert.innerText()).toContain('greater than');
    expect(await upper.getAttribute('aria-invalid')).toBe('true');
    expect(only().upper).toBe(exact);
    await upper.press('Escape');
    expect(await alert.count()).toBe(0);
    // What could not be taken goes when the end becomes another one elsewhere.
    await upper.fill('abc');
    await viewer.thumb(interval, 'upper').press('ArrowLeft');
    await viewer.until('another end', (s) => s.intervals[0]?.upper !== exact);
    await expect.poll(() => upper.inputValue()).not.toBe('abc');
    expect(await alert.count()).toBe(0);
  });

  test('is moved by keys: arrows, page keys, Home and End on each thumb', async () => {
    const interval = await openWithOneLayer();
    const lower = viewer.thumb(interval, 'lower');
    await lower.focus();
    await viewer.page.keyboard.press('ArrowRight');
    const once = await viewer.until('a step up', (s) => (s.intervals[0]?.lower ?? 0) > interval.lower);
    await viewer.page.keyboard.press('PageDown');
    await viewer.until('a page down', (s) => (s.intervals[0]?.lower ?? 0) < (once.intervals[0]?.lower ?? 0));
    await viewer.page.keyboard.press('Home');
    const least = Number(await lower.getAttribute('aria-valuemin'));
    await viewer.until('the least value', (s) => s.intervals[0]?.lower === least);
    expect(only().upper).toBe(interval.upper);
  });

  test('is recoloured, made thinner, hidden and deleted', async () => {
    const interval = await openWithOneLayer();
    const before = await viewer.exactPicture();
    await viewer.row(interval).locator('input[type=color]').fill('#00ffff');
    await viewer.until('cyan', (s) => s.intervals[0]?.color[0] === 0 && s.intervals[0].color[2] === 1);
    const cyan = await viewer.exactPicture();
    expect(difference(before, cyan)).toBeGreaterThan(0.1);

    await viewer.row(interval).getByRole('slider', { name: /opacity/ }).fill('0.05');
    await viewer.until('thin', (s) => Math.abs((s.intervals[0]?.opacity ?? 1) - 0.05) < 1e-6);
    expect(drawnPixels(await viewer.exactPicture())).toBeGreaterThan(0);
    expect(difference(cyan, await viewer.exactPicture())).toBeGreaterThan(0.1);

    await viewer.row(interval).getByRole('button', { name: /visible/ }).click();
    await viewer.until('hidden', (s) => s.intervals[0]?.visible === false);
    expect(drawnPixels(await viewer.exactPicture())).toBe(0);

    await viewer.thumb(interval, 'lower').focus();
    await viewer.page.keyboard.press('Delete');
    await viewer.until('no layer', (s) => s.intervals.length === 0);
    expect(await viewer.page.locator('.band').count()).toBe(0);
    expect(await focused()).toBe('add-layer');
  });

  test('is named, and its controls with it', async () => {
    const interval = await openWithOneLayer();
    const field = viewer.row(interval).getByRole('textbox', { name: 'Layer 1: name' });
    await field.fill('warm core');
    await field.press('Enter');
    await viewer.until('the name', (s) => s.intervals[0]?.name === 'warm core');
    await viewer.row(interval).getByRole('button', { name: 'warm core: visible' }).waitFor();
    await viewer.photograph('layer-name.png');
    await field.fill('');
    await field.press('Enter');
    await viewer.until('no name', (s) => s.intervals[0]?.name === '');
    await viewer.row(interval).getByRole('button', { name: 'Layer 1: visible' }).waitFor();
  });

  test('takes its colours from a colour map', async () => {
    const interval = await openWithOneLayer();
    const before = await viewer.exactPicture();
    await viewer.row(interval).getByRole('combobox').selectOption('viridis');
    await viewer.until('the map', (s) => s.intervals[0]?.colorMap === 'viridis');
    expect(difference(before, await viewer.exactPicture())).toBeGreaterThan(0.1);
  });
});

describe('names and colours', () => {
  test('belong to their layers: a deleted one takes its own along, and a new one takes what is free', async () => {
    await openWithLayers(3);
    const rows = () =>
      viewer.page.locator('[data-layer]').evaluateAll((list) =>
        list.map((row) => ({
          id: (row as HTMLElement).dataset.layer,
          name: row.querySelector<HTMLInputElement>('.name')?.placeholder,
          color: row.querySelector<HTMLInputElement>('input[type=color]')?.value,
        })),
      );
    const before = await rows();
    expect(before.map(({ name }) => name)).toContain('Layer 1');
    const first = before.find(({ name }) => name === 'Layer 1');
    const others = before.filter(({ name }) => name !== 'Layer 1');
    await viewer.page.getByRole('button', { name: 'Layer 1: delete' }).click();
    await expect.poll(rows).toEqual(others);
    await viewer.until('it gone', (s) => s.intervals.length === others.length);
    await viewer.page.getByRole('button', { name: 'Add layer' }).click();
    await expect.poll(async () => (await rows()).length).toBe(before.length);
    const added = (await rows()).find(({ id }) => !before.some((row) => row.id === id));
    expect(added).toMatchObject({ name: 'Layer 1', color: first?.color });
    await viewer.page.reload();
    await expect.poll(rows).toEqual([added, ...others]);
  });
});

describe('priorities', () => {
  test('are reordered by keyboard, and paint the picture', async () => {
    await openWithLayers(4);
    await viewer.page.getByRole('radio', { name: 'Priority' }).click();
    await viewer.until('priority mode', (state) => state.mode === 'prioritized');
    for (const interval of viewer.state.intervals)
      await viewer.row(interval).getByRole('slider', { name: /opacity/ }).fill('0.9');
    await viewer.until('dense layers', (s) => s.intervals.every((i) => Math.abs(i.opacity - 0.9) < 1e-6));
    const before = await viewer.exactPicture();
    const rows = () => viewer.page.locator('[data-layer]').evaluateAll((list) => list.map((row) => (row as HTMLElement).dataset.layer));
    const order = await rows();
    expect(order.length).toBeGreaterThan(2);

    // Alt+Arrow: the top layer goes one down, and the focus with it.
    const grip = viewer.page.locator(`[data-grip="${order[0]}"]`);
    await grip.focus();
    await viewer.page.keyboard.press('Alt+ArrowDown');
    await expect.poll(rows).toEqual([order[1], order[0], ...order.slice(2)]);
    // Space lifts it, arrows carry it to the bottom, Space puts it down.
    await expect.poll(() => grip.evaluate((element) => element === document.activeElement)).toBe(true);
    await viewer.page.keyboard.press('Space');
    for (let i = 2; i < order.length; i++) {
      await viewer.page.keyboard.press('ArrowDown');
      await expect.poll(async () => (await rows()).indexOf(order[0])).toBe(i);
      await expect.poll(() => grip.evaluate((element) => element === document.activeElement)).toBe(true);
    }
    await viewer.page.keyboard.press('Space');
    const state = await viewer.until('the lowest priority', (s) => {
      const mine = s.intervals.find((i) => String(i.id) === order[0]);
      return mine !== undefined && s.intervals.every((i) => i.id === mine.id || i.priority > mine.priority);
    });
    expect(state.mode).toBe('prioritized');
    expect(difference(before, await viewer.exactPicture())).toBeGreaterThan(0.1);
  });

  test('are reordered by dragging a grip', async () => {
    await openWithLayers(4);
    const rows = () => viewer.page.locator('[data-layer]').evaluateAll((list) => list.map((row) => (row as HTMLElement).dataset.layer));
    const order = await rows();
    const last = viewer.page.locator(`[data-grip="${order[order.length - 1]}"]`);
    await last.scrollIntoViewIfNeeded();
    const first = (await viewer.page.locator(`[data-grip="${order[0]}"]`).boundingBox()) as { y: number };
    const from = (await last.boundingBox()) as { y: number };
    await viewer.drag(last, 0, first.y - from.y - 10);
    await viewer.until('the highest priority', (s) => {
      const mine = s.intervals.find((i) => String(i.id) === order[order.length - 1]);
      return mine !== undefined && s.intervals.every((i) => i.id === mine.id || i.priority < mine.priority);
    });
    expect(await rows()).toEqual([order[order.length - 1], ...order.slice(0, -1)]);
  });
});

describe('the rest of the page', () => {
  test('changes the background and the unit distance', async () => {
    await openWithOneLayer();
    const before = await viewer.exactPicture();
    await viewer.page.getByRole('button', { name: 'White' }).click();
    await viewer.until('a white background', (s) => s.background.every((c) => c === 1));
    const white = await viewer.exactPicture();
    expect([...white.pixels.subarray(0, 3)]).toEqual([255, 255, 255]);
    expect(difference(before, white)).toBeGreaterThan(50);
    await viewer.page.getByLabel('Unit distance', { exact: true }).fill('-2.5');
    await viewer.until('a unit distance', (s) => s.unitDistance > 0);
    expect(difference(white, await viewer.exactPicture())).toBeGreaterThan(0.1);
  });

  test('lights the picture and turns that off again', async () => {
    await openWithOneLayer();
    const plain = await viewer.exactPicture();
    for (const [label, field] of [['Occlusion', 'occlusion'], ['Depth fade', 'depthFade'], ['Body shading', 'bodyShading']] as const) {
      await viewer.page.getByLabel(label, { exact: true }).fill('1');
      await viewer.until(label, (s) => s[field] === 1);
      const lit = await viewer.exactPicture();
      expect(difference(plain, lit)).toBeGreaterThan(0.1);
      await viewer.page.getByLabel(label, { exact: true }).fill('0');
      await viewer.until(`no ${label}`, (s) => s[field] === 0);
      expect(difference(plain, await viewer.exactPicture())).toBe(0);
    }
  });

  test('draws an axis longer and as the file has it again', async () => {
    await openWithOneLayer();
    const plain = await viewer.exactPicture();
    const field = viewer.page.getByLabel('Scale of z', { exact: true });
    await field.fill('-3');
    await field.press('Enter');
    expect(await viewer.page.getByText('"-3" is not a scale; expected a number above 0').isVisible()).toBe(true);
    await field.fill('4');
    await field.press('Enter');
    await viewer.until('an axis four times as long', (s) => s.axisScale?.[2] === 4);
    expect(difference(plain, await viewer.exactPicture())).toBeGreaterThan(0.5);
    expect(await viewer.page.locator('svg.overlay text.name').allTextContents()).toContain('z ×4');
    await viewer.page.getByRole('button', { name: 'Axis scale: as the file has it' }).click();
    await viewer.until('axes as they are', (s) => s.axisScale?.[2] === 1);
    await viewer.page.getByRole('button', { name: 'Reset' }).click();
    await viewer.until('the camera of before', (s) => s.camera !== null);
    expect(difference(plain, await viewer.exactPicture())).toBeLessThan(0.01);
  });

  test('steps through time where there is more than one step', async () => {
    await open();
    expect(await viewer.page.getByLabel('Time', { exact: true }).count()).toBe(0);
    await viewer.page.getByLabel('Dataset').selectOption('cylinder-16x24x4x5');
    await viewer.until('the cylinder', (s) => s.dataset.startsWith('cylinder') && s.intervals.length > 0);
    const slider = viewer.page.getByLabel('Time', { exact: true });
    await slider.focus();
    await viewer.page.keyboard.press('Home');
    await viewer.until('the first step', (s) => s.step === 0);
    const before = await viewer.exactPicture();
    await viewer.page.keyboard.press('ArrowRight');
    await viewer.page.getByRole('button', { name: 'Step on' }).click();
    await viewer.until('the third step', (s) => s.step === 2);
    expect(await slider.getAttribute('aria-valuetext')).toContain('step 3 of 5');
    expect(difference(before, await viewer.exactPicture())).toBeGreaterThan(0.05);

    const between = viewer.page.getByLabel('Between steps');
    await between.selectOption('interpolate');
    await viewer.until('a field between steps', (s) => s.timeMode === 'interpolate');
    await between.selectOption('step');
    await viewer.until('steps alone', (s) => s.timeMode === 'step' && s.step === 2);
    await viewer.page.getByRole('button', { name: 'Step on' }).press('Enter');
    await viewer.page.getByRole('button', { name: 'Step on' }).press('Enter');
    await viewer.until('the last step', (s) => s.step === 4);
    expect(await focused()).toBe('time-step');
  });

  test('plays a series: each step is in a picture before the next is asked for', async () => {
    await open();
    await viewer.page.getByLabel('Dataset').selectOption('cylinder-16x24x4x5');
    await viewer.until('the cylinder', (s) => s.dataset.startsWith('cylinder') && s.intervals.length > 0);
    await viewer.page.getByLabel('Time', { exact: true }).focus();
    await viewer.page.keyboard.press('Home');
    await viewer.until('the first step', (s) => s.step === 0);
    const before = viewer.events.length;
    await viewer.page.getByRole('button', { name: 'Play' }).click();
    const steps = () => {
      const seen: number[] = [];
      for (const event of viewer.events.slice(before)) if (event.kind === 'state' && event.state.step !== (seen.at(-1) ?? 0)) seen.push(event.state.step);
      return seen;
    };
    await expect.poll(() => steps().length, { timeout: 20_000 }).toBeGreaterThan(6);
    await viewer.page.getByRole('button', { name: 'Pause' }).click();
    const played = steps();
    expect(played).toEqual(played.map((_, i) => (i + 1) % 5));
    let revision = -1;
    let asked = -1;
    for (const event of viewer.events.slice(before)) {
      if (event.kind === 'frame') revision = Math.max(revision, event.frame.revision);
      if (event.kind !== 'state') continue;
      expect(asked === -1 || revision >= asked).toBe(true);
      asked = event.state.revision;
    }
    await viewer.exactPicture();
  });

  test('opens another dataset by a choice in the list, not by an arrow key on the closed one', async () => {
    await open();
    const { dataset } = viewer.state;
    await viewer.page.getByLabel('Dataset').focus();
    await viewer.page.keyboard.press('ArrowDown'); // the list opens
    await viewer.page.waitForTimeout(500);
    expect(viewer.state.dataset).toBe(dataset);
    await viewer.page.keyboard.press('ArrowDown');
    await viewer.page.keyboard.press('Enter');
    await viewer.until('the next dataset', (s) => s.dataset !== dataset && s.intervals.length > 0);
  });

  test('changes the array: axis, histogram and layers follow', async () => {
    await open();
    await viewer.page.getByLabel('Dataset').selectOption('cylinder-16x24x4x5');
    await viewer.until('the cylinder', (s) => s.dataset.startsWith('cylinder') && s.intervals.length > 0);
    const { array } = viewer.state;
    const names = await viewer.page.getByLabel('Layers of').locator('option').evaluateAll((list) => list.map((o) => (o as HTMLOptionElement).value));
    const other = names.find((name) => name !== array) as string;
    await viewer.page.getByLabel('Layers of').selectOption(other);
    await viewer.until('the other array', (s) => s.array === other);
    await expect.poll(() => viewer.events.some((e) => e.kind === 'histogram' && e.histogram.array === other)).toBe(true);
    await expect.poll(() => viewer.page.getByRole('heading', { name: other }).count()).toBe(1);
    await expect.poll(() => viewer.page.locator('path.bars').getAttribute('d')).not.toBe('');
    await viewer.exactPicture();
  });

  test('saves the exact picture as a PNG with what stands beside it, as large as one likes', async () => {
    await open();
    const picture = await viewer.exactPicture();
    const { page } = viewer;
    const save = async (name: string) => {
      const coming = page.waitForEvent('download');
      await page.getByRole('button', { name, exact: true }).click();
      const download = await coming;
      expect(download.suggestedFilename()).toMatch(/^isostrata-.*\.png$/);
      const bytes = readFileSync(await download.path());
      expect(bytes.subarray(1, 4).toString('latin1')).toBe('PNG');
      return { bytes, size: [bytes.readUInt32BE(16), bytes.readUInt32BE(20)] };
    };
    const frames = () => viewer.events.filter((event) => event.kind === 'frame' && event.frame.inReplyTo === 0).length;
    const before = frames();
    const shown = await save('Screenshot');
    expect(shown.size).toEqual([picture.width, picture.height]);
    writeFileSync(join(folder(), 'screenshot.png'), shown.bytes);
    // Without axes, box and legend it is the picture on the screen; with them it is not.
    const pixels = (bytes: Buffer) => viewer.pixels(bytes);
    expect(difference(picture, await pixels(shown.bytes))).toBeGreaterThan(0.2);
    await page.getByRole('button', { name: 'Screenshot: size and contents, films' }).click();
    for (const what of ['axes', 'box', 'legend']) await page.getByRole('checkbox', { name: what, exact: true }).uncheck();
    expect(difference(picture, await pixels((await save('Save PNG')).bytes))).toBe(0);

    await page.getByRole('button', { name: 'Screenshot: size and contents, films' }).click();
    await page.getByRole('radio', { name: 'twice that' }).check();
    expect((await save('Save PNG')).size).toEqual([2 * picture.width, 2 * picture.height]);
    await page.getByRole('button', { name: 'Screenshot: size and contents, films' }).click();
    const typed = page.getByRole('textbox', { name: 'Width x height in pixels' });
    await typed.fill('99999x1');
    expect(await page.getByRole('button', { name: 'Save PNG' }).isDisabled()).toBe(true);
    await typed.fill('301 x 200');
    await viewer.photograph('screenshot-panel.png');
    const opaque = await save('Save PNG');
    expect(opaque.size).toEqual([301, 200]);
    // Without the background, and laid over it, it is the same.
    await page.getByRole('button', { name: 'Screenshot: size and contents, films' }).click();
    await page.getByRole('checkbox', { name: 'background', exact: true }).uncheck();
    const [clear, whole] = [await pixels((await save('Save PNG')).bytes), await pixels(opaque.bytes)];
    expect(clear.pixels[3]).toBe(0);
    expect(whole.pixels[3]).toBe(255);
    const { background } = viewer.state;
    const laid = clear.pixels.map((value, i) => (i % 4 === 3 ? 255 : Math.round((value * (clear.pixels[i | 3] as number)) / 255 + 255 * (background[i % 4] as number) * (1 - (clear.pixels[i | 3] as number) / 255))));
    expect(difference(whole, { ...whole, pixels: laid })).toBeLessThan(0.6);
    expect(difference(whole, clear)).toBeGreaterThan(5);
    expect(frames(), 'what is for keeping is not shown').toBe(before);
    expect(difference(picture, await viewer.exactPicture())).toBe(0);
    expect(viewer.problems).toEqual([]);
  });

  test('keeps its session over a reload', async () => {
    const interval = await openWithOneLayer();
    const session = viewer.sessionId;
    for (const welcomes of [2, 3, 4]) {
      await viewer.page.reload(); // from the second on the browser asks whether the page has changed
      await expect.poll(() => viewer.events.filter((e) => e.kind === 'welcome').length).toBe(welcomes);
    }
    expect(viewer.sessionId).toBe(session);
    await expect.poll(() => viewer.page.locator('[data-layer]').count()).toBe(1);
    expect(only().id).toBe(interval.id);
    await viewer.exactPicture();
  });

  for (const colorScheme of ['dark', 'light'] as const)
    test(`stays where it is under a wheel over the histogram, ${colorScheme}`, async () => {
      await open({ width: 1100, height: 620, colorScheme });
      const top = () => viewer.page.locator('header.top').evaluate((element) => element.getBoundingClientRect().top);
      const plot = (await viewer.page.locator('.plot').boundingBox()) as { x: number; y: number; width: number; height: number };
      for (const [x, y] of [[plot.x + plot.width / 2, plot.y + 40], [1000, 300]] as const) {
        await viewer.page.mouse.move(x, y);
        for (let i = 0; i < 20; i++) await viewer.page.mouse.wheel(0, 200);
        await viewer.page.waitForTimeout(300);
        expect(await top()).toBe(0);
      }
      const { scroll, room } = await viewer.page.evaluate(() => ({ scroll: document.documentElement.scrollHeight, room: window.innerHeight }));
      expect(scroll).toBe(room);
      await viewer.photograph(`wheel-${colorScheme}.png`);
      // The settings did scroll, under their own wheel.
      expect(await viewer.page.locator('aside.panel').evaluate((element) => element.scrollTop)).toBeGreaterThan(50);
    });

  test('fits a narrow window, in light colours, without a sideways scroll', async () => {
    await open({ width: 390, height: 800, colorScheme: 'light' });
    const overflow = await viewer.page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    expect(overflow).toBeLessThanOrEqual(0);
    const ground = await viewer.page.evaluate(() => getComputedStyle(document.querySelector('header') as Element).backgroundColor);
    expect(Number(/\d+/.exec(ground)?.[0])).toBeGreaterThan(200);
    await viewer.photograph('narrow-light.png');
    await viewer.page.getByRole('button', { name: /^Share/ }).click();
    const share = await viewer.page.locator('#share-panel').boundingBox();
    expect(share && share.x >= 0 && share.x + share.width <= 390).toBe(true);
    await viewer.page.keyboard.press('Escape');
    await viewer.page.mouse.move(200, 750); // over the settings
    await viewer.page.mouse.wheel(0, 300);
    await expect.poll(() => viewer.page.evaluate(() => window.scrollY)).toBeGreaterThan(100);
  });

  test('keeps every button of a layer in sight, however long its facts are', async () => {
    await open();
    await expect.poll(async () => (await viewer.page.locator('.row .facts').allInnerTexts()).join(), { timeout: 20_000 }).toMatch(/±/); // comes after the picture at rest
    for (const interval of viewer.state.intervals) {
      const box = await viewer.row(interval).getByRole('button', { name: /delete/ }).boundingBox();
      expect((box?.x ?? Infinity) + (box?.width ?? 0)).toBeLessThanOrEqual(1100);
    }
  });

  test('gives every control a name', async () => {
    await open();
    const nameless = await viewer.page.evaluate(() =>
      [...document.querySelectorAll<HTMLElement>('button, input, select, [role=slider]')]
        .filter((element) => {
          const labels = (element as HTMLInputElement).labels;
          return !(element.getAttribute('aria-label') || element.textContent?.trim() || (labels && labels.length > 0));
        })
        .map((element) => element.outerHTML.slice(0, 120)),
    );
    expect(nameless).toEqual([]);
    for (const thumb of await viewer.page.getByRole('slider').all()) {
      const [least, now, most] = await thumb.evaluate((element) =>
        element instanceof HTMLInputElement
          ? [element.min, element.value, element.max].map(Number)
          : ['aria-valuemin', 'aria-valuenow', 'aria-valuemax'].map((name) => Number(element.getAttribute(name))),
      );
      expect(least as number).toBeLessThanOrEqual(now as number);
      expect(now as number).toBeLessThanOrEqual(most as number);
    }
  });
});
