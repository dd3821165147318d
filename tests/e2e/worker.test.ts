// The process that draws is killed, and the page goes on.
import type { Browser } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { Server } from './server';
import { difference, launch, Viewer } from './viewer';

let server: Server;
let browser: Browser;
let viewer: Viewer;

beforeAll(async () => {
  server = await Server.start({ data: ['torus:40'], token: 'a-token-for-this-test-alone' });
  browser = await launch();
});
afterAll(async () => {
  await viewer?.close();
  await browser?.close();
  await server?.stop();
});

interface Engine {
  ownProcess: boolean;
  process: number;
  deaths: number;
  lastDeath: string;
  fallback: string;
}
async function engine(): Promise<Engine> {
  const url = new URL(server.ready.url);
  const token = url.searchParams.get('token') as string;
  const answer = await fetch(new URL('api/v1/engine', url), { headers: { Authorization: `Bearer ${token}` } });
  return (await answer.json()) as Engine;
}

/** Never process 0, which would be this one and all around it. */
function killWorker(pid: number): void {
  expect(pid).toBeGreaterThan(1);
  process.kill(pid, 'SIGKILL');
}

test('a drag goes on over a killed worker, on the same connection and session', async () => {
  viewer = await Viewer.open(browser, server.ready.url);
  await viewer.until('layers', (state) => state.intervals.length > 0);
  const before = await viewer.exactPicture();
  const { camera } = viewer.state;
  const session = viewer.sessionId;
  const welcomes = () => viewer.events.filter((event) => event.kind === 'welcome').length;

  const first = await engine();
  expect(first.ownProcess).toBe(true);
  expect(first.process).toBe(server.ready.worker);
  const box = await viewer.page.getByRole('application').boundingBox();
  if (!box) throw new Error('there is no picture');
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await viewer.page.mouse.move(x, y);
  await viewer.page.mouse.down();
  for (let i = 1; i <= 24; i++) {
    await viewer.page.mouse.move(x + 5 * i, y + 2 * i);
    await viewer.page.waitForTimeout(20);
    if (i === 8) killWorker(first.process);
  }
  await viewer.page.mouse.up();

  const turned = await viewer.exactPicture();
  expect(difference(before, turned)).toBeGreaterThan(0.1);
  expect(viewer.sessionId).toBe(session);
  expect(welcomes()).toBe(1);
  expect(viewer.problems).toEqual([]);
  const said = viewer.events.flatMap((event) => (event.kind === 'progress' ? [event.progress.stage] : []));
  // Told to whoever waits for a picture at that moment, which a hand between two moves does not.
  const ends = said.filter((stage) => stage.includes('another one takes over'));
  for (const end of ends) expect(end).toContain('signal 9');
  await expect.poll(() => viewer.page.locator('footer').innerText()).toMatch(/Connected.*exact/s);

  const second = await engine();
  expect(second.process).not.toBe(first.process);
  expect(second.deaths).toBe(1);
  expect(second.lastDeath).toContain('signal 9');
  await viewer.photograph('worker-killed.png');

  // The same view from the new process is the picture of the old one.
  const viewport = viewer.page.getByRole('application');
  await viewport.dblclick({ position: { x: 30, y: 200 } });
  await viewer.until('the camera of before', (state) => JSON.stringify(state.camera) === JSON.stringify(camera));
  expect(difference(before, await viewer.exactPicture())).toBe(0);
});

test('three deaths in a minute are drawn by native, and the page names the cause', async () => {
  for (let deaths = (await engine()).deaths; deaths < 3; deaths++) {
    await expect.poll(async () => (await engine()).process, { timeout: 60_000 }).toBeGreaterThan(0);
    killWorker((await engine()).process);
    await expect.poll(async () => (await engine()).deaths, { timeout: 60_000 }).toBe(deaths + 1);
  }
  await expect.poll(async () => (await engine()).process, { timeout: 60_000 }).toBeGreaterThan(0);
  expect((await engine()).fallback).toContain('3 times in 60 s');
  const frames = () => viewer.events.filter((event) => event.kind === 'frame').length;
  const count = frames();
  await viewer.drag(viewer.page.getByRole('application'), -60, 20);
  await expect.poll(frames, { timeout: 60_000 }).toBeGreaterThan(count);
  await viewer.exactPicture();
  await expect.poll(() => viewer.page.locator('body').innerText(), { timeout: 20_000 }).toContain('signal 9');
  await viewer.photograph('worker-fallback.png');
});
