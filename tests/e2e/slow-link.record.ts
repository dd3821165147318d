// The page at the end of a line of 80 ms and 2 Mb/s: a turned camera, a dragged interval, and rest after each. Writes screenshots, what the page
// showed as a WebM (where ffmpeg is there) and what the frames were, to build/slow-link or $ISOSTRATA_RECORD_TO.
// $ISOSTRATA_LINK: "ROUND_TRIP_MS MEGABITS" of another line; $ISOSTRATA_RECORD_DATA: other data than the paper's tapered cylinder.
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdirSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import type { CDPSession } from 'playwright-core';
import { expect, test } from 'vitest';
import type { Interval } from '../../web/src/lib/model';
import type { Frame } from '../../web/src/lib/told';
import { binary, repository, Server } from './server';
import { launch, Viewer } from './viewer';

const folder = resolve(repository, process.env.ISOSTRATA_RECORD_TO ?? 'build/slow-link');
const [roundTripMs, megabits] = (process.env.ISOSTRATA_LINK ?? '80 2').split(' ').map(Number) as [number, number];
const size = { width: 1280, height: 800 };

/** What the browser shows, as it shows it. Playwright's own recordVideo needs a program that only its browsers bring along. */
class Screencast {
  private readonly shots: { file: string; atMs: number }[] = [];
  private constructor(private readonly cdp: CDPSession) {}
  static async begin(viewer: Viewer): Promise<Screencast> {
    const cdp = await viewer.page.context().newCDPSession(viewer.page);
    const cast = new Screencast(cdp);
    mkdirSync(join(folder, 'shots'), { recursive: true });
    cdp.on('Page.screencastFrame', ({ data, metadata, sessionId }) => {
      const file = join(folder, 'shots', `${String(cast.shots.length).padStart(5, '0')}.jpg`);
      writeFileSync(file, Buffer.from(data, 'base64'));
      cast.shots.push({ file, atMs: (metadata.timestamp ?? 0) * 1000 });
      void cdp.send('Page.screencastFrameAck', { sessionId });
    });
    await cdp.send('Page.startScreencast', { format: 'jpeg', quality: 90, maxWidth: size.width, maxHeight: size.height });
    return cast;
  }
  /** The film's path; null if there is no ffmpeg, and the shots are left as they are. */
  async end(): Promise<string | null> {
    await this.cdp.send('Page.stopScreencast');
    await this.cdp.detach(); // what it has shown and not yet told is let go
    const { shots } = this;
    const lines = shots.map(({ file, atMs }, i) => `file '${file}'\nduration ${(((shots[i + 1]?.atMs ?? atMs + 1000) - atMs) / 1000).toFixed(4)}`);
    const list = join(folder, 'shots', 'list.txt');
    writeFileSync(list, lines.join('\n'));
    const film = join(folder, 'slow-link.webm');
    try {
      const codec = ['-c:v', 'libvpx-vp9', '-deadline', 'realtime', '-cpu-used', '8', '-crf', '36', '-b:v', '0', '-pix_fmt', 'yuv420p'];
      execFileSync('ffmpeg', ['-v', 'error', '-y', '-f', 'concat', '-safe', '0', '-i', list, '-vsync', 'vfr', ...codec, film]);
    } catch {
      return null;
    }
    rmSync(join(folder, 'shots'), { recursive: true });
    return film;
  }
}

/** What came between two moments. */
function summary(frames: Frame[], seconds: number): object {
  const first = frames.filter(({ band }) => !band || band.index === 0);
  const moving = first.filter(({ phase }) => phase === 'moving');
  const sizes = [...new Set(moving.map(({ width, height }) => `${width}x${height}`))];
  const bytes = moving.map(({ payload }) => payload.length).sort((a, b) => a - b);
  return {
    seconds: Number(seconds.toFixed(2)),
    moving: moving.length,
    movingPerSecond: Number((moving.length / seconds).toFixed(1)),
    sizes,
    formats: [...new Set(first.map(({ format, phase }) => `${format} ${phase}`))],
    medianBytes: bytes[Math.floor(bytes.length / 2)] ?? 0,
  };
}

