// The paper's kind of data on the page: four layers of a flow's density. The photograph is for looking at.
import { existsSync, mkdtempSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { afterAll, expect, test } from 'vitest';
import { writePlot3d } from './plot3d';
import { dataFolder, Server } from './server';
import { drawnPixels, launch, Viewer } from './viewer';

const folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-plot3d-'));
afterAll(() => rmSync(folder, { recursive: true, force: true }));
const bluntfin = join(dataFolder, 'plot3d_bluntfin', 'bluntfinxyz.bin');
const grids = [
  { name: 'a bent channel', grid: writePlot3d(folder, 'channel', [33, 17, 13]) },
  ...(existsSync(bluntfin) ? [{ name: 'the blunt fin', grid: bluntfin }] : []), // others' data, if it is there
];

test.each(grids)('four layers of $name in red, green, blue and yellow', async ({ grid }) => {
  const server = await Server.start({ data: [grid] });
  const browser = await launch();
  try {
    const viewer = await Viewer.open(browser, server.ready.url, { width: 1280, height: 800 });
    await viewer.until('the dataset', (state) => state.array !== '', 60_000);
    await viewer.page.getByLabel('Layers of').selectOption('Density');
    await viewer.until('Density', (state) => state.array === 'Density');
    const ends = [[0.4, 0.9], [1.02, 1.309], [1.309, 2.2], [2.2, 4.9775]] as const;
    const colors = ['#e6302a', '#24b04a', '#2a6df0', '#f5d020'];
    const layers = await viewer.layersOfOurOwn(4);
    // The upper ends first and from above, so that lower stays less than upper on the way.
    for (const [i, layer] of layers.entries()) {
      const row = viewer.row(layer);
      const type = async (end: 'lower' | 'upper', value: number) => {
        const field = row.getByRole('textbox', { name: new RegExp(`${end} end`) });
        await field.fill(String(value));
        await field.press('Enter');
      };
      const [lower, upper] = ends[i] as (typeof ends)[number];
      if (upper > layer.lower) {
        await type('upper', upper);
        await type('lower', lower);
      } else {
        await type('lower', lower);
        await type('upper', upper);
      }
      await row.locator('input[type=color]').fill(colors[i] as string);
      await row.getByRole('slider', { name: /opacity/ }).fill(String([0.1, 0.35, 0.6, 0.85][i]));
    }
    await viewer.until('the four layers', (state) =>
      ends.every(([lower, upper], i) => state.intervals[i]?.lower === lower && state.intervals[i]?.upper === upper),
    );
    const picture = await viewer.exactPicture();
    expect(drawnPixels(picture)).toBeGreaterThan(10_000);
    for (const [name, isIt] of [
      ['red', (r: number, g: number, b: number) => r > g + 25 && r > b + 25],
      ['green', (r: number, g: number, b: number) => g > r + 15 && g > b + 15],
      ['blue', (r: number, g: number, b: number) => b > r + 15 && b > g + 10],
      ['yellow', (r: number, g: number, b: number) => r > b + 25 && g > b + 25],
    ] as const) {
      let count = 0;
      for (let i = 0; i < picture.pixels.length; i += 4)
        if (isIt(picture.pixels[i] as number, picture.pixels[i + 1] as number, picture.pixels[i + 2] as number)) count++;
      expect(count, `${name} pixels`).toBeGreaterThan(50);
    }
    await viewer.page.waitForTimeout(300);
    const path = await viewer.photograph(`${basename(grid, '.bin')}.png`);
    expect(statSync(path).size).toBeGreaterThan(20_000);
    console.log(`photograph: ${path}`);
  } finally {
    await browser.close();
    await server.stop();
  }
});
