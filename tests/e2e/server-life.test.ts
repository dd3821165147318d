// What the page does when the server refuses, works long, dies and comes back.
import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import type { Interval } from '../../web/src/lib/model';
import { Server } from './server';
import { difference, launch, Viewer } from './viewer';

const token = 'a-token-that-is-long-enough-for-a-test-0123456789';
let browser: Browser;
let server: Server | null = null;
let viewer: Viewer | null = null;

beforeAll(async () => {
  browser = await launch();
});
afterAll(async () => {
  await browser?.close();
});
afterEach(async () => {
  await viewer?.close();
  await server?.stop();
  viewer = server = null;
});

test('a wrong token is said clearly', async () => {
  server = await Server.start({ data: ['sphere:16'], token });
  const url = new URL(server.ready.url);
  url.searchParams.set('token', 'this-is-not-it');
  viewer = await Viewer.open(browser, url.href);
  await expect.poll(() => viewer?.page.locator('body').innerText(), { timeout: 15_000 }).toMatch(/token/i);
  expect(viewer.events).toEqual([]);
});

test('the page works below a prefix, as behind a proxy', async () => {
  server = await Server.start({ data: ['sphere:16'], token, more: ['--base-url', '/user/me/proxy/'] });
  expect(new URL(server.ready.url).pathname).toBe('/user/me/proxy/');
  viewer = await Viewer.open(browser, server.ready.url);
  await viewer.until('layers', (state) => state.intervals.length > 0);
  await viewer.exactPicture();
  expect(viewer.problems).toEqual([]);
});

test('a server that is killed and started again gets its picture back', async () => {
  server = await Server.start({ data: ['torus:40'], token });
  viewer = await Viewer.open(browser, server.ready.url);
  await viewer.until('layers', (state) => state.intervals.length > 0);
  // A picture of one’s own: one layer less, another colour, another camera.
  const [first, second] = viewer.state.intervals as [Interval, Interval];
  await viewer.row(first).getByRole('button', { name: /delete/ }).click();
  await viewer.row(second).locator('input[type=color]').fill('#ff00ff');
  await viewer.drag(viewer.page.getByRole('application'), 90, -30);
  await viewer.page.waitForTimeout(600);
  const before = await viewer.exactPicture();
  const mine = viewer.state;
  const session = viewer.sessionId;

  const { port } = server.ready;
  await server.stop('SIGKILL');
  await expect.poll(() => viewer?.page.locator('footer').innerText()).toMatch(/Reconnecting/);
  await expect.poll(() => viewer?.page.getByRole('status').first().innerText()).toMatch(/Reconnecting/);
  const welcomes = viewer.events.filter((event) => event.kind === 'welcome').length;
  server = await Server.start({ data: ['torus:40'], token, port });
  await expect.poll(() => viewer?.events.filter((event) => event.kind === 'welcome').length, { timeout: 30_000 }).toBeGreaterThan(welcomes);

  expect(viewer.sessionId).not.toBe(session);
  const state = await viewer.until('the layers of before', (s) => s.intervals.length === mine.intervals.length);
  expect(state.intervals.map((i) => [i.lower, i.upper, i.color])).toEqual(mine.intervals.map((i) => [i.lower, i.upper, i.color]));
  await viewer.until('the camera of before', (s) => JSON.stringify(s.camera) === JSON.stringify(mine.camera));
  expect(difference(before, await viewer.exactPicture())).toBeLessThan(0.01);
});

test('a server that comes back with another token says so on the page, and the page stops asking', async () => {
  server = await Server.start({ data: ['sphere:16'], token });
  viewer = await Viewer.open(browser, server.ready.url);
  await viewer.until('layers', (state) => state.intervals.length > 0);
  const { port } = server.ready;
  await server.stop('SIGKILL');
  server = await Server.start({ data: ['sphere:16'], token: `${token}-another`, port });
  await expect.poll(() => viewer?.page.getByRole('alert').allInnerTexts(), { timeout: 30_000 }).toEqual([expect.stringMatching(/Not connected.*token/s)]);
  await expect.poll(() => viewer?.page.locator('footer').innerText()).toMatch(/Not connected/);
});

test('work that takes long shows its progress and can be cancelled', async () => {
  server = await Server.start({ data: ['sphere:16', 'torus:400'], token });
  viewer = await Viewer.open(browser, server.ready.url);
  await viewer.until('the small dataset', (state) => state.intervals.length > 0);
  await viewer.exactPicture();
  await viewer.page.getByLabel('Dataset').selectOption({ label: 'torus:400' });
  await viewer.page.getByRole('button', { name: 'Cancel' }).click({ timeout: 60_000 });
  await expect
    .poll(() => viewer?.events.some((event) => event.kind === 'done' && event.done.cancelled && !event.done.superseded), { timeout: 60_000 })
    .toBe(true);
  await expect.poll(() => viewer?.page.locator('.notice').allInnerTexts()).toEqual([expect.stringMatching(/^Cancelled/)]);
  // The server and the page go on.
  await viewer.page.getByLabel('Dataset').selectOption({ index: 0 });
  await viewer.until('the small dataset again', (state) => state.intervals.length > 0);
  expect(server.alive).toBe(true);
});
