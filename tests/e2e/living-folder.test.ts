// A folder that changes while the page shows it: the list follows, the slider gains steps, a rewritten file waits for Reload, a deleted one is marked.
import { mkdirSync, mkdtempSync, renameSync, rmSync, unlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { expect, test } from 'vitest';
import type { DatasetInfo } from '../../web/src/lib/told';
import { Server } from './server';
import { launch, Viewer } from './viewer';

/** 24 x 24 x 24 distances from a point that moves with `at`, times `scale`. */
function field(at: number, scale = 1): Uint8Array {
  const n = 24;
  const head = `NRRD0004\ntype: float\ndimension: 3\nsizes: ${n} ${n} ${n}\nencoding: raw\nendian: little\n\n`;
  const values = new Float32Array(n * n * n);
  for (let k = 0; k < n; k++)
    for (let j = 0; j < n; j++)
      for (let i = 0; i < n; i++) values[(k * n + j) * n + i] = scale * Math.hypot(i - at, j - n / 2, k - n / 2);
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
