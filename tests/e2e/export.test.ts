// A person takes the layers away as a mesh file, for another program.
import { spawnSync } from 'node:child_process';
import { copyFileSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { expect, test } from 'vitest';
import { binary, Server } from './server';
import { Stage } from './stage';
import { Viewer } from './viewer';

const stage = new Stage({ data: ['torus:32'] });
const button = (viewer: Viewer) => viewer.page.getByRole('button', { name: /^(Export|Writing…)$/ });

async function taken(viewer: Viewer, format: string): Promise<{ name: string; path: string }> {
  await viewer.page.getByLabel('What the mesh file holds').selectOption(format);
  const download = viewer.page.waitForEvent('download');
  await button(viewer).click();
  return { name: (await download).suggestedFilename(), path: await (await download).path() };
}

test('every format is written, one after the other; the tetrahedra are those that the page counts', async () => {
  const viewer = await stage.open();
  await viewer.until('layers', (state) => state.intervals.length > 0);
  await viewer.exactPicture();
  for (const [format, begins] of [['vtu', '<?xml'], ['vtkhdf', '\x89HDF'], ['ply', 'ply\n'], ['stl', 'interval boundary'], ['vtu', '<?xml'], ['ply', 'ply\n']] as const) {
    const { name, path } = await taken(viewer, format);
    expect(name).toBe(`isostrata-torus_32-distance-r${viewer.state.revision}.${format}`);
    expect(readFileSync(path).toString('latin1', 0, 40)).toContain(begins);
  }
  const folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-export-'));
  try {
    const file = join(folder, 'layers.vtu');
    copyFileSync((await taken(viewer, 'vtu')).path, file);
    const info = JSON.parse(spawnSync(binary, ['info', '--json', file], { encoding: 'utf8' }).stdout) as { cells: number };
    const counts = viewer.events.flatMap((event) => (event.kind === 'frame' && event.frame.intervals.length ? [event.frame.tetrahedra] : []));
    expect(info.cells).toBe(counts.at(-1));
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
  expect(viewer.problems).toEqual([]);
});

test('a file that comes slowly says how much has come, and is not saved if that is cancelled', async () => {
  const viewer = await stage.open();
  await viewer.until('layers', (state) => state.intervals.length > 0);
  await viewer.exactPicture();
  const client = await viewer.page.context().newCDPSession(viewer.page);
  await client.send('Network.enable');
  await client.send('Network.emulateNetworkConditions', { offline: false, latency: 0, downloadThroughput: 20_000, uploadThroughput: -1 });
  const downloads: string[] = [];
  viewer.page.on('download', (download) => downloads.push(download.suggestedFilename()));
  await button(viewer).click();
  const comes = viewer.page.getByRole('progressbar', { name: 'The mesh file comes over the line' });
  await expect.poll(async () => (await comes.count()) && (await comes.evaluate((bar: HTMLProgressElement) => bar.value > 0 && bar.value < bar.max && bar.max > 10_000))).toBe(true);
  await viewer.photograph('export-comes.png');
  await comes.locator('..').getByRole('button', { name: 'Cancel' }).click();
  await viewer.page.getByText('Cancelled.', { exact: true }).waitFor();
  expect(await comes.count()).toBe(0);
  await client.send('Network.emulateNetworkConditions', { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput: -1 });
  expect((await taken(viewer, 'stl')).name).toMatch(/\.stl$/);
  expect(downloads).toHaveLength(1);
});

test('a server that dies in the middle of it is told, and the page can export from the next one', async () => {
  const token = `export-${process.pid}`;
  let server = await Server.start({ data: ['torus:160'], token });
  const viewer = await Viewer.open(stage.browser, server.ready.url);
  try {
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.exactPicture();
    await button(viewer).click();
    await expect.poll(() => button(viewer).innerText()).toBe('Writing…');
    await server.stop('SIGKILL');
    await expect.poll(() => viewer.page.locator('.notice').allInnerTexts(), { timeout: 20_000 }).toContainEqual(expect.stringContaining('No mesh file: the connection was lost'));
    server = await Server.start({ data: ['torus:160'], token, port: server.ready.port });
    await expect.poll(() => button(viewer).isEnabled(), { timeout: 30_000 }).toBe(true);
    await viewer.exactPicture();
    expect((await taken(viewer, 'stl')).name).toMatch(/\.stl$/);
  } finally {
    await viewer.close();
    await server.stop();
  }
});
