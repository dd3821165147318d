// A person has a film made: of a turn, and of the steps of a series.
import { readFileSync } from 'node:fs';
import type { Page } from 'playwright-core';
import { expect, test } from 'vitest';
import { Server } from './server';
import { Stage } from './stage';
import { difference, drawnPixels, Viewer, type Picture } from './viewer';

const stage = new Stage({ data: ['torus:32', 'cylinder:24x24x12x5'] });
const form = (viewer: Viewer) => viewer.page.getByRole('group', { name: 'Film' });
const open = (viewer: Viewer) => viewer.page.getByRole('button', { name: 'Screenshot: size and contents, films' }).click();
const field = (viewer: Viewer, name: string) => form(viewer).getByRole('textbox', { name });

async function shown(dataset = ''): Promise<Viewer> {
  const viewer = await stage.open();
  await viewer.until('layers', (state) => state.intervals.length > 0);
  if (dataset) {
    await viewer.page.getByLabel('Dataset').selectOption(dataset);
    await viewer.until(dataset, (state) => state.dataset === dataset && state.intervals.length > 0);
  }
  await viewer.exactPicture();
  return viewer;
}
/** As large as a film of a test had better be. */
async function small(viewer: Viewer): Promise<void> {
  await viewer.page.getByRole('textbox', { name: 'Width x height in pixels' }).fill('320x240');
}
async function made(viewer: Viewer): Promise<{ name: string; bytes: Buffer }> {
  const download = viewer.page.waitForEvent('download');
  await form(viewer).getByRole('button', { name: 'Make film' }).click();
  return { name: (await download).suggestedFilename(), bytes: readFileSync(await (await download).path()) };
}
/** As a browser plays it: how long it is, and its pictures at some times. */
async function played(viewer: Viewer, film: Buffer, times: number[]): Promise<{ duration: number; pictures: Picture[] }> {
  const page: Page = await viewer.page.context().newPage(); // that of the server does not let films in
  await page.setContent('<video muted></video>');
  const { duration, width, height, pictures } = await page.evaluate(
    async ({ data, at }) => {
      const video = document.querySelector('video') as HTMLVideoElement;
      const heard = (name: string) =>
        new Promise<void>((done, fail) => {
          video.addEventListener(name, () => done(), { once: true });
          video.onerror = () => fail(new Error(video.error?.message));
        });
      const loaded = heard('loadeddata');
      video.src = `data:video/webm;base64,${data}`;
      await loaded;
      const canvas = Object.assign(document.createElement('canvas'), { width: video.videoWidth, height: video.videoHeight });
      const context = canvas.getContext('2d', { willReadFrequently: true }) as CanvasRenderingContext2D;
      const pictures: number[][] = [];
      for (const time of at) {
        const sought = heard('seeked');
        video.currentTime = time;
        await sought;
        context.drawImage(video, 0, 0);
        pictures.push([...context.getImageData(0, 0, canvas.width, canvas.height).data]);
      }
      return { duration: video.duration, width: canvas.width, height: canvas.height, pictures };
    },
    { data: film.toString('base64'), at: times },
  );
  await page.close();
  return { duration, pictures: pictures.map((pixels) => ({ width, height, pixels: Uint8Array.from(pixels) })) };
}

test('a film of a turn begins with what is shown, turns, and plays in a browser', async () => {
  const viewer = await shown();
  await open(viewer);
  await small(viewer);
  await field(viewer, 'Degrees that the film turns by').fill('180');
  await field(viewer, 'Seconds that the film takes').fill('1.5');
  await viewer.photograph('film-form.png');
  const { name, bytes } = await made(viewer);
  expect(name).toBe('isostrata-torus_32-distance.webm');
  expect(bytes.subarray(0, 4).toString('hex')).toBe('1a45dfa3');
  const { duration, pictures } = await played(viewer, bytes, [0.01, 0.75, 1.4]);
  expect(duration).toBeCloseTo(1.5, 2);
  expect([pictures[0]?.width, pictures[0]?.height]).toEqual([320, 240]);
  const [first, middle, last] = pictures as [Picture, Picture, Picture];
  for (const picture of pictures) expect(drawnPixels(picture)).toBeGreaterThan(2000);
  expect(difference(first, middle)).toBeGreaterThan(3);
  expect(difference(middle, last)).toBeGreaterThan(3);
  // The picture of a screenshot of that size is the film's first one, but for the codec and its samples.
  await open(viewer);
  const download = viewer.page.waitForEvent('download');
  await viewer.page.getByRole('button', { name: 'Save PNG' }).click();
  expect(difference(first, await viewer.pixels(readFileSync(await (await download).path())))).toBeLessThan(4);
  expect(viewer.problems).toEqual([]);
});

