// A layer's transfer function in the page: points on the histogram, by pointer and by keyboard.
import { describe, expect, test } from 'vitest';
import type { SceneState } from '../../web/src/lib/model';
import { Stage } from './stage';
import { difference, Viewer } from './viewer';

const stage = new Stage({ data: ['torus:24'] });
let viewer: Viewer;

const points = (state: SceneState) => state.intervals[0]?.transfer ?? [];

describe('a transfer function', () => {
  test('begins as the layer looked, is drawn by hand and ends again', async () => {
    viewer = await stage.open();
    const [layer] = (await viewer.until('layers', (s) => s.intervals.length > 1)).intervals;
    if (!layer) throw new Error('no layer');
    const before = await viewer.exactPicture();
    const row = viewer.row(layer);
    const colors = row.getByLabel('colour or colour map');
    await colors.selectOption({ label: 'function' });
    const begun = await viewer.until('a function', (s) => points(s).length === 3);
    expect(points(begun)[0]?.value).toBe(layer.lower);
    expect(points(begun)[2]?.value).toBe(layer.upper);
    expect(difference(before, await viewer.exactPicture())).toBeLessThan(0.1); // as it looked

    const point = (i: number) => viewer.page.locator(`.point[data-interval="${layer.id}"][data-point="${i}"]`);
    await viewer.drag(point(1), 0, -40);
    const dragged = await viewer.until('a denser middle', (s) => (points(s)[1]?.opacity ?? 0) > layer.opacity + 0.2);
    expect(dragged.intervals.map((i) => [i.lower, i.upper])).toEqual(begun.intervals.map((i) => [i.lower, i.upper]));

    await point(2).focus();
    await viewer.page.keyboard.press('Home'); // transparent where the layer ends
    await viewer.until('a fading end', (s) => points(s)[2]?.opacity === 0);
    await viewer.page.keyboard.press('Insert');
    await viewer.until('one point more', (s) => points(s).length === 4);
    await expect.poll(() => viewer.page.evaluate(() => (document.activeElement as HTMLElement).dataset.point)).toBe('2');
    await row.getByLabel('colour of point 3').fill('#2060ff');
    await viewer.until('a blue point', (s) => Math.abs((points(s)[2]?.color[2] ?? 0) - 1) < 0.01);
    await expect.poll(() => point(2).getAttribute('aria-valuetext')).toMatch(/opacity \d+ % at/);

    const curve = await viewer.page.locator('.plot').boundingBox();
    const [left, right] = await Promise.all([point(0).boundingBox(), point(1).boundingBox()]);
    if (!curve || !left || !right) throw new Error('nothing to double-click');
    await viewer.page.mouse.dblclick((left.x + right.x) / 2 + 10, curve.y + 20);
    const added = await viewer.until('a point by double click', (s) => points(s).length === 5);
    expect(points(added)[1]?.opacity).toBeGreaterThan(0.7);
    expect(difference(before, await viewer.exactPicture())).toBeGreaterThan(0.1);
    await viewer.photograph('transfer.png');
    await point(1).focus();
    await viewer.page.keyboard.press('Delete');
    await viewer.until('one point less', (s) => points(s).length === 4);

    // The layer's end takes the points along.
    await viewer.thumb(layer, 'upper').focus();
    await viewer.page.keyboard.press('PageDown');
    const shorter = await viewer.until('a shorter layer', (s) => (s.intervals[0]?.upper ?? 0) < layer.upper);
    expect(points(shorter)[3]?.value).toBe(shorter.intervals[0]?.upper);
    expect(points(shorter)[2]?.value).toBeLessThan(points(added)[3]?.value ?? 0);

    await colors.selectOption({ label: 'one colour' });
    const ended = await viewer.until('no function', (s) => s.intervals[0]?.transfer === null);
    expect(ended.intervals[0]?.opacity).toBe(layer.opacity); // what it was before comes back
    expect(viewer.problems).toEqual([]);
  });

  test('begins as a layer looked whose colours run over numbers of one’s own; the histogram has the colours, too', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (s) => s.intervals.length > 1);
    const [layer] = await viewer.layersOfOurOwn(1);
    const colors = viewer.row(layer!).getByLabel('colour or colour map');
    await colors.selectOption('viridis');
    await viewer.page.getByLabel('Colours over').selectOption('own');
    const { lower, upper } = (await viewer.until('own numbers', (s) => s.colorRange?.span === 'own')).colorRange!;
    const end = viewer.page.getByLabel('Colours end at');
    await end.fill(String(2 * upper - lower));
    await end.press('Enter');
    await viewer.until('others', (s) => s.colorRange!.upper > upper);
    const before = await viewer.exactPicture();
    const stops = await viewer.page.locator('.plot linearGradient stop').evaluateAll((all) => all.map((stop) => stop.getAttribute('stop-color')));
    expect([stops[0], stops.at(-1)]).toEqual(['#440154', '#fde725']);
    await viewer.photograph('histogram-of-a-map.png');
    await colors.selectOption({ label: 'function' });
    await viewer.until('a function', (s) => points(s).length > 2);
    const after = await viewer.exactPicture();
    expect(difference(before, after)).toBeLessThan(0.5);
    // Beside what another range looks like.
    await colors.selectOption('viridis');
    await viewer.page.getByLabel('Colours over').selectOption('step');
    await viewer.until('the step’s', (s) => s.colorRange?.span === 'step' && points(s).length === 0);
    expect(difference(before, await viewer.exactPicture())).toBeGreaterThan(2 * difference(before, after));
    expect(viewer.problems).toEqual([]);
  });
});
