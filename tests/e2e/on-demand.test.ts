// What the page loads at first, and what comes after it: how much it is, and what is said if it does not come.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { describe, expect, test } from 'vitest';
import { repository } from './server';
import { Stage } from './stage';

const stage = new Stage({ data: ['torus:32'] });
const assets = (requests: string[]) => requests.map((url) => new URL(url).pathname).filter((path) => path.startsWith('/assets/'));

describe('what is not needed at first', () => {
  test('comes by itself after the first picture, packed and kept for good like what comes first', async () => {
    const viewer = await stage.open();
    const html = await (await viewer.page.request.get(stage.server.ready.url)).text();
    const first = [...html.matchAll(/"\.(\/assets\/[^"]+)"/g)].map(([, path]) => path as string);
    expect(first.length).toBeGreaterThan(1);
    await viewer.exactPicture();
    await expect.poll(() => assets(viewer.requests).filter((path) => !first.includes(path)).length).toBe(1);
    const later = assets(viewer.requests).find((path) => !first.includes(path)) as string;
    expect(later).toMatch(/on-demand/);
    for (const path of [...first, later]) {
      const answer = await viewer.page.request.get(new URL(path, stage.server.ready.url).href, { headers: { 'Accept-Encoding': 'gzip' } });
      expect(answer.headers()['cache-control'], path).toContain('immutable');
      expect(answer.headers()['content-encoding'], path).toBe('gzip');
    }
    const bytes = first.reduce((sum, path) => sum + gzipSync(readFileSync(join(repository, 'web', 'dist', path))).length, 0);
    expect(bytes, 'what every page waits for').toBeLessThan(130_300);
    await viewer.page.getByRole('button', { name: 'Share' }).click();
    expect(await viewer.page.getByText('Here now').isVisible()).toBe(true);
    expect(viewer.problems).toEqual([]);
  });

  test('and does not come is asked for again: by a button, or by loading the page, which shows the same', async () => {
    const viewer = await stage.open({ blank: true });
    let loads = 0;
    viewer.page.on('request', (request) => void (loads += Number(request.isNavigationRequest())));
    await viewer.page.route(/on-demand/, (route) => (loads < 2 ? route.abort() : route.continue()));
    await viewer.page.goto(stage.server.ready.url);
    await viewer.exactPicture();
    await viewer.page.getByRole('button', { name: 'Share' }).click();
    const panel = viewer.page.getByRole('region', { name: 'Share this session' });
    await panel.getByRole('button', { name: 'Try again' }).click();
    await panel.getByRole('button', { name: 'Load the page again' }).waitFor();
    await viewer.photograph('not-come.png');
    await viewer.page.getByRole('button', { name: 'Save view' }).click();
    await viewer.page.getByText('has not come from the server. Try again').first().waitFor();
    const session = viewer.sessionId;
    await panel.getByRole('button', { name: 'Load the page again' }).click();
    await viewer.page.getByRole('button', { name: 'Share' }).click();
    await panel.getByText('Here now').waitFor();
    expect(viewer.sessionId).toBe(session);
  });

  test('and is on its way again when the line is', async () => {
    const viewer = await stage.open({ blank: true });
    let down = true;
    await viewer.page.route(/on-demand/, (route) => (down ? route.abort() : route.continue()));
    await viewer.page.goto(stage.server.ready.url);
    await viewer.exactPicture();
    await viewer.page.getByRole('button', { name: 'Browse…' }).click();
    await viewer.page.getByRole('button', { name: 'Try again' }).waitFor();
    down = false;
    const search = viewer.page.getByRole('searchbox', { name: 'Search names' });
    await expect
      .poll(async () => {
        if (await search.isVisible()) return true;
        await viewer.page.getByRole('button', { name: 'Try again' }).click({ timeout: 1000 }).catch(() => undefined); // it may have come by itself
        return false;
      })
      .toBe(true);
  });
});
