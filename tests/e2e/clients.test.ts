// One vocabulary: a person looks at the page while curl, the C++ client and the Python package each move a layer of the same session.
import { execFile } from 'node:child_process';
import { existsSync, readFileSync, rmSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { promisify } from 'node:util';
import type { Browser } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import type { Interval } from '../../web/src/lib/model';
import { binary, Server } from './server';
import { difference, drawnPixels, launch, Viewer, type Picture } from './viewer';

const run = promisify(execFile);
let browser: Browser;
let server: Server;
let viewer: Viewer;
let picture: Picture;

beforeAll(async () => {
  browser = await launch();
  server = await Server.start({ data: ['torus:40'] });
  viewer = await Viewer.open(browser, server.ready.url);
  await viewer.until('layers', (state) => state.intervals.length > 0);
  // One layer, so that whatever it does is seen.
  await run(join(dirname(binary), 'isostrata-client'), [server.ready.url, 'set', '--session', viewer.sessionId, '--interval', '0.15:0.4,color=#ff8000,opacity=0.9']);
  await viewer.until('one layer', (state) => state.intervals.length === 1);
  picture = await viewer.exactPicture();
});
afterAll(async () => {
  await viewer?.close();
  await browser?.close();
  await server?.stop();
});

const layer = (): Interval => viewer.state.intervals[0] as Interval;

/** After `move` has been run, the page has the interval's new ends, a higher revision and another, exact picture. */
async function seesItMove(lower: number, upper: number, move: () => Promise<unknown>): Promise<void> {
  const { revision } = viewer.state;
  const { id } = layer();
  await move();
  const state = await viewer.until(`${lower}:${upper}`, (s) => s.intervals.some((i) => i.id === id && i.lower === lower && i.upper === upper));
  expect(Number(state.revision)).toBeGreaterThan(Number(revision));
  const after = await viewer.exactPicture();
  expect(drawnPixels(after)).toBeGreaterThan(1000);
  expect(difference(picture, after)).toBeGreaterThan(0.5);
  const shown = Number(await viewer.thumb(layer(), 'upper').getAttribute('aria-valuenow'));
  expect(shown).toBeCloseTo(upper, 3);
  picture = after;
  expect(viewer.problems).toEqual([]);
}

test('curl moves an interval that a browser is watching', async () => {
  const url = new URL(server.ready.url);
  const token = url.searchParams.get('token') ?? '';
  const target = `${url.origin}${url.pathname}api/v1/sessions/${viewer.sessionId}/intervals/${layer().id}`;
  await seesItMove(0.1, 0.3, () =>
    run('curl', ['--fail-with-body', '-sS', '-X', 'PATCH', target, '-H', `Authorization: Bearer ${token}`, '-H', 'Content-Type: application/json', '-d', '{"lower": 0.1, "upper": 0.3}']),
  );
});

test('the C++ client moves an interval that a browser is watching', async () => {
  await seesItMove(0.2, 0.6, () =>
    run(join(dirname(binary), 'isostrata-client'), [server.ready.url, 'set', '--session', viewer.sessionId, '--move', `${layer().id}=0.2:0.6`]),
  );
});

test('the Python package moves an interval that a browser is watching', async () => {
  const folder = join(dirname(binary), '..', 'python');
  expect(existsSync(join(folder, 'isostrata', 'v1', 'isostrata_pb2.py')), `${folder} is not there: build isostrata-python`).toBe(true);
  const script = `
import sys, isostrata
with isostrata.connect(sys.argv[1], session=sys.argv[2]) as s:
    s.intervals.move(int(sys.argv[3]), 0.05, 0.9)
`;
  await seesItMove(0.05, 0.9, () =>
    run('/usr/bin/python3', ['-c', script, server.ready.url, viewer.sessionId, String(layer().id)], { env: { ...process.env, PYTHONPATH: folder } }),
  );
  await viewer.photograph('clients.png');
});

test('a film that the client records is played by the browser', async () => {
  const film = join(dirname(binary), '..', 'clients-film.webm');
  await run(join(dirname(binary), 'isostrata-client'), [server.ready.url, 'record', '--session', viewer.sessionId, '--size', '160x120', '--frames', '12', '--fps', '10', '--orbit', '90', '--out', film]);
  const base64 = readFileSync(film).toString('base64');
  rmSync(film);
  // A page of its own: that of the server does not let films in.
  const page = await browser.newPage();
  await page.setContent('<video muted></video>');
  const played = await page.evaluate(async (data) => {
    const video = document.querySelector('video') as HTMLVideoElement;
    const ended = new Promise<void>((done, fail) => {
      video.onended = () => done();
      video.onerror = () => fail(new Error(video.error?.message));
    });
    video.src = `data:video/webm;base64,${data}`;
    await video.play();
    await ended;
    const canvas = Object.assign(document.createElement('canvas'), { width: video.videoWidth, height: video.videoHeight });
    const context = canvas.getContext('2d') as CanvasRenderingContext2D;
    context.drawImage(video, 0, 0);
    const { data: pixels } = context.getImageData(0, 0, canvas.width, canvas.height);
    return { width: video.videoWidth, height: video.videoHeight, duration: video.duration, pixels: [...pixels] };
  }, base64);
  await page.close();
  expect([played.width, played.height]).toEqual([160, 120]);
  expect(played.duration).toBeCloseTo(1.2, 2);
  expect(drawnPixels({ width: played.width, height: played.height, pixels: Uint8Array.from(played.pixels) })).toBeGreaterThan(1000);
});
