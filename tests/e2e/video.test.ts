// Frames in motion as video in a real browser: what is negotiated, what becomes of colours, and what happens where it cannot be decoded.
import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, test } from 'vitest';
import type { Frame } from '../../web/src/lib/model';
import { Server } from './server';
import { difference, drawnPixels, launch, Viewer, type Picture } from './viewer';

let server: Server;
let browser: Browser;
let viewer: Viewer;

beforeAll(async () => {
  server = await Server.start({ data: ['torus:48'] });
  browser = await launch();
});
afterAll(async () => {
  await browser?.close();
  await server?.stop();
});
afterEach(async () => {
  await viewer?.close();
  server.checkAlive();
});

async function open(before?: () => void): Promise<void> {
  viewer = await Viewer.open(browser, server.ready.url, before ? { before } : {});
  await viewer.until('layers', (state) => state.intervals.length > 0);
  await viewer.exactPicture();
}
const moving = (): Frame[] => viewer.events.flatMap((event) => (event.kind === 'frame' && !event.frame.lossless ? [event.frame] : []));
const offered = (): string[] => viewer.events.flatMap((event) => (event.kind === 'welcome' ? event.welcome.movingFormats : []));
const canvas = () => viewer.page.locator('canvas').first();

/** Presses the pointer, turns the picture and stays: the moving frame of the newest state, then, let go, the exact one. */
async function turnAndCompare(): Promise<{ inMotion: Picture; exact: Picture }> {
  const { page } = viewer;
  await page.mouse.move(400, 300);
  await page.mouse.down();
  for (let i = 1; i <= 10; i++) {
    await page.mouse.move(400 + 12 * i, 300 + 4 * i);
    await page.waitForTimeout(25);
  }
  await expect
    .poll(async () => (await canvas().getAttribute('data-revision')) === String(viewer.state.revision), { timeout: 20_000 })
    .toBe(true);
  expect(await canvas().getAttribute('data-phase')).toBe('moving');
  const inMotion = await viewer.picture();
  await page.mouse.up();
  return { inMotion, exact: await viewer.exactPicture() };
}

/** The root mean square difference of the two colour differences R - G and B - G. */
function chromaError(a: Picture, b: Picture): number {
  let sum = 0;
  const at = (p: Picture, i: number) => p.pixels[i] as number;
  for (let i = 0; i < a.pixels.length; i += 4)
    for (const c of [0, 2]) sum += (at(a, i + c) - at(a, i + 1) - at(b, i + c) + at(b, i + 1)) ** 2;
  return Math.sqrt(sum / (a.pixels.length / 2));
}

/** The picture as halved chroma would show it at best: each pixel's own brightness, the mean colour of two by two. */
function halvedChroma(picture: Picture): Picture {
  const { width, height } = picture;
  const pixels = new Uint8Array(picture.pixels);
  const luma = (i: number) => 0.299 * (picture.pixels[i] as number) + 0.587 * (picture.pixels[i + 1] as number) + 0.114 * (picture.pixels[i + 2] as number);
  for (let y = 0; y + 1 < height; y += 2)
    for (let x = 0; x + 1 < width; x += 2) {
      const four = [0, 4, 4 * width, 4 * width + 4].map((offset) => 4 * (y * width + x) + offset);
      for (let c = 0; c < 3; c++) {
        const mean = four.reduce((sum, i) => sum + (picture.pixels[i + c] as number) - luma(i), 0) / 4;
        for (const i of four) pixels[i + c] = Math.max(0, Math.min(255, Math.round(luma(i) + mean)));
      }
    }
  return { width, height, pixels };
}

