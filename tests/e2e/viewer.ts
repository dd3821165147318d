// One person at the page: a fresh browser profile, what the page and the server say to each other, and the picture as pixels.
import { chromium, type Browser, type BrowserContext, type Locator, type Page } from 'playwright-core';
import { mkdirSync } from 'node:fs';
import { join } from 'node:path';
import type { Interval, SceneState } from '../../web/src/lib/model';
import type { ServerEvent } from '../../web/src/lib/told';
import { decodeEvent } from '../../web/src/lib/events';
import { repository } from './server';

export interface Picture {
  width: number;
  height: number;
  pixels: Uint8Array; // rgba
}

export function launch(): Promise<Browser> {
  return chromium.launch({
    executablePath: process.env.ISOSTRATA_CHROMIUM ?? '/usr/bin/chromium',
    args: [
      '--no-sandbox',
      '--disable-gpu',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
    ],
  });
}

/** The mean difference of the colour channels, 0..255. Pictures of different sizes differ as much as can be. */
export function difference(a: Picture, b: Picture): number {
  if (a.width !== b.width || a.height !== b.height) return 255;
  let sum = 0;
  for (let i = 0; i < a.pixels.length; i += 4)
    for (let c = 0; c < 3; c++) sum += Math.abs((a.pixels[i + c] as number) - (b.pixels[i + c] as number));
  return sum / ((a.pixels.length / 4) * 3);
}

/** How many pixels differ from the top left one: 0 for an empty picture. */
export function drawnPixels(picture: Picture): number {
  const { pixels } = picture;
  let count = 0;
  for (let i = 0; i < pixels.length; i += 4)
    if ([0, 1, 2].some((c) => Math.abs((pixels[i + c] as number) - (pixels[c] as number)) > 6)) count++;
  return count;
}

/** The pixel nearest to the picture's middle that is drawn, or is not. */
export function nearest(picture: Picture, drawn: boolean): { x: number; y: number } {
  const { width, height, pixels } = picture;
  let best = { x: 0, y: 0, far: Infinity };
  for (let y = 8; y < height - 8; y++)
    for (let x = 8; x < width - 8; x++) {
      // Not at an edge: the eight around it are alike.
      const alike = [-8, 0, 8].every((dy) =>
        [-8, 0, 8].every((dx) => {
          const at = 4 * ((y + dy) * width + x + dx);
          return [0, 1, 2].some((c) => Math.abs((pixels[at + c] as number) - (pixels[c] as number)) > 6) === drawn;
        }),
      );
      const far = Math.hypot(x - width / 2, y - height / 2);
      if (alike && far < best.far) best = { x, y, far };
    }
  return best;
}

export class Viewer {
  readonly events: ServerEvent[] = [];
  readonly problems: string[] = [];
  readonly requests: string[] = [];

  private constructor(
    readonly page: Page,
    private readonly context: BrowserContext,
  ) {}

  static async open(
    browser: Browser,
    url: string,
    options: { width?: number; height?: number; colorScheme?: 'dark' | 'light'; calm?: boolean; before?: (() => void)[]; refines?: boolean; login?: { username: string; password: string }; blank?: boolean } = {},
  ): Promise<Viewer> {
    const context = await browser.newContext({
      viewport: { width: options.width ?? 1100, height: options.height ?? 760 },
      colorScheme: options.colorScheme ?? 'dark',
      reducedMotion: options.calm ? 'reduce' : 'no-preference',
      acceptDownloads: true,
      ...(options.login ? { httpCredentials: options.login } : {}),
    });
    const page = await context.newPage();
    for (const script of options.before ?? []) await page.addInitScript(script); // runs in the page before its own scripts
    const viewer = new Viewer(page, context);
    page.on('console', (message) => message.type() === 'error' && viewer.problems.push(message.text()));
    page.on('pageerror', (error) => viewer.problems.push(error.message));
    page.on('request', (request) => viewer.requests.push(request.url()));
    page.on('websocket', (socket) =>
      socket.on('framereceived', ({ payload }) => {
        if (typeof payload !== 'string') viewer.events.push(decodeEvent(payload));
      }),
    );
    const address = new URL(url);
    if (!options.refines) address.searchParams.set('samples', '1'); // pictures that are compared are the ones that `render` writes
    await page.goto(options.blank ? 'about:blank' : address.href);
    return viewer;
  }

  async close(): Promise<void> {
    await this.context.close();
  }

  /** The server's newest word, from the wire rather than from the page. */
  get state(): SceneState {
    for (const event of [...this.events].reverse()) {
      if (event.kind === 'state') return event.state;
      if (event.kind === 'welcome' && event.welcome.state) return event.welcome.state;
    }
    throw new Error('the server has not sent a state yet');
  }
  get sessionId(): string {
    const welcomes = this.events.flatMap((event) => (event.kind === 'welcome' ? [event.welcome.session] : []));
    return welcomes[welcomes.length - 1] ?? '';
  }

  /** Waits until `what` holds of the server's newest state. */
  async until(what: string, holds: (state: SceneState) => boolean, timeoutMs = 20_000): Promise<SceneState> {
    const begun = Date.now();
    for (;;) {
      const known = this.events.some((event) => event.kind === 'state' || event.kind === 'welcome');
      if (known && holds(this.state)) return this.state;
      if (Date.now() - begun > timeoutMs)
        throw new Error(`waited ${timeoutMs} ms for: ${what}; the state is ${known ? JSON.stringify(this.state) : 'not there'}`);
      await this.page.waitForTimeout(30);
    }
  }