test('a film of the steps shows each for as long, while the session stays where it is', async () => {
  const viewer = await shown('cylinder-24x24x12x5');
  const { step } = viewer.state;
  await open(viewer);
  await small(viewer);
  expect(await field(viewer, 'Last step of the film').inputValue()).toBe('5');
  expect(await form(viewer).getByRole('checkbox', { name: 'turn by' }).isChecked()).toBe(false);
  await field(viewer, 'Last step of the film').fill('6');
  await form(viewer).getByText('Expected steps from 1 to 5.').waitFor();
  expect(await form(viewer).getByRole('button', { name: 'Make film' }).isDisabled()).toBe(true);
  await field(viewer, 'Last step of the film').fill('4');
  await field(viewer, 'Seconds that the film takes').fill('2');
  const { bytes } = await made(viewer);
  const { duration, pictures } = await played(viewer, bytes, [0.1, 0.4, 0.6, 1.9]);
  expect(duration).toBeCloseTo(2, 2);
  const [first, same, second, last] = pictures as [Picture, Picture, Picture, Picture];
  expect(difference(first, same)).toBe(0);
  expect(difference(first, second)).toBeGreaterThan(0.1);
  expect(difference(second, last)).toBeGreaterThan(0.1);
  expect(viewer.state.step).toBe(step);
  expect(viewer.problems).toEqual([]);
});

test('a long film says how far it is, can be cancelled, and the next one can be made', async () => {
  const viewer = await shown();
  await open(viewer);
  await field(viewer, 'Seconds that the film takes').fill('60');
  await form(viewer).getByRole('button', { name: 'Make film' }).click();
  const bar = viewer.page.getByRole('progressbar', { name: 'A film of 1800 pictures' });
  await expect.poll(async () => (await bar.count()) && (await bar.evaluate((of: HTMLProgressElement) => of.value > 0)), { timeout: 30_000 }).toBe(true);
  await viewer.photograph('film-progress.png');
  // The session goes on.
  await viewer.page.getByRole('button', { name: 'Add layer' }).click();
  await viewer.exactPicture();
  await bar.locator('..').getByRole('button', { name: 'Cancel' }).click();
  await viewer.page.getByText('Cancelled.', { exact: true }).waitFor();
  expect(await bar.count()).toBe(0);
  await open(viewer);
  await small(viewer);
  await field(viewer, 'Seconds that the film takes').fill('0.2');
  expect((await made(viewer)).bytes.length).toBeGreaterThan(1000);
  expect(viewer.problems).toEqual([]);
});

test('a film goes on over a killed renderer, with every picture', async () => {
  const token = `film-worker-${process.pid}`;
  const server = await Server.start({ data: ['torus:64'], token });
  const viewer = await Viewer.open(stage.browser, server.ready.url);
  try {
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.exactPicture();
    await open(viewer);
    await small(viewer);
    await field(viewer, 'Seconds that the film takes').fill('3');
    const download = viewer.page.waitForEvent('download');
    await form(viewer).getByRole('button', { name: 'Make film' }).click();
    const bar = viewer.page.getByRole('progressbar', { name: 'A film of 90 pictures' });
    await expect.poll(async () => (await bar.count()) && (await bar.evaluate((of: HTMLProgressElement) => of.value > 5)), { timeout: 30_000 }).toBe(true);
    const engine = await fetch(new URL('api/v1/engine', server.ready.url), { headers: { Authorization: `Bearer ${token}` } });
    const { process: pid } = (await engine.json()) as { process: number };
    expect(pid).toBeGreaterThan(1); // 0 would be all of us
    process.kill(pid, 'SIGKILL');
    const { duration, pictures } = await played(viewer, readFileSync(await (await download).path()), [0.1, 1.5, 2.9]);
    expect(duration).toBeCloseTo(3, 2);
    for (const picture of pictures) expect(drawnPixels(picture)).toBeGreaterThan(2000);
  } finally {
    await viewer.close();
    await server.stop();
  }
});

test('a server that dies in the middle of it is told', async () => {
  const server = await Server.start({ data: ['torus:32'], token: `film-${process.pid}` });
  const viewer = await Viewer.open(stage.browser, server.ready.url);
  try {
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.exactPicture();
    await open(viewer);
    await field(viewer, 'Seconds that the film takes').fill('60');
    await form(viewer).getByRole('button', { name: 'Make film' }).click();
    await viewer.page.getByRole('progressbar', { name: 'A film of 1800 pictures' }).waitFor();
    await server.stop('SIGKILL');
    await expect.poll(() => viewer.page.locator('.notice').allInnerTexts(), { timeout: 20_000 }).toContainEqual(expect.stringContaining('No film: the connection was lost'));
  } finally {
    await viewer.close();
    await server.stop();
  }
});
