// The page behind somebody else's proxy: an interval is dragged, and the exact picture is another one. For deploy/prove-ondemand.
// $ISOSTRATA_PORTAL: the page's address there; $ISOSTRATA_LOGIN: USER:PASSWORD of the proxy; $ISOSTRATA_RECORD_TO: a folder for the screenshot.
import { mkdirSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { expect, test } from 'vitest';
import type { Interval } from '../../web/src/lib/model';
import { repository } from './server';
import { difference, drawnPixels, launch, Viewer } from './viewer';

const folder = resolve(repository, process.env.ISOSTRATA_RECORD_TO ?? 'build/portal');

test('an interval is dragged through the portal', async () => {
  const url = process.env.ISOSTRATA_PORTAL;
  if (!url) throw new Error('ISOSTRATA_PORTAL: expected the address of a page');
  const [username, password] = (process.env.ISOSTRATA_LOGIN ?? ':').split(':') as [string, string];
  const browser = await launch();
  try {
    const viewer = await Viewer.open(browser, url, { login: { username, password } });
    await viewer.until('layers', (state) => state.intervals.length > 0, 60_000);
    const [layer] = (await viewer.layersOfOurOwn(1)) as [Interval];
    const before = await viewer.exactPicture();
    expect(drawnPixels(before)).toBeGreaterThan(1000);
    await viewer.drag(viewer.thumb(layer, 'upper'), 60, 0);
    const moved = await viewer.until('a moved end', (state) => state.intervals[0]!.upper > layer.upper);
    expect(moved.intervals[0]!.lower).toBe(layer.lower);
    expect(difference(before, await viewer.exactPicture())).toBeGreaterThan(0.1);
    expect(viewer.page.url()).not.toContain('token');
    for (const request of viewer.requests) expect(new URL(request).origin === new URL(url).origin || request.startsWith('blob:'), request).toBe(true);
    expect(viewer.problems).toEqual([]);
    mkdirSync(folder, { recursive: true });
    await viewer.page.screenshot({ path: join(folder, 'portal.png') });
  } finally {
    await browser.close();
  }
});
