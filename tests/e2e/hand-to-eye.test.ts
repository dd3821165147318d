// From the hand to the eye: what lies between the moment at which the browser hears of a pointer and the one at which it shows a picture of it. Told, and
// never asserted: $ISOSTRATA_HAND_DATA is other data than a torus of 96 points a side.
import type { Browser } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import type { Interval } from '../../web/src/lib/model';
import { Server } from './server';
import { launch, Viewer } from './viewer';

let server: Server;
let browser: Browser;

beforeAll(async () => {
  server = await Server.start({ data: [process.env.ISOSTRATA_HAND_DATA ?? 'torus:96'] });
  browser = await launch();
});
afterAll(async () => {
  await browser?.close();
  await server?.stop();
});

interface Heard {
  inputs: { seq: number; handMs: number }[]; // cameras and ends that were sent, and when the first pointer came that they contain
  shown: { frame: number; eyeMs: number }[]; // frames that were drawn, and the browser's next picture
}

/** In the page, before its own scripts. */
function listen(): void {
  const heard: Heard = { inputs: [], shown: [] };
  (window as unknown as { heard: Heard }).heard = heard;
  let handMs: number | null = null;
  window.addEventListener('pointerdown', () => (handMs = null), true);
  window.addEventListener('pointermove', (event) => (handMs ??= event.timeStamp), true);
  const number = (bytes: Uint8Array, at: number): [value: number, next: number] => {
    let value = 0;
    for (let scale = 1; ; scale *= 128) {
      const byte = bytes[at++] ?? 0;
      value += (byte & 127) * scale;
      if (byte < 128) return [value, at];
    }
  };
  const send = WebSocket.prototype.send;
  WebSocket.prototype.send = function (data) {
    send.call(this, data);
    const bytes = data instanceof ArrayBuffer ? new Uint8Array(data) : ArrayBuffer.isView(data) ? new Uint8Array(data.buffer, data.byteOffset, data.byteLength) : null;
    if (!bytes || bytes[0] !== 8) return; // ClientMessage.seq is its first field, the body its second
    const [seq, body] = number(bytes, 1);
    const [tag, length] = number(bytes, body);
    const field = tag >> 3;
    if ((field === 10 || field === 7) && handMs !== null) heard.inputs.push({ seq, handMs }), (handMs = null);
    const [, ack] = number(bytes, length);
    if (field !== 15 || bytes[ack] !== 8) return;
    const frame = number(bytes, ack + 1)[0]; // FrameAck: it has been drawn
    requestAnimationFrame((eyeMs) => heard.shown.push({ frame, eyeMs }));
  };
}

function quantiles(ms: number[]): string {
  const sorted = [...ms].sort((a, b) => a - b);
  const at = (p: number) => (sorted[Math.min(Math.floor(p * sorted.length), sorted.length - 1)] ?? NaN).toFixed(0);
  return `p50 ${at(0.5)} ms, p95 ${at(0.95)} ms, max ${at(1)} ms over ${sorted.length} inputs`;
}

test('everything that a hand does is seen, and how soon is told', async () => {
  const viewer = await Viewer.open(browser, server.ready.url, { width: 1280, height: 800, before: [listen] });
  const { page } = viewer;
  await viewer.until('layers', (state) => state.intervals.length > 0, 60_000);
  const picture = await page.getByRole('application').boundingBox();
  const gesture = async (name: string, x: number, y: number, place: (i: number) => [number, number], restEvery = Infinity) => {
    await viewer.exactPicture();
    await page.waitForTimeout(500);
    await page.evaluate(() => ((window as unknown as { heard: Heard }).heard.inputs = []));
    const begin = viewer.events.length;
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (let i = 1; i <= 120; i++) {
      await page.mouse.move(...place(i));
      await page.waitForTimeout(i % restEvery === 0 ? 160 + 2 * i : 16); // some end in the middle of the picture at rest
    }
    await page.mouse.up();
    await viewer.exactPicture();
    const { inputs, shown } = await page.evaluate(() => (window as unknown as { heard: Heard }).heard);
    const containing = new Map<number, number>(); // of each frame, the newest message that it contains
    const sizes = new Map<string, number>();
    for (const event of viewer.events.slice(begin)) {
      if (event.kind !== 'frame') continue;
      containing.set(Number(event.frame.frameId), event.frame.inputSeq);
      const what = `${event.frame.width}x${event.frame.height}`;
      if (event.frame.phase === 'moving') sizes.set(what, (sizes.get(what) ?? 0) + 1);
    }
    const latency = inputs.map(({ seq, handMs }) => {
      const seen = shown.find(({ frame }) => (containing.get(frame) ?? -1) >= seq);
      return seen ? seen.eyeMs - handMs : Infinity;
    });
    console.log(`hand to eye, ${name}: ${quantiles(latency)}; ${[...sizes].map(([size, count]) => `${count} of ${size}`).join(', ')}`);
    expect(latency.length).toBeGreaterThan(3);
    expect(latency.filter((ms) => !Number.isFinite(ms))).toEqual([]);
  };

  if (!picture) throw new Error('there is no picture');
  const [x, y] = [picture.x + picture.width / 2, picture.y + picture.height / 2];
  await gesture('turning', x, y, (i) => [x + 120 * Math.sin(i / 20), y + 40 * Math.sin(i / 9)]);
  const drag = async (name: string, restEvery?: number) => {
    const thumb = await viewer.thumb(viewer.state.intervals[0] as Interval, 'upper').boundingBox();
    if (!thumb) throw new Error('there is no thumb');
    const [tx, ty] = [thumb.x + thumb.width / 2, thumb.y + thumb.height / 2];
    // Out of reach of the end that it touches, where a hand moves and nothing changes; and a pixel at least with each move.
    await gesture(name, tx, ty, (i) => [tx - 10 - Math.abs(((i + 30) % 60) - 30), ty], restEvery);
  };
  await drag('dragging an end');
  await drag('dragging an end, with rests', 15);
  expect(viewer.problems).toEqual([]);
});
