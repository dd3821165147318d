// Cells and labels taken whole: what the page begins with, what its control changes, a part of a grid beside it.
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, test } from 'vitest';
import { Server } from './server';
import { difference, drawnPixels, launch, Viewer } from './viewer';

let server: Server;
let browser: Browser;
let viewer: Viewer;
const folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-whole-'));

/** Three bodies with the labels 1, 2 and 5 in a box of 0. */
function labels(n: number): string {
  const balls: [number, number, number, number, number][] = [
    [1, 0.35, 0.4, 0.5, 0.2],
    [2, 0.62, 0.45, 0.45, 0.22],
    [5, 0.5, 0.7, 0.6, 0.17],
  ];
  const bytes = Buffer.alloc(n * n * n);
  for (let i = 0; i < bytes.length; i++) {
    const at = [i % n, Math.floor(i / n) % n, Math.floor(i / n / n)].map((x) => x / (n - 1)) as [number, number, number];
    for (const [label, ...ball] of balls) if (Math.hypot(at[0] - ball[0], at[1] - ball[1], at[2] - ball[2]) < ball[3]) bytes[i] = label;
  }
  writeFileSync(join(folder, 'labels.raw'), bytes);
  const file = join(folder, 'labels.nhdr');
  writeFileSync(file, `NRRD0004\ntype: uint8\ndimension: 3\nsizes: ${n} ${n} ${n}\nencoding: raw\ndata file: labels.raw\n`);
  return file;
}

beforeAll(async () => {
  server = await Server.start({ data: [labels(48)] });
  browser = await launch();
});
afterAll(async () => {
  await browser?.close();
  await server?.stop();
  rmSync(folder, { recursive: true, force: true });
});
afterEach(async () => {
  await viewer?.close();
  server.checkAlive();
});

describe('whole values in the page', () => {
  test('labels begin whole, nothing lies between two of them, and interpolated values are one choice away', async () => {
    viewer = await Viewer.open(browser, server.ready.url);
    const first = await viewer.until('labels', (s) => s.intervals.length === 3);
    expect(first.values).toBe('whole');
    const control = viewer.page.getByLabel('Values', { exact: true });
    expect(await control.inputValue()).toBe('whole');
    const whole = await viewer.exactPicture();
    expect(drawnPixels(whole)).toBeGreaterThan(5000);
    await viewer.photograph('whole-labels.png');

    await control.selectOption('interpolated');
    await viewer.until('interpolated values', (s) => s.values === 'interpolated');
    expect(difference(whole, await viewer.exactPicture())).toBeGreaterThan(0.3);
    await viewer.photograph('whole-labels-interpolated.png');
    await control.selectOption('whole');
    await viewer.until('whole values', (s) => s.values === 'whole');
    expect(difference(whole, await viewer.exactPicture())).toBe(0);
  });

  test('a script opens a part of the grid, which the page shows as a dataset of its own', async () => {
    viewer = await Viewer.open(browser, server.ready.url);
    const state = await viewer.until('labels', (s) => s.intervals.length === 3);
    await viewer.exactPicture();
    const session = viewer.sessionId;
    const url = new URL(server.ready.url);
    const answer = await fetch(`${url.origin}/api/v1/sessions/${session}/dataset`, {
      method: 'PUT',
      headers: { authorization: `Bearer ${url.searchParams.get('token')}`, 'content-type': 'application/json' },
      body: JSON.stringify({ id: state.dataset, region: '0:23,:,:', stride: '2' }),
    });
    expect(answer.status).toBe(200);
    const part = await viewer.until('the part', (s) => s.dataset !== state.dataset);
    expect(part.dataset).toBe(`${state.dataset}@:23,:,:*2`);
    await expect.poll(() => viewer.page.locator('section[aria-labelledby=data-heading] .facts').textContent()).toContain((12 * 24 * 24).toLocaleString('en'));
    await viewer.exactPicture();
    await viewer.photograph('part-of-a-grid.png');
  });
});
