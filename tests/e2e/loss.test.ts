// What draws, what serves or what lies between is lost in the middle of a drag: the page goes on by itself, and the end that the hand
// holds is in the end where the hand lets go.
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll, expect, test } from 'vitest';
import type { Interval } from '../../web/src/lib/model';
import { CutLink } from './cut-link';
import { Server } from './server';
import { difference, launch, Viewer, type Picture } from './viewer';

const token = 'a-token-that-is-long-enough-for-a-test-0123456789';
let browser: Browser;
let server: Server | null = null;
let viewer: Viewer;
let link: CutLink | null = null;
let folder = '';

beforeAll(async () => {
  browser = await launch();
});
afterAll(async () => {
  await browser?.close();
});
afterEach(async () => {
  await viewer?.close();
  await link?.close();
  await server?.stop();
  if (folder) rmSync(folder, { recursive: true, force: true });
  link = server = null;
  folder = '';
});

const welcomes = () => viewer.events.filter((event) => event.kind === 'welcome').length;
const frames = () => viewer.events.filter((event) => event.kind === 'frame').length;
const banner = () => viewer.page.locator('.banner');

/** The upper end of an interval in the hand: goes to offsets from where it was taken, in pixels. */
class Hand {
  private at = 0;
  private constructor(
    private readonly x: number,
    private readonly y: number,
    private readonly interval: Interval,
  ) {}
  static async takes(interval: Interval): Promise<Hand> {
    const box = await viewer.thumb(interval, 'upper').boundingBox();
    if (!box) throw new Error('there is no thumb');
    const hand = new Hand(box.x + box.width / 2, box.y + box.height / 2, interval);
    await viewer.page.mouse.move(hand.x, hand.y);
    await viewer.page.mouse.down();
    return hand;
  }
  async goesTo(dx: number): Promise<void> {
    for (const from = this.at; this.at !== dx; ) {
      this.at += Math.sign(dx - from) * Math.min(4, Math.abs(dx - this.at));
      await viewer.page.mouse.move(this.x + this.at, this.y);
      await viewer.page.waitForTimeout(15);
    }
    // The thumb is under the hand, whatever has been lost. Ends stop at other ends that are near.
    const box = await viewer.thumb(this.interval, 'upper').boundingBox();
    expect(Math.abs((box?.x ?? 0) + (box?.width ?? 0) / 2 - this.x - this.at)).toBeLessThan(8);
  }
  /** Gives the end's value as the page shows it. */
  async letsGo(): Promise<number> {
    await viewer.page.mouse.up();
    return Number(await viewer.thumb(this.interval, 'upper').getAttribute('aria-valuenow'));
  }
}

/** The dragged end is where the hand let go, everything else is as it was, and the picture shows that, without loss. */
async function settled(before: Interval[], dragged: Interval, upper: number, old: Picture): Promise<void> {
  const expected = before.map((interval) => (interval.id === dragged.id ? { ...interval, upper } : interval));
  const state = await viewer.until('the end of the drag', (s) => s.intervals.some((i) => i.id === dragged.id && i.upper === upper));
  expect(state.intervals).toEqual(expected);
  const picture = await viewer.exactPicture();
  expect(difference(old, picture)).toBeGreaterThan(0.05);
  await expect.poll(() => viewer.page.locator('footer').innerText(), { timeout: 20_000 }).toMatch(/Connected.*exact/s);
  expect(await viewer.page.locator('.notice').allInnerTexts()).toEqual([]);
  await expect.poll(() => banner().count()).toBe(0);
  // The browser itself reports sockets that do not open.
  expect(viewer.problems.filter((text) => !/WebSocket connection|ERR_CONNECTION|ERR_EMPTY_RESPONSE|ERR_SOCKET_NOT_CONNECTED/.test(text))).toEqual([]);
}

