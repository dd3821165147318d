// The picture alone on the whole screen, the whole box, a step that is typed, and what the numbers of a layer are of.
import { copyFileSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Browser, Locator } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, test } from 'vitest';
import { netcdf } from './netcdf';
import { repository, Server } from './server';
import { launch, nearest, Viewer } from './viewer';

let server: Server;
let browser: Browser;
let viewer: Viewer;

const days = join(repository, 'build', 'e2e', 'days.nc');

beforeAll(async () => {
  mkdirSync(join(repository, 'build', 'e2e'), { recursive: true });
  const time = { name: 'time', dimensions: ['time'], attributes: { units: 'days since 2000-01-01', calendar: 'noleap' }, values: [0, 59, 365] };
  const wave = { name: 'wave', dimensions: ['time', 'z', 'y', 'x'], attributes: { units: 'm s-1' }, values: Array.from({ length: 3 * 216 }, (_, i) => Math.sin(i * 0.1)) };
  writeFileSync(days, netcdf({ time: 3, z: 6, y: 6, x: 6 }, [time, wave]));
  server = await Server.start({ data: ['cylinder:16x24x4x5', 'torus:32', days] });
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

async function open(dataset: RegExp, size: { width?: number; height?: number } = {}): Promise<void> {
  viewer = await Viewer.open(browser, server.ready.url, size);
  await viewer.until('layers', (state) => state.intervals.length > 0);
  const entry = viewer.events.flatMap((event) => (event.kind === 'welcome' ? event.welcome.datasets : [])).find(({ name }) => dataset.test(name))!;
  if (viewer.state.dataset !== entry.id) await viewer.page.getByLabel('Dataset').selectOption(entry.id);
  await viewer.until(entry.name, (state) => state.dataset === entry.id && state.intervals.length > 0);
  await viewer.exactPicture();
}

describe('the page’s tools', () => {
  test('F takes the whole screen for the picture and gives it back; not while a text is typed', async () => {
    await open(/torus/);
    const full = () => viewer.page.evaluate(() => document.fullscreenElement?.className ?? '');
    await viewer.page.getByLabel(/: name/).first().press('f');
    expect(await full()).toBe('');
    await viewer.page.getByRole('application').press('f');
    await expect.poll(full).toContain('picture');
    const { width, height } = await viewer.exactPicture();
    const screen = await viewer.page.evaluate(() => [innerWidth, innerHeight]);
    expect([width, height]).toEqual(screen);
    expect(await viewer.page.getByRole('button', { name: 'Full screen' }).getAttribute('aria-pressed')).toBe('true');
    await viewer.photograph('full-screen.png');
    await viewer.page.getByRole('button', { name: 'Full screen' }).click();
    await expect.poll(full).toBe('');
    expect(viewer.problems).toEqual([]);
  });

  test('a view is kept for its dataset, and one comes back to it after a reload, with the layers as they are; it is deleted', async () => {
    await open(/torus/);
    const { camera } = viewer.state;
    const button = viewer.page.getByRole('button', { name: 'Kept views' });
    const list = viewer.page.getByRole('region', { name: 'Kept views' });
    await button.click();
    await list.getByLabel('Name of the view to keep').fill('the hole');
    await list.getByLabel('Name of the view to keep').press('Enter');
    await list.getByRole('button', { name: 'the hole', exact: true }).waitFor();
    await viewer.photograph('kept-views.png');
    await viewer.page.keyboard.press('Escape');
    expect(await list.isVisible()).toBe(false);
    await viewer.page.getByRole('button', { name: 'View from +z' }).click();
    await viewer.page.getByRole('button', { name: 'Layer 1: visible' }).click();
    await viewer.until('another view', (state) => JSON.stringify(state.camera) !== JSON.stringify(camera) && state.intervals.some(({ visible }) => !visible));
    await viewer.page.reload();
    await viewer.exactPicture();
    await button.click();
    await list.getByRole('button', { name: 'the hole', exact: true }).click();
    const back = await viewer.until('the view', (state) => JSON.stringify(state.camera) === JSON.stringify(camera));
    expect(back.intervals.some(({ visible }) => !visible)).toBe(true);
    await viewer.page.getByLabel('Dataset').selectOption({ label: 'cylinder:16x24x4x5' });
    await expect.poll(() => list.getByRole('button', { name: 'the hole', exact: true }).count()).toBe(0);
    await viewer.page.getByLabel('Dataset').selectOption({ label: 'torus:32' });
    await list.getByRole('button', { name: 'the hole: delete' }).click();
    await expect.poll(() => list.getByRole('button').count()).toBe(1);
    expect(viewer.problems).toEqual([]);
  });

  test('the picture turns about its middle: quarters by button and R, freely by Alt and dragging', async () => {
    await open(/torus/);
    const application = viewer.page.getByRole('application');
    await viewer.page.getByRole('button', { name: 'View from +x' }).click();
    await viewer.until('from +x', ({ camera }) => camera?.up[2] === 1);
    await viewer.page.getByRole('button', { name: 'Turn the picture right' }).click();
    // From +x with z up, y is to the right: what was above is to the right if minus y is up.
    const right = await viewer.until('turned right', ({ camera }) => Math.abs(camera!.up[1] + 1) < 1e-9);
    await application.press('Shift+R');
    await viewer.until('turned back', ({ camera }) => Math.abs(camera!.up[2] - 1) < 1e-9);
    await application.press('r');
    await viewer.until('turned by R', ({ camera }) => Math.abs(camera!.up[1] + 1) < 1e-9);
    await viewer.page.getByRole('button', { name: 'Turn the picture left' }).click();
    await viewer.until('turned left', ({ camera }) => Math.abs(camera!.up[2] - 1) < 1e-9);
    const box = (await application.boundingBox())!;
    await viewer.page.keyboard.down('Alt');
    await viewer.dragFrom(box.x + box.width / 2, box.y + box.height / 2 - 150, 150, 150);
    await viewer.page.keyboard.up('Alt');
    const { camera } = await viewer.until('turned freely', (state) => Math.abs(state.camera!.up[1] + 1) < 0.02);
    expect(camera!.eye).toEqual(right.camera!.eye);
    expect(viewer.problems).toEqual([]);
  });

  test('? says what pointer and keys do, not while a text is typed', async () => {
    await open(/torus/);
    const help = viewer.page.getByRole('dialog', { name: 'Pointer and keys' });
    await viewer.page.getByLabel(/: name/).first().press('?');
    expect(await help.count()).toBe(0);
    await viewer.page.getByRole('application').press('?');
    await help.waitFor();
    await viewer.photograph('help.png');
    await viewer.page.keyboard.press('Escape');
    await expect.poll(() => help.count()).toBe(0);
    await viewer.page.getByRole('button', { name: 'Pointer and keys' }).click();
    await help.getByRole('button', { name: 'Close' }).click();
    await expect.poll(() => help.count()).toBe(0);
    expect(viewer.problems).toEqual([]);
  });

  test('Box shows the whole box from where one looks', async () => {
    await open(/torus/);
    const { camera } = viewer.state;
    await viewer.page.getByRole('application').press('+');
    for (let i = 0; i < 12; i++) await viewer.page.getByRole('application').press('+');
    await viewer.until('nearer', (state) => JSON.stringify(state.camera) !== JSON.stringify(camera));
    await viewer.exactPicture();
    const near = viewer.state.revision;
    await viewer.page.getByRole('button', { name: 'Whole box' }).click();
    await viewer.until('the box', (state) => state.revision > near);
    const { width, height } = await viewer.exactPicture();
    const ends = await viewer.page.locator('svg.overlay line.edge').evaluateAll((lines) =>
      lines.flatMap((line) => [['x1', 'y1'], ['x2', 'y2']].map((names) => names.map((name) => Number(line.getAttribute(name))))),
    );
    for (const [x, y] of ends as [number, number][]) {
      expect(x >= 0 && x <= width && y >= 0 && y <= height, `${x}, ${y}`).toBe(true);
    }
    expect(viewer.problems).toEqual([]);
  });

  test('a step is typed, and one that is not there is refused', async () => {
    await open(/cylinder/);
    const field = viewer.page.getByLabel(/^Step, of 5/);
    await field.fill('4');
    await field.press('Enter');
    await viewer.until('step 4', (state) => state.step === 3);
    await field.fill('9');
    await field.press('Enter');
    await expect.poll(() => viewer.page.getByText('Steps are 1 to 5.').count()).toBe(1);
    expect(viewer.state.step).toBe(3);
    await field.press('Escape');
    await viewer.page.getByLabel('Between steps').selectOption('interpolate');
    await viewer.until('between', (state) => state.timeMode === 'interpolate');
    const { time } = viewer.state;
    const at = viewer.page.getByRole('textbox', { name: 'Time', exact: true });
    await at.fill(String(Number(time) - 0.125));
    await at.press('Enter');
    await viewer.until('a time', (state) => state.time === Number(time) - 0.125);
    expect(viewer.problems).toEqual([]);
  });

  test('times that the file counts in days have dates, by its own calendar', async () => {
    await open(/days/);
    const slider = viewer.page.locator('#time-step');
    const field = viewer.page.getByLabel(/^Step, of 3/);
    for (const [step, date] of [[1, '2000-01-01'], [2, '2000-03-01'], [3, '2001-01-01']] as const) {
      await field.fill(String(step));
      await field.press('Enter');
      await viewer.until(`step ${step}`, (state) => state.step === step - 1);
      await expect.poll(() => viewer.page.locator('.time').innerText()).toContain(date);
      expect(await slider.getAttribute('aria-valuetext')).toContain(date);
    }
    await viewer.photograph('dates.png');
  });

  test('a value has its unit wherever it is read', async () => {
    await open(/days/);
    const { page } = viewer;
    expect(await page.getByLabel('Layers of').locator('option').allInnerTexts()).toEqual([expect.stringContaining('wave (m s-1)')]);
    await expect.poll(() => page.getByRole('region', { name: 'wave' }).innerText()).toMatch(/… [\d.]+ m s-1/);
    const viewport = page.getByRole('application');
    await viewport.click({ position: nearest(await viewer.exactPicture(), true) });
    const card = page.getByRole('region', { name: 'Values at this place' });
    await expect.poll(() => card.locator('.value').innerText()).toMatch(/wave\s+-?[\d.]+ m s-1/);
    await card.getByRole('button', { name: 'Over time' }).click();
    await expect.poll(() => page.getByRole('region', { name: 'Values over time' }).getByRole('slider').count()).toBe(1);
    await page.keyboard.press('Tab');
    await page.getByRole('slider', { name: /^wave over time/ }).press('ArrowRight');
    expect(await page.getByRole('slider', { name: /^wave over time/ }).getAttribute('aria-valuetext')).toMatch(/: -?[\d.]+ m s-1$/);
    await page.getByRole('button', { name: /: statistics$/ }).first().click();
    await expect.poll(() => page.getByRole('region', { name: /: statistics$/ }).innerText()).toMatch(/Mean\s+-?[\d.]+ m s-1/);
    await viewer.photograph('units.png');
    expect(viewer.problems).toEqual([]);
  });

  test('with forced colours the layers keep theirs, and what is pressed can be told from what is not', async () => {
    await open(/torus/);
    await viewer.page.emulateMedia({ forcedColors: 'active' });
    const style = (of: Locator, name: string) => of.evaluate((element, property) => getComputedStyle(element).getPropertyValue(property), name);
    const [first] = viewer.state.intervals;
    expect(await style(viewer.row(first!).locator('.swatch'), 'forced-color-adjust')).toBe('none');
    expect(await style(viewer.thumb(first!, 'lower'), 'forced-color-adjust')).toBe('none');
    const depth = viewer.page.getByRole('radio', { name: 'Depth' });
    const priority = viewer.page.getByRole('radio', { name: 'Priority' });
    for (const name of ['background-color', 'color']) expect(await style(depth, name)).not.toBe(await style(priority, name));
    await viewer.photograph('forced-colors.png');
  });

  test('with a cut the numbers of a layer are said to be of all of it', async () => {
    await open(/torus/);
    const words = () => viewer.page.getByText('of the whole layer, cuts aside').count();
    const volumes = () => viewer.page.locator('.facts [title^="Volume"]').evaluateAll((all) => all.map((of) => of.textContent?.split('±')[0]));
    const before = await volumes();
    expect(await words()).toBe(0);
    await viewer.page.getByRole('button', { name: 'Add cut' }).click();
    await viewer.until('a cut', (state) => state.clipPlanes?.length === 1);
    await viewer.exactPicture();
    expect(await words()).toBe(viewer.state.intervals.length);
    expect(await volumes()).toEqual(before);
    // Its place is typed as well.
    const place = viewer.page.getByRole('textbox', { name: 'Cut 1: place as a number' });
    await viewer.page.getByLabel('Cut 1: what is kept').selectOption('y<');
    await place.fill('0.123456');
    await place.press('Enter');
    await viewer.until('the cut there', ({ clipPlanes }) => clipPlanes?.[0]?.offset === -0.123456 && clipPlanes[0].normal[1] === -1);
    await place.fill('here');
    await place.press('Enter');
    await viewer.page.getByText('“here” is not a number.').waitFor();
    await viewer.photograph('cut-typed.png');
  });

  test('where the first file cannot be read the page begins with the next', async () => {
    const folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-first-'));
    writeFileSync(join(folder, 'a.vti'), '<?xml version="1.0"?><VTKFile type="ImageData" version="0.1"><ImageData');
    copyFileSync(days, join(folder, 'b.nc'));
    const other = await Server.start({ data: [folder] });
    try {
      viewer = await Viewer.open(browser, other.ready.url);
      await viewer.until('the second', (state) => state.dataset.startsWith('b-') && state.intervals.length > 0);
      await viewer.exactPicture();
      const first = viewer.events.flatMap((event) => (event.kind === 'welcome' ? event.welcome.datasets : [])).find(({ name }) => name === 'a.vti')!;
      await viewer.page.getByLabel('Dataset').selectOption(first.id); // asked for: what is wrong with it stays
      await expect.poll(() => viewer.page.getByRole('alert').getByText(/a\.vti/).count()).toBe(1);
      expect(viewer.state.dataset).toMatch(/^b-/);
    } finally {
      await viewer.close();
      await other.stop();
      rmSync(folder, { recursive: true });
    }
  });

  test('nothing is wider than a narrow window', async () => {
    for (const width of [320, 390, 700, 900]) {
      await open(/cylinder/, { width, height: 844 });
      expect(await viewer.page.evaluate(() => document.documentElement.scrollWidth), `${width}`).toBe(width);
      await viewer.photograph(`narrow-${width}.png`);
      if (width < 900) await viewer.close();
    }
  });
});
