// Frames in motion as video in a real browser: what is negotiated, what becomes of colours, and what happens if it cannot be decoded.
import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, test } from 'vitest';
import type { Frame } from '../../web/src/lib/told';
import { insideBlock, probeColor, probeSide, probeStream } from '../../web/src/lib/probe-stream';
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

/** codec: that the page holds on to, where its browser shows it; empty: by measured times. */
const address = (codec: string): string => `${server.ready.url}${codec && `&codec=${codec}`}`;
async function open(before?: () => void, codec = 'vp9-444'): Promise<void> {
  viewer = await Viewer.open(browser, address(codec), { before: [recordMoving, ...(before ? [before] : [])] });
  await viewer.until('layers', (state) => state.intervals.length > 0);
  await viewer.exactPicture();
}
const moving = (): Frame[] => viewer.events.flatMap((event) => (event.kind === 'frame' && event.frame.phase === 'moving' ? [event.frame] : []));
const isVideo = (frame: Frame): boolean => frame.format === 'vp9-444';
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

describe('video', () => {
  test('Chromium decodes VP9 4:4:4, gets it while something moves, and the picture at rest is exact', async () => {
    await open();
    expect(offered()).toContain('vp9-444');
    const { inMotion, exact } = await turnAndCompare();
    const frames = moving();
    const video = frames.filter(isVideo);
    expect(video.length).toBeGreaterThan(3);
    for (const [i, frame] of frames.entries()) {
      // Pictures by themselves come while an encoder is opened; then, as where the size changes, a key frame, and nowhere else.
      const before = frames[i - 1];
      if (isVideo(frame)) expect(frame.key, `frame ${i}`).toBe(!before || !isVideo(before) || before.width !== frame.width);
    }
    expect(drawnPixels(exact)).toBeGreaterThan(1000);
    expect(difference(inMotion, exact)).toBeLessThan(3);
    expect(viewer.problems).toEqual([]);
  });

  test('left to itself, the server sends what is shown sooner, and the foot of the page names it', async () => {
    await open(undefined, '');
    expect(offered()).toContain('vp9-444');
    for (let i = 0; i < 3; i++) await turn();
    const frames = moving();
    const last = frames[frames.length - 1] as Frame;
    expect(frames.length).toBeGreaterThan(5);
    expect(last.forecasts.map(({ format }) => format).sort()).toEqual(['jpeg', 'vp9-444']);
    const least = last.forecasts.reduce((a, b) => (b.ms < a.ms ? b : a));
    console.log(`${last.format}, of ${last.forecasts.map(({ format, ms }) => `${format} ${ms.toFixed(1)} ms`).join(', ')}`);
    for (const { format, ms } of last.forecasts) if (ms > 2 * least.ms) expect(last.format).not.toBe(format);
    const foot = viewer.page.locator('.status .codec');
    expect(await foot.getAttribute('data-format')).toBe(last.format);
    expect(await foot.innerText()).toBe(`${last.format === 'jpeg' ? 'JPEG' : 'VP9'} ${last.width}×${last.height}`);
    await viewer.photograph('codec.png');
    expect(viewer.problems).toEqual([]);
  });

  test('full chroma comes through the browser: saturated blocks keep their colours up to their edges', async () => {
    await open();
    const { format, codec, base64 } = probeStream;
    const pixels = await viewer.page.evaluate(
      ([codecName, text, side]) =>
        new Promise<number[]>((resolve, reject) => {
          const decoder = new VideoDecoder({
            output: (picture) => {
              const canvas = document.createElement('canvas');
              canvas.width = canvas.height = side;
              const context = canvas.getContext('2d') as CanvasRenderingContext2D;
              context.drawImage(picture, 0, 0);
              picture.close();
              resolve(Array.from(context.getImageData(0, 0, side, side).data));
            },
            error: reject,
          });
          decoder.configure({ codec: codecName, optimizeForLatency: true });
          const data = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
          decoder.decode(new EncodedVideoChunk({ type: 'key', timestamp: 1, data }));
        }),
      [codec, base64, probeSide] as const,
    );
    let inside = 0;
    let edges = 0;
    for (let i = 0; i < pixels.length; i++) {
      if (i % 4 === 3) continue;
      const [x, y] = [(i >> 2) % probeSide, Math.floor((i >> 2) / probeSide)];
      const apart = Math.abs((pixels[i] as number) - (probeColor(x, y)[i % 4] as number));
      if (!insideBlock(x, y)) edges = Math.max(edges, apart);
      else inside = Math.max(inside, apart);
    }
    console.log(`${format}: of 255 at most ${inside} wrong inside, ${edges} at edges`);
    expect(inside).toBeLessThanOrEqual(4);
    expect(edges).toBeLessThan(20);
  });

  test('another size of the window goes on in the same stream', async () => {
    await open();
    await turnAndCompare();
    await viewer.page.setViewportSize({ width: 903, height: 611 });
    await viewer.exactPicture();
    const { inMotion, exact } = await turnAndCompare();
    expect(difference(inMotion, exact)).toBeLessThan(3);
    expect(new Set(moving().filter(isVideo).map((frame) => frame.streamId)).size).toBe(1);
    expect(moving().filter((frame) => frame.key).length).toBeGreaterThan(1); // a key frame of each size
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
      const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
      let text = '';
      for (let i = 0; i < data.length; i += 0x8000) text += String.fromCharCode(...data.subarray(i, i + 0x8000));
      return btoa(text);
    }, image);
    expect(difference(exact, { width, height, pixels: new Uint8Array(Buffer.from(whole, 'base64')) })).toBe(0);
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
    expect(formats).toContain('vp9-444');
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
    await turnAndCompare(); // so that the last decoder is the stream's
    await viewer.page.evaluate(() => (globalThis as unknown as { takeAway(): void }).takeAway());
    const { inMotion, exact } = await turnAndCompare();
    const last = moving().pop();
    expect(last?.format).toBe('vp9-444');
    expect(last?.streamId).toBeGreaterThan(1);
    expect(difference(inMotion, exact)).toBeLessThan(3);
  });
});
