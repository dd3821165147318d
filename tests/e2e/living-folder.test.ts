// A folder that changes while the page shows it: the list follows, the slider gains steps, a rewritten file waits for Reload, a deleted one is marked.
import { mkdirSync, mkdtempSync, renameSync, rmSync, unlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { expect, test } from 'vitest';
import type { DatasetInfo } from '../../web/src/lib/told';
import { Server } from './server';
import { launch, Viewer } from './viewer';

/** 24 x 24 x 24 distances from a point that moves with `at`, times `scale`, above `least`. */
function field(at: number, scale = 1, least = 0): Uint8Array {
  const n = 24;
  const head = `NRRD0004\ntype: float\ndimension: 3\nsizes: ${n} ${n} ${n}\nencoding: raw\nendian: little\n\n`;
  const values = new Float32Array(n * n * n);
  for (let k = 0; k < n; k++)
    for (let j = 0; j < n; j++)
      for (let i = 0; i < n; i++) values[(k * n + j) * n + i] = least + scale * Math.hypot(i - at, j - n / 2, k - n / 2);
  return Buffer.concat([Buffer.from(head), Buffer.from(values.buffer)]);
}

/** What the server said last of the open dataset. */
function infoOf(viewer: Viewer): DatasetInfo | undefined {
  const infos = viewer.events.flatMap((event) => (event.kind === 'datasetInfo' ? [event.info] : []));
  return infos[infos.length - 1];
}

test('the list, the time slider and the marks follow the files', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-living-'));
  /** As a careful program writes: complete under another name first. */
  const put = (name: string, bytes: Uint8Array | string) => {
    mkdirSync(dirname(join(folder, name)), { recursive: true });
    writeFileSync(join(folder, '.new'), bytes);
    renameSync(join(folder, '.new'), join(folder, name));
  };
  put('run_1.nrrd', field(6));
  put('run_2.nrrd', field(9));
  for (let i = 0; i < 150; i++) put(`many/file ${String.fromCharCode(97 + (i % 26))}${String.fromCharCode(97 + Math.floor(i / 26))}.nrrd`, field(i % 20).subarray(0, 200));
  put('notes.txt', 'text');
  put('reader.ts', "const first = '<VTKFile type=\"ImageData\">';");
  const server = await Server.start({ data: [folder] });
  const browser = await launch();
  try {
    const viewer = await Viewer.open(browser, server.ready.url, { width: 1280, height: 900 });
    const { page } = viewer;
    await page.getByLabel('Dataset', { exact: true }).selectOption({ label: 'run_*.nrrd' });
    await viewer.until('the series', (state) => state.dataset.startsWith('run'), 60_000);
    const slider = page.getByRole('slider', { name: 'Time', exact: true });
    expect(await slider.getAttribute('max')).toBe('1');

    await page.getByRole('button', { name: 'Browse…' }).click();
    const files = page.getByRole('region', { name: 'Files that are served' });
    await files.getByRole('button', { name: /^many\// }).waitFor();
    expect(await files.getByRole('button', { name: /run_\*\.nrrd/ }).textContent()).toMatch(/NRRD · 2 steps · 111 KB/);
    await files.getByRole('button', { name: '2 files were passed over' }).click();

    // A row has a small picture, as wide before it is there.
    const pictureOf = (name: RegExp) => files.getByRole('button', { name }).getByRole('img', { name: 'Its first view' });
    await pictureOf(/run_\*\.nrrd/).waitFor();
    expect(await pictureOf(/run_\*\.nrrd/).evaluate((img: HTMLImageElement) => [img.naturalWidth, img.naturalHeight, img.width, img.height])).toEqual([192, 144, 64, 48]);
    expect(await files.textContent()).toMatch(/a program or its settings.*reader\.ts/s);

    // A step comes: the list, the slider and a notice say so, and the picture stays.
    const before = viewer.state;
    put('run_3.nrrd', field(14));
    await files.getByRole('button', { name: /run_\*\.nrrd.*grown.*3 steps/ }).waitFor();
    await page.locator('#time-step[max="2"]').waitFor();
    await page.getByText('One more step has come.').waitFor();
    expect(viewer.state.revision).toBe(before.revision);
    await viewer.photograph('a-series-that-grew.png');
    await slider.fill('2');
    await viewer.until('the new step', (state) => state.step === 2);

    // A new file, by keys alone: its name, Enter.
    put('many/late.nrrd', field(3));
    await files.getByLabel('Search names').fill('LATE');
    await files.getByRole('button', { name: /many\/late\.nrrd.*new/ }).waitFor();
    await files.getByLabel('Search names').press('Enter');
    await viewer.until('the late file', (state) => state.dataset.startsWith('late') || state.dataset.startsWith('many-late'), 60_000);

    // It is rewritten: nothing moves until Reload, and then the layers are those that were there. Its small picture is of what is on the disk.
    await pictureOf(/many\/late\.nrrd/).waitFor();
    const pictured = await pictureOf(/many\/late\.nrrd/).getAttribute('src');
    const layers = JSON.stringify(viewer.state.intervals);
    const camera = JSON.stringify(viewer.state.camera);
    put('many/late.nrrd', field(20, 1.5));
    await page.getByText('This file has changed on the disk').waitFor();
    await expect.poll(() => pictureOf(/many\/late\.nrrd/).getAttribute('src')).not.toBe(pictured);
    const upper = infoOf(viewer)?.arrays[0]?.upper ?? NaN;
    await page.getByRole('button', { name: 'Reload' }).click();
    await page.getByText('This file has changed on the disk').waitFor({ state: 'hidden' });
    expect(JSON.stringify(viewer.state.intervals)).toBe(layers);
    expect(JSON.stringify(viewer.state.camera)).toBe(camera);
    expect(infoOf(viewer)?.arrays[0]?.upper).toBeCloseTo(1.5 * upper, 3);

    // The page says that the values are others, and fits the layers to them if it is told to.
    const fit = page.getByRole('button', { name: 'Fit layers to the new values' });
    expect(await page.getByText(/The values were .* and are .* now/).textContent()).toContain('The layers keep their ends.');
    await viewer.photograph('other-values.png');
    const old = viewer.state.intervals;
    await fit.click();
    await viewer.until('fitted layers', ({ intervals }) => intervals.every((now, i) => Math.abs(now.upper - 1.5 * old[i]!.upper) < 0.02 * now.upper));
    expect(await fit.count()).toBe(0);
    await page.getByRole('button', { name: /^Undo/ }).click();
    await viewer.until('the layers of before', ({ intervals }) => intervals.every((now, i) => now.upper === old[i]!.upper));

    // It is deleted: shown from memory, and marked.
    unlinkSync(join(folder, 'many', 'late.nrrd'));
    await page.getByText('This file is gone from the disk').waitFor();
    await files.getByRole('button', { name: /many\/late\.nrrd.*gone/ }).waitFor();
    await viewer.photograph('a-file-that-is-gone.png');

    // A large folder has as many elements as the page can use, however many files there are.
    await files.getByLabel('Search names').fill('');
    await files.getByRole('button', { name: /^many\// }).click();
    await expect.poll(() => files.getByRole('listitem').count()).toBe(100);
    await files.getByRole('button', { name: 'Later names' }).click();
    await expect.poll(() => files.getByRole('listitem').count()).toBe(51); // the one that is gone is listed yet
    expect(viewer.problems).toEqual([]);
  } finally {
    await browser.close();
    await server.stop();
    rmSync(folder, { recursive: true, force: true });
  }
});

test('a series is found by the number of one of its files, and opens at that step', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-numbers-'));
  for (let i = 0; i < 5; i++) writeFileSync(join(folder, `wave_${String(10 * i).padStart(4, '0')}.nrrd`), field(4 + 3 * i));
  writeFileSync(join(folder, 'alone.nrrd'), field(9));
  const server = await Server.start({ data: [folder] });
  const browser = await launch();
  try {
    const viewer = await Viewer.open(browser, server.ready.url, { width: 1280, height: 900 });
    const { page } = viewer;
    await viewer.until('the first', (state) => state.dataset.startsWith('alone') && state.intervals.length > 0);
    await page.getByRole('button', { name: 'Browse…' }).click();
    const files = page.getByRole('region', { name: 'Files that are served' });
    await files.getByLabel('Search names').fill('0030');
    await files.getByRole('button', { name: /wave_\*\.nrrd.*opens at step 4/ }).waitFor();
    await viewer.photograph('found-by-number.png');
    await files.getByLabel('Search names').press('Enter');
    const opened = await viewer.until('step 4', (state) => state.dataset.startsWith('wave') && state.step === 3);
    expect(opened.intervals.length).toBeGreaterThan(0);
    await viewer.exactPicture();
    // Of the dataset that is open another step is shown, and all else stays.
    await viewer.row(opened.intervals[0]!).getByRole('button', { name: /visible/ }).click();
    await viewer.until('hidden', ({ intervals }) => !intervals[0]!.visible);
    await files.getByLabel('Search names').fill('wave_0010.nrrd');
    await files.getByRole('button', { name: /opens at step 2/ }).click();
    const other = await viewer.until('step 2', (state) => state.step === 1);
    expect(other.intervals[0]!.visible).toBe(false);
    // Opened without a number it is as it was left.
    await page.getByLabel('Dataset', { exact: true }).selectOption({ label: 'alone.nrrd' });
    await viewer.until('the other', (state) => state.dataset.startsWith('alone'));
    await files.getByLabel('Search names').fill('wave');
    await files.getByRole('button', { name: /wave_/ }).click();
    const again = await viewer.until('as it was left', (state) => state.dataset.startsWith('wave') && state.step === 1 && state.intervals.length > 0 && !state.intervals[0]!.visible);
    expect(again.step).toBe(1);
    expect(viewer.problems).toEqual([]);
  } finally {
    await browser.close();
    await server.stop();
    rmSync(folder, { recursive: true, force: true });
  }
});

test('of a step whose values no layer holds the page says so, and fits the layers to them', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-beyond-'));
  writeFileSync(join(folder, 'jump_1.nrrd'), field(6));
  writeFileSync(join(folder, 'jump_2.nrrd'), field(6, 1, 1000));
  const server = await Server.start({ data: [folder] });
  const browser = await launch();
  try {
    const viewer = await Viewer.open(browser, server.ready.url, { width: 1280, height: 900 });
    const { page } = viewer;
    await viewer.until('layers', (state) => state.intervals.length > 0);
    const [layer] = await viewer.layersOfOurOwn(1);
    for (const [end, text] of [['lower', '2'], ['upper', '4']] as const) {
      const field = viewer.row(layer!).getByRole('textbox', { name: `${end} end` });
      await field.fill(text);
      await field.press('Enter');
    }
    await viewer.until('2 … 4', ({ intervals: [now] }) => now?.lower === 2 && now.upper === 4);
    const said = page.getByText('No layer holds a value of this step');
    const slider = page.getByRole('slider', { name: 'Time', exact: true });
    await slider.fill('0');
    await viewer.until('the first step', (state) => state.step === 0);
    await expect.poll(() => said.count()).toBe(0);
    await slider.fill('1');
    await said.waitFor();
    await viewer.photograph('no-value-of-this-step.png');
    await page.getByRole('button', { name: 'Fit layers to these values' }).click();
    await viewer.until('the layer among them', ({ intervals: [now] }) => !!now && now.lower >= 1000 && now.upper > now.lower);
    await said.waitFor({ state: 'detached' });
    await page.getByRole('button', { name: /^Undo/ }).click();
    await viewer.until('the layer of before', (state) => state.intervals[0]?.lower === 2);
    expect(viewer.problems).toEqual([]);
  } finally {
    await browser.close();
    await server.stop();
    rmSync(folder, { recursive: true, force: true });
  }
});
