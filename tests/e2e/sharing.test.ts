// Two people at one session: one drags, the other sees it; a link that opens it; a server that is killed and comes back.
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import { Server } from './server';
import { difference, launch, Viewer } from './viewer';

const token = 'a-token-that-is-long-enough-for-a-test-0123456789';
let browser: Browser;
let server: Server | null = null;
let people: Viewer[] = [];

beforeAll(async () => {
  browser = await launch();
});
afterAll(async () => {
  await browser?.close();
});
afterEach(async () => {
  for (const person of people) await person.close();
  await server?.stop();
  people = [];
  server = null;
});

async function come(url: string): Promise<Viewer> {
  const person = await Viewer.open(browser, url, { width: 1000, height: 700 });
  people.push(person);
  await person.until('layers', (state) => state.intervals.length > 0);
  return person;
}

/** The link that the page makes, as a person copies it. */
async function link(owner: Viewer, role: 'view only' | 'control'): Promise<string> {
  await owner.page.getByRole('button', { name: /^Share/ }).click();
  await owner.page.locator('#share-panel form select').first().selectOption({ label: role });
  await owner.page.getByRole('button', { name: 'Make link' }).click();
  const input = owner.page.getByLabel('Invitation link');
  await input.waitFor();
  return input.inputValue();
}

test('the controller drags and the viewer sees it, and may not drag', async () => {
  server = await Server.start({ data: ['torus:24'], token });
  const owner = await come(server.ready.url);
  const address = await link(owner, 'view only');
  expect(address).not.toContain(token);
  const viewer = await come(address);
  expect(viewer.sessionId).toBe(owner.sessionId);
  await expect.poll(() => viewer.page.locator('header.top').innerText()).toMatch(/View only/);
  await expect.poll(() => owner.page.locator('#share-panel').innerText()).toMatch(/Guest/);
  await owner.photograph('share-controller.png');
  await owner.page.keyboard.press('Escape');

  await viewer.exactPicture();
  const before = viewer.state.camera;
  await owner.drag(owner.page.getByRole('application'), 120, 40);
  await viewer.until('the controller’s camera', (state) => JSON.stringify(state.camera) !== JSON.stringify(before));
  await owner.page.waitForTimeout(500);
  const [mine, theirs] = [await owner.exactPicture(), await viewer.exactPicture()];
  expect(viewer.state).toEqual(owner.state);
  expect(difference(mine, theirs)).toBe(0);

  const camera = owner.state.camera;
  await viewer.drag(viewer.page.getByRole('application'), 90, 10);
  await viewer.page.waitForTimeout(500);
  expect(owner.state.camera).toEqual(camera);
  await viewer.photograph('share-viewer.png');
  await viewer.page.mouse.move(900, 400); // over the settings
  await viewer.page.mouse.wheel(0, 200);
  await expect.poll(() => viewer.page.evaluate(() => document.querySelector('aside')?.scrollTop)).toBeGreaterThan(50);

  // The owner has those who only look take less of the machine.
  await owner.page.getByRole('button', { name: /^Share/ }).click();
  await owner.page.getByLabel('Pictures of those who only look').selectOption({ label: 'at most 640 × 360' });
  const pixels = async () => {
    const { width, height } = await viewer.picture();
    return width * height;
  };
  await expect.poll(pixels, { timeout: 20_000 }).toBeLessThanOrEqual(640 * 360);
  await owner.photograph('share-size.png');
  await owner.page.getByLabel('Pictures of those who only look').selectOption({ label: 'as large as their window' });
  await viewer.exactPicture();
  await owner.page.keyboard.press('Escape');

  // Control is given, and the link is taken back.
  await owner.page.getByRole('button', { name: /^Share/ }).click();
  await owner.page.getByRole('button', { name: 'Let control' }).click();
  await expect.poll(() => viewer.page.locator('header.top').innerText()).not.toMatch(/View only/);
  await viewer.drag(viewer.page.getByRole('application'), 90, 10);
  await owner.until('the guest’s camera', (state) => JSON.stringify(state.camera) !== JSON.stringify(camera));
  await owner.page.getByRole('button', { name: 'Take back' }).click();
  await expect.poll(() => viewer.page.getByRole('alert').first().innerText()).toMatch(/Not connected.*invitation/s);
  expect(server.log).not.toContain(new URL(address).searchParams.get('token'));
});

test('a server that is killed in a drag comes back with the same session, picture and link', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-state-'));
  try {
    const more = ['--state-dir', folder];
    server = await Server.start({ data: ['torus:24'], token, more });
    const owner = await come(server.ready.url);
    const guest = await come(await link(owner, 'view only'));
    await owner.page.keyboard.press('Escape');
    await owner.drag(owner.page.getByRole('application'), 120, 40);
    await owner.page.waitForTimeout(500);
    const picture = await owner.exactPicture();
    const state = owner.state;
    const session = owner.sessionId;
    const { port } = server.ready;
    await server.stop('SIGKILL');
    const welcomes = (person: Viewer) => person.events.filter((event) => event.kind === 'welcome').length;
    const had = [welcomes(owner), welcomes(guest)];
    server = await Server.start({ data: ['torus:24'], token, port, more });
    await expect.poll(() => welcomes(owner), { timeout: 30_000 }).toBeGreaterThan(had[0] as number);
    await expect.poll(() => welcomes(guest), { timeout: 30_000 }).toBeGreaterThan(had[1] as number);
    expect(owner.sessionId).toBe(session);
    expect(guest.sessionId).toBe(session);
    expect(owner.state).toEqual(state);
    expect(difference(picture, await owner.exactPicture())).toBe(0);
    // It goes on.
    await owner.drag(owner.page.getByRole('application'), -60, 20);
    await guest.until('the new camera', (s) => JSON.stringify(s.camera) !== JSON.stringify(state.camera));
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
});
