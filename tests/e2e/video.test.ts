// Frames in motion as video in a real browser: what is negotiated, what becomes of colours, and what happens where it cannot be decoded.
import { existsSync } from 'node:fs';
import { resolve } from 'node:path';
import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, test } from 'vitest';
import type { Frame } from '../../web/src/lib/model';
import { binary, Server } from './server';
import { difference, drawnPixels, launch, Viewer, type Picture } from './viewer';

// Built for the tests where libavcodec's headers are.
const h264Module = resolve(binary, '../../tests/libisostrata_avcodec.so');

let server: Server;
let browser: Browser;
let viewer: Viewer;

beforeAll(async () => {
  server = await Server.start({ data: ['torus:48'], env: { ISOSTRATA_AVCODEC: existsSync(h264Module) ? h264Module : '' } });
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
  viewer = await Viewer.open(browser, server.ready.url, { before: [recordMoving, ...(before ? [before] : [])] });
  await viewer.until('layers', (state) => state.intervals.length > 0);
  await viewer.exactPicture();
}
const moving = (): Frame[] => viewer.events.flatMap((event) => (event.kind === 'frame' && event.frame.phase === 'moving' ? [event.frame] : []));
const offered = (): string[] => viewer.events.flatMap((event) => (event.kind === 'welcome' ? event.welcome.movingFormats : []));

/** Keeps what the page draws last from a VideoFrame, or of JPEG: in the page, before its own scripts. */
function recordMoving(): void {
  const draw = CanvasRenderingContext2D.prototype.drawImage as (...args: unknown[]) => void;
  CanvasRenderingContext2D.prototype.drawImage = function (this: CanvasRenderingContext2D, ...args: unknown[]) {
    draw.apply(this, args);
    const video = typeof VideoFrame !== 'undefined' && args[0] instanceof VideoFrame;
    if (video && this.canvas.isConnected)
      Object.assign(globalThis, {
        lastMoving: { id: (args[0] as VideoFrame).timestamp, image: this.getImageData(0, 0, this.canvas.width, this.canvas.height) },
      });
  };
}
async function lastMoving(): Promise<{ id: number; picture: Picture } | null> {
  const found = await viewer.page.evaluate(() => {
    const { lastMoving } = globalThis as unknown as { lastMoving?: { id: number; image: ImageData } };
    if (!lastMoving) return null;
    const { data, width, height } = lastMoving.image;
    let text = '';
    for (let i = 0; i < data.length; i += 0x8000) text += String.fromCharCode(...data.subarray(i, i + 0x8000));
    return { id: lastMoving.id, width, height, base64: btoa(text) };
  });
  if (!found) return null;
  const { id, width, height, base64 } = found;
  return { id, picture: { width, height, pixels: new Uint8Array(Buffer.from(base64, 'base64')) } };
}

async function turn(): Promise<Picture> {
  const { page } = viewer;
  await page.mouse.move(400, 300);
  await page.mouse.down();
  for (let i = 1; i <= 10; i++) {
    await page.mouse.move(400 + 12 * i, 300 + 4 * i);
    await page.waitForTimeout(25);
  }
  await page.mouse.up();
  return viewer.exactPicture();
}

/** Turns the picture until the last video frame shows what the exact picture shows: where drawing is slow, the hand may rest before. */
async function turnAndCompare(): Promise<{ inMotion: Picture; exact: Picture }> {
  for (let tries = 0; tries < 12; tries++) {
    const exact = await turn();
    const last = await lastMoving();
    const frame = moving().find(({ frameId }) => Number(frameId) === last?.id);
    if (last && frame?.revision === viewer.state.revision && last.picture.width === exact.width) return { inMotion: last.picture, exact };
  }
  throw new Error('no video frame of the newest state and of full size');
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
    for (const [i, frame] of frames.entries())  // a key frame where the size changes, and nowhere else
      expect(frame.key, `frame ${i}`).toBe(frame.width !== frames[i - 1]?.width);
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
    expect(moving().filter((frame) => frame.key).length).toBeGreaterThan(1); // a key frame of each size
    expect(viewer.problems).toEqual([]);
  });

  test.runIf(existsSync(h264Module))('a browser that lacks VP9 gets H.264, of odd sizes, too', async () => {
    viewer = await Viewer.open(browser, server.ready.url, {
      width: 1001,
      height: 703,
      before: [recordMoving, () => {
        const configure = VideoDecoder.prototype.configure;
        VideoDecoder.prototype.configure = function (config) {
          if (config.codec.startsWith('vp09')) throw new DOMException('no', 'NotSupportedError');
          configure.call(this, config);
        };
      }],
    });
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.exactPicture();
    expect(offered()).toEqual(['h264-420', 'jpeg']);
    const { inMotion, exact } = await turnAndCompare();
    expect(new Set(moving().map((frame) => frame.format))).toEqual(new Set(['h264-420']));
    expect(difference(inMotion, exact)).toBeLessThan(4);
    expect(viewer.problems).toEqual([]);
  });

  test('the picture at rest comes in bands and is the one that a script gets in one piece', async () => {
    await open();
    const exact = await turn();
    const bands = viewer.events.flatMap((event) => (event.kind === 'frame' && event.frame.band ? [event.frame] : []));
    expect(bands.length).toBeGreaterThan(1);
    for (const frame of bands) expect(frame.payload.length).toBeLessThanOrEqual(64 * 1024);
    const url = new URL(server.ready.url);
    const { width, height } = exact;
    const image = `api/v1/sessions/${viewer.sessionId}/image?width=${width}&height=${height}&token=${url.searchParams.get('token')}`;
    const whole = await viewer.page.evaluate(async (path) => {
      const bitmap = await createImageBitmap(await (await fetch(path)).blob());
      const canvas = document.createElement('canvas');
      canvas.width = bitmap.width;
      canvas.height = bitmap.height;
      const context = canvas.getContext('2d') as CanvasRenderingContext2D;
      context.drawImage(bitmap, 0, 0);
      return Array.from(context.getImageData(0, 0, canvas.width, canvas.height).data);
    }, image);
    expect(difference(exact, { width, height, pixels: new Uint8Array(whole) })).toBe(0);
  });

  test('a browser without WebCodecs, as on an insecure address, gets JPEG', async () => {
    await open(() => Reflect.deleteProperty(globalThis, 'VideoDecoder'));
    expect(offered()).toEqual(['jpeg']);
    expect(drawnPixels(await turn())).toBeGreaterThan(1000);
    expect(new Set(moving().map((frame) => frame.format))).toEqual(new Set(['jpeg']));
    expect(viewer.problems).toEqual([]);
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
    for (let i = 0; i < 3; i++) await turn();
    expect(drawnPixels(await turn())).toBeGreaterThan(1000);
    const formats = moving().map((frame) => frame.format);
    expect(formats[0]).toBe('vp9-444');
    expect(formats[formats.length - 1]).toBe('jpeg');
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