describe('video', () => {
  test('Chromium decodes VP9 4:4:4, gets it while something moves, and the picture at rest is exact', async () => {
    await open();
    expect(offered()).toContain('vp9-444');
    const { inMotion, exact } = await turnAndCompare();
    const frames = moving();
    expect(frames.length).toBeGreaterThan(3);
    expect(new Set(frames.map((frame) => frame.format))).toEqual(new Set(['vp9-444']));
    expect(frames.filter((frame) => frame.key)).toHaveLength(1);
    expect(drawnPixels(exact)).toBeGreaterThan(1000);
    expect(difference(inMotion, exact)).toBeLessThan(3);
    expect(viewer.problems).toEqual([]);
  });

  test('saturated layers keep their colours up to their edges', async () => {
    await open();
    const [first, second] = viewer.state.intervals;
    for (const [interval, color] of [
      [first, '#ff0000'],
      [second, '#0000ff'],
    ] as const)
      if (interval) await viewer.row(interval).locator('input[type=color]').fill(color);
    await viewer.exactPicture();
    const { inMotion, exact } = await turnAndCompare();
    expect(await canvas().getAttribute('data-format')).toBe('png');
    const [ours, halved] = [chromaError(inMotion, exact), chromaError(halvedChroma(exact), exact)];
    console.log(`rms of colour differences: ours ${ours.toFixed(2)}, halved chroma alone ${halved.toFixed(2)}`);
    expect(halved).toBeGreaterThan(2); // there are such edges
    expect(ours).toBeLessThan(halved);
  });

  test('another size of the window goes on in the same stream', async () => {
    await open();
    await turnAndCompare();
    await viewer.page.setViewportSize({ width: 903, height: 611 });
    await viewer.exactPicture();
    const { inMotion, exact } = await turnAndCompare();
    expect(difference(inMotion, exact)).toBeLessThan(3);
    expect(new Set(moving().map((frame) => frame.streamId)).size).toBe(1);
    expect(moving().filter((frame) => frame.key).length).toBeGreaterThan(1);
    expect(viewer.problems).toEqual([]);
  });

  test('a browser without WebCodecs, as on an insecure address, gets JPEG', async () => {
    await open(() => Reflect.deleteProperty(globalThis, 'VideoDecoder'));
    expect(offered()).toEqual(['jpeg']);
    const { inMotion, exact } = await turnAndCompare();
    expect(new Set(moving().map((frame) => frame.format))).toEqual(new Set(['jpeg']));
    expect(difference(inMotion, exact)).toBeLessThan(3);
  });

  test('a decoder that shows wrong colours is not used', async () => {
    await open(() => {
      // As a browser that takes limited range for full.
      const draw = CanvasRenderingContext2D.prototype.drawImage as (...args: unknown[]) => void;
      CanvasRenderingContext2D.prototype.drawImage = function (this: CanvasRenderingContext2D, ...args: unknown[]) {
        draw.apply(this, args);
        if (!(args[0] instanceof VideoFrame)) return;
        this.fillStyle = '#80808020';
        this.fillRect(0, 0, 9999, 9999);
      };
    });
    expect(offered()).toEqual(['jpeg']);
  });

  test('a decoder that fails on the way is replaced by the next format, and the picture goes on', async () => {
    await open(() => {
      const decode = VideoDecoder.prototype.decode;
      let frames = 0;
      VideoDecoder.prototype.decode = function (chunk) {
        frames += 1;
        // A frame of noughts is none of any codec.
        const broken = new EncodedVideoChunk({ type: chunk.type, timestamp: chunk.timestamp, data: new Uint8Array(64) });
        decode.call(this, frames > 6 ? broken : chunk);
      };
    });
    expect(offered()[0]).toBe('vp9-444');
    await turnAndCompare();
    const { inMotion, exact } = await turnAndCompare();
    const formats = moving().map((frame) => frame.format);
    expect(formats[0]).toBe('vp9-444');
    expect(formats[formats.length - 1]).toBe('jpeg');
    expect(difference(inMotion, exact)).toBeLessThan(3);
    expect(viewer.problems).toEqual([]);
  });

  test('a decoder that the browser takes away is replaced by one of the same format', async () => {
    await open(() => {
      const Real = VideoDecoder;
      const made: VideoDecoderInit[] = [];
      Object.assign(globalThis, {
        VideoDecoder: class extends Real {
          constructor(init: VideoDecoderInit) {
            super(init);
            made.push(init);
          }
        },
        takeAway: () => made[made.length - 1]?.error(new DOMException('reclaimed', 'QuotaExceededError')),
      });
    });
    await viewer.page.evaluate(() => (globalThis as unknown as { takeAway(): void }).takeAway());
    const { inMotion, exact } = await turnAndCompare();
    const last = moving().pop();
    expect(last?.format).toBe('vp9-444');
    expect(last?.streamId).toBeGreaterThan(1);
    expect(difference(inMotion, exact)).toBeLessThan(3);
  });
});