  /** Waits for a lossless picture of the newest state in the viewport's size, and gives its pixels. */
  async exactPicture(timeoutMs = 60_000): Promise<Picture> {
    const begun = Date.now();
    for (;;) {
      const { picture, what } = await this.look(true);
      if (picture) return picture;
      if (Date.now() - begun > timeoutMs) throw new Error(`no exact picture after ${timeoutMs} ms: it is ${what}`);
      await this.page.waitForTimeout(50);
    }
  }
  async picture(): Promise<Picture> {
    const { picture } = await this.look(false);
    if (!picture) throw new Error('there is no picture');
    return picture;
  }
  /** What the canvas shows at one moment: another frame may be drawn between two looks. exact: nothing else counts as a picture. */
  private async look(exact: boolean): Promise<{ picture: Picture | null; what: string }> {
    // Not waitForFunction: it needs eval, which the page's policy forbids.
    const { width, height, base64, what } = await this.page.evaluate((onlyExact) => {
      const canvas = document.querySelector('canvas') as HTMLCanvasElement;
      const viewport = canvas.parentElement as HTMLElement;
      const { width, height } = canvas;
      const { phase, revision } = canvas.dataset;
      const newest = `${viewport.dataset.revision}${viewport.dataset.waits ? ' and of edits without an answer' : ''}`;
      const wanted = [viewport.clientWidth, viewport.clientHeight].map((n) => Math.floor(n * devicePixelRatio)).join('x');
      const what = `${phase} ${width}x${height} of revision ${revision}; expected exact ${wanted} of ${newest}`;
      const there = phase === 'exact' && revision === newest && `${width}x${height}` === wanted;
      if (onlyExact && !there) return { width, height, base64: '', what };
      const { data } = (canvas.getContext('2d') as CanvasRenderingContext2D).getImageData(0, 0, width, height);
      let text = '';
      for (let i = 0; i < data.length; i += 0x8000) text += String.fromCharCode(...data.subarray(i, i + 0x8000));
      return { width, height, base64: btoa(text), what };
    }, exact);
    return { picture: base64 ? { width, height, pixels: new Uint8Array(Buffer.from(base64, 'base64')) } : null, what };
  }

  /** Of a PNG, as this browser decodes it. */
  async pixels(png: Buffer): Promise<Picture> {
    const { width, height, base64 } = await this.page.evaluate(async (text) => {
      const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
      const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }), { colorSpaceConversion: 'none' });
      const canvas = new OffscreenCanvas(image.width, image.height);
      const context = canvas.getContext('2d') as OffscreenCanvasRenderingContext2D;
      context.drawImage(image, 0, 0);
      const { data } = context.getImageData(0, 0, image.width, image.height);
      let out = '';
      for (let i = 0; i < data.length; i += 0x8000) out += String.fromCharCode(...data.subarray(i, i + 0x8000));
      return { width: image.width, height: image.height, base64: btoa(out) };
    }, png.toString('base64'));
    return { width, height, pixels: new Uint8Array(Buffer.from(base64, 'base64')) };
  }

  thumb(interval: Interval, end: 'lower' | 'upper'): Locator {
    return this.page.locator(`.thumb.${end}[data-interval="${interval.id}"]`);
  }
  row(interval: Interval): Locator {
    return this.page.locator(`[data-layer="${interval.id}"]`);
  }

  /** In place of what was chosen for the dataset: so many layers as *Add layer* makes them, side by side, of one opacity and without surfaces. */
  async layersOfOurOwn(count: number): Promise<Interval[]> {
    for (const interval of this.state.intervals) await this.row(interval).getByRole('button', { name: /delete/ }).click();
    await this.until('no layers', (state) => state.intervals.length === 0);
    for (let there = 1; there <= count; there++) {
      await this.page.getByRole('button', { name: 'Add layer' }).click();
      await this.until(`layer ${there}`, (state) => state.intervals.length === there);
    }
    return this.state.intervals;
  }

  /** Presses the pointer in the middle of an element and moves it by so many pixels, in steps as a hand does. */
  async drag(target: Locator, dx: number, dy: number): Promise<void> {
    const box = await target.boundingBox();
    if (!box) throw new Error('there is nothing to drag');
    await this.dragFrom(box.x + box.width / 2, box.y + box.height / 2, dx, dy);
  }
  async dragFrom(x: number, y: number, dx: number, dy: number): Promise<void> {
    await this.page.mouse.move(x, y);
    await this.page.mouse.down();
    for (let i = 1; i <= 8; i++) {
      await this.page.mouse.move(x + (dx * i) / 8, y + (dy * i) / 8);
      await this.page.waitForTimeout(20);
    }
    await this.page.mouse.up();
  }

  /** For looking at: the whole page, as a file below build/. */
  async photograph(name: string): Promise<string> {
    const folder = join(repository, 'build', 'e2e');
    mkdirSync(folder, { recursive: true });
    const path = join(folder, name);
    await this.page.screenshot({ path });
    return path;
  }
}