test(`the page over ${roundTripMs} ms and ${megabits} Mb/s`, { timeout: 300_000 }, async () => {
  const program = join(dirname(binary), 'isostrata-shaped-link');
  if (!existsSync(program)) throw new Error(`${program} is not there: build the target isostrata-shaped-link`);
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  const server = await Server.start({ data: [process.env.ISOSTRATA_RECORD_DATA ?? 'cylinder'] });
  const link = spawn(program, [String(server.ready.port), String(roundTripMs), String(megabits)], { stdio: ['pipe', 'pipe', 'inherit'] });
  const port = await new Promise<string>((told) => link.stdout.once('data', (text) => told(String(text).trim())));
  const browser = await launch();
  try {
    const url = new URL(server.ready.url);
    url.port = port;
    const viewer = await Viewer.open(browser, url.href, size);
    const { page } = viewer;
    await viewer.until('layers', (state) => state.intervals.length > 0, 60_000);
    if (!process.env.ISOSTRATA_RECORD_DATA) await furnish(server, viewer);
    await viewer.exactPicture();

    const cast = await Screencast.begin(viewer);
    const parts: Record<string, object> = {};
    let mark = { events: viewer.events.length, atMs: Date.now() };
    const part = (name: string) => {
      const frames = viewer.events.slice(mark.events).flatMap((event) => (event.kind === 'frame' ? [event.frame] : []));
      parts[name] = summary(frames, (Date.now() - mark.atMs) / 1000);
      mark = { events: viewer.events.length, atMs: Date.now() };
    };
    const shot = (name: string) => page.screenshot({ path: join(folder, name) });

    // The camera, round and round.
    const box = await page.getByRole('application').boundingBox();
    if (!box) throw new Error('there is no picture');
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (let i = 1; i <= 200; i++) {
      await page.mouse.move(x + 120 * Math.sin(i / 20), y + 40 * Math.sin(i / 9));
      await page.waitForTimeout(25);
      if (i === 140) await shot('turning.png');
    }
    await page.mouse.up();
    part('turning');
    await viewer.exactPicture();
    await page.waitForTimeout(500);
    part('rest after turning');
    await shot('rest.png');

    // An end of an interval, to and fro.
    const thumb = await viewer.thumb(viewer.state.intervals[0] as Interval, 'upper').boundingBox();
    if (!thumb) throw new Error('there is no thumb');
    const [tx, ty] = [thumb.x + thumb.width / 2, thumb.y + thumb.height / 2];
    await page.mouse.move(tx, ty);
    await page.mouse.down();
    for (let i = 1; i <= 160; i++) {
      await page.mouse.move(tx - 30 + 30 * Math.cos(i / 18), ty);
      await page.waitForTimeout(25);
      if (i === 130) await shot('dragging.png');
    }
    await page.mouse.up();
    part('dragging');
    await viewer.exactPicture();
    await page.waitForTimeout(500);
    part('rest after dragging');
    await shot('rest-after-dragging.png');
    const film = await cast.end();
    const facts = { link: { roundTripMs, megabits }, device: server.ready.device, film: film ?? 'shots/ (no ffmpeg)', parts };
    writeFileSync(join(folder, 'frames.json'), JSON.stringify(facts, null, 2));
    console.log(`${folder}\n${JSON.stringify(facts, null, 2)}`);
    expect(viewer.problems).toEqual([]);
  } finally {
    await browser.close();
    link.stdin.end();
    await server.stop();
  }
});

/** Four intervals of density, as in the paper's Figure 4b. */
async function furnish(server: Server, viewer: Viewer): Promise<void> {
  const url = new URL(`api/v1/sessions/${viewer.sessionId}/state`, server.ready.url);
  const headers = { Authorization: `Bearer ${new URL(server.ready.url).searchParams.get('token')}`, 'Content-Type': 'application/json' };
  const rgb = (hex: number) => ({ r: (hex >> 16) / 255, g: ((hex >> 8) & 255) / 255, b: (hex & 255) / 255 });
  const layer = (lower: number, upper: number, color: number, opacity: number, priority: number) =>
    ({ lower, upper, color: rgb(color), opacity, priority, visible: true });
  const state = (await (await fetch(url, { headers })).json()) as object;
  const intervals = [
    layer(0.97, 0.9885, 0xe03020, 0.95, 3),
    layer(0.9885, 0.993, 0x30a040, 0.3, 2),
    layer(0.993, 0.9955, 0x3060e0, 0.08, 1),
    layer(1.0085, 1.012, 0xf0c020, 0.15, 0),
  ];
  const camera = { eye: { x: -6, y: -14, z: 20 }, at: { x: 3.9, y: 0.2, z: 2.9 }, up: { z: 1 }, fovDeg: 33 };
  const body = JSON.stringify({ ...state, array: 'Density', intervals, camera, unitDistance: 0.7 });
  const answer = await fetch(url, { method: 'PUT', headers, body });
  if (!answer.ok) throw new Error(await answer.text());
  await viewer.until('the layers', (s) => s.intervals.length === 4);
}