async function open(url: string): Promise<{ before: Interval[]; dragged: Interval; picture: Picture }> {
  viewer = await Viewer.open(browser, url);
  await viewer.until('layers', (state) => state.intervals.length > 1);
  const before = await viewer.layersOfOurOwn(2); // wide enough for the hand's way
  const picture = await viewer.exactPicture();
  return { before, dragged: before[0] as Interval, picture };
}

test('the process that draws is killed', async () => {
  server = await Server.start({ data: ['torus:40'], token });
  const { before, dragged, picture } = await open(server.ready.url);
  const worker = server.ready.worker as number;
  expect(worker).toBeGreaterThan(1);
  const hand = await Hand.takes(dragged);
  await hand.goesTo(-40);
  process.kill(worker, 'SIGKILL');
  const count = frames();
  await hand.goesTo(-80);
  await expect.poll(frames, { timeout: 30_000 }).toBeGreaterThan(count); // while the hand is down
  await hand.goesTo(-60);
  const upper = await hand.letsGo();
  await settled(before, dragged, upper, picture);
  expect(welcomes()).toBe(1);
});

test('the server is killed, and started again with the same state directory', async () => {
  folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-state-'));
  const tokenFile = join(folder, 'token');
  writeFileSync(tokenFile, token, { mode: 0o600 });
  const options = { data: ['torus:40'], more: ['--token-file', tokenFile, '--state-dir', join(folder, 'state')] };
  server = await Server.start(options);
  let { before, dragged, picture } = await open(server.ready.url);
  // A state of one's own.
  await viewer.row(before[1] as Interval).locator('input[type=color]').fill('#ff00ff');
  await viewer.drag(viewer.page.getByRole('application'), 60, -20);
  await viewer.page.waitForTimeout(300);
  picture = await viewer.exactPicture();
  before = viewer.state.intervals;
  const { camera, revision } = viewer.state;
  const session = viewer.sessionId;

  const hand = await Hand.takes(dragged);
  await hand.goesTo(-32);
  await server.stop('SIGKILL');
  await hand.goesTo(-48);
  await expect.poll(() => banner().innerText()).toMatch(/Reconnecting/);
  server = await Server.start({ ...options, port: server.ready.port });
  await hand.goesTo(-72);
  await expect.poll(welcomes, { timeout: 30_000 }).toBe(2);
  const count = frames();
  await hand.goesTo(-64);
  await expect.poll(frames, { timeout: 30_000 }).toBeGreaterThan(count);
  const upper = await hand.letsGo();
  await settled(before, dragged, upper, picture);
  expect(viewer.sessionId).toBe(session);
  expect(viewer.state.camera).toEqual(camera);
  expect(viewer.state.revision).toBeGreaterThan(revision);
  await viewer.photograph('server-killed.png');
});

test('the line is cut, and the hand lets go before it is mended', async () => {
  server = await Server.start({ data: ['torus:40'], token });
  link = await CutLink.to(server.ready.port);
  const url = new URL(server.ready.url);
  url.port = String(link.port);
  const { before, dragged, picture } = await open(url.href);
  const session = viewer.sessionId;
  const hand = await Hand.takes(dragged);
  await hand.goesTo(-32);
  link.cut();
  await expect.poll(() => banner().innerText()).toMatch(/Reconnecting/);
  await hand.goesTo(-72);
  const upper = await hand.letsGo();
  const heard = viewer.events.length;
  link.mend();
  await expect.poll(welcomes, { timeout: 30_000 }).toBe(2);
  await settled(before, dragged, upper, picture);
  expect(viewer.sessionId).toBe(session);
  // The first picture needs none before it, and nothing was refused.
  const since = viewer.events.slice(heard);
  const first = since.find((event) => event.kind === 'frame');
  expect(first?.kind === 'frame' && (first.frame.streamId === 0 || first.frame.key)).toBe(true);
  expect(since.filter((event) => event.kind === 'error')).toEqual([]);
});
