// The paper's modes in the page: surfaces, cycles, smears, combined ranges, times between steps.
import { describe, expect, test } from 'vitest';
import type { Interval } from '../../web/src/lib/model';
import { Stage } from './stage';
import { difference, Viewer } from './viewer';

const stage = new Stage({ data: ['cylinder:24x24x8x4', 'torus:24'] });
let viewer: Viewer;

async function open(options: Parameters<typeof Viewer.open>[2] = {}): Promise<void> {
  viewer = await stage.open(options);
  await viewer.until('layers', (s) => s.intervals.length > 1);
  await viewer.exactPicture();
}
const paintBy = (word: string) => viewer.page.getByRole('radio', { name: word, exact: true }).click();

describe('the modes of the page', () => {
  test('a surface is switched on, changed and switched off again', async () => {
    await open();
    const [first] = (await viewer.layersOfOurOwn(1)) as [Interval];
    const before = await viewer.exactPicture();
    const row = viewer.row(first);
    await row.getByRole('button', { name: 'upper', exact: true }).click();
    await viewer.until('a surface', (s) => s.intervals[0]?.surface?.upper === true);
    const plain = await viewer.exactPicture();
    expect(difference(before, plain)).toBeGreaterThan(0.1);
    expect(await row.getByLabel(/surface silhouette/).count(), 'how it looks is out of the way until it is asked for').toBe(0);
    await row.getByRole('button', { name: /how its surface looks/ }).click();
    await row.getByLabel(/surface silhouette/).fill('1');
    await viewer.until('a silhouette', (s) => s.intervals[0]?.surface?.silhouette === 1);
    expect(difference(plain, await viewer.exactPicture())).toBeGreaterThan(0);
    await row.getByLabel(/surface texture/).selectOption('stripes');
    await viewer.until('a texture', (s) => s.intervals[0]?.surface?.texture === 'stripes');
    await expect.poll(() => viewer.page.getByLabel('Texture by').count()).toBe(1);
    await viewer.photograph('modes-surface.png');
    await row.getByRole('button', { name: 'upper', exact: true }).click();
    await viewer.until('no surface', (s) => s.intervals[0]?.surface?.upper === false);
    expect(difference(before, await viewer.exactPicture())).toBe(0);
    expect(viewer.problems).toEqual([]);
  });

  test('a cycle plays by itself, stands still when paused, and goes on by hand', async () => {
    await open();
    await viewer.layersOfOurOwn(3);
    await paintBy('Cycle');
    const seen = new Set<number>();
    await viewer.until('three phases', (s) => s.mode === 'cycled' && seen.add(s.cycle.phase).size >= 3);
    await viewer.page.getByRole('button', { name: 'Pause the cycle' }).click();
    const paused = await viewer.until('a pause', (s) => !s.cycle.playing);
    const before = await viewer.exactPicture();
    await viewer.page.waitForTimeout(1500);
    expect(viewer.state.revision).toBe(paused.revision);
    await viewer.page.getByRole('button', { name: 'Next layer' }).click();
    await viewer.until('the next', (s) => s.cycle.phase !== paused.cycle.phase);
    expect(difference(before, await viewer.exactPicture())).toBeGreaterThan(0);
    await viewer.photograph('modes-cycle.png');
  });

  test('for whom motion is too much a cycle waits to be played, and no cycle is faster than three a second', async () => {
    await open({ calm: true });
    await paintBy('Cycle');
    const waiting = await viewer.until('a cycle that waits', (s) => s.mode === 'cycled' && !s.cycle.playing);
    await viewer.page.waitForTimeout(1300);
    expect(viewer.state.cycle.phase).toBe(waiting.cycle.phase);
    const fastest = viewer.page.locator('#cycle-seconds');
    await fastest.fill((await fastest.getAttribute('min')) as string);
    const fast = await viewer.until('the fastest', (s) => s.cycle.seconds < 0.5);
    expect(fast.cycle.seconds).toBeGreaterThanOrEqual(1 / 3);
    await viewer.page.getByRole('button', { name: 'Play the cycle' }).click();
    await viewer.until('another phase', (s) => s.cycle.playing && s.cycle.phase !== waiting.cycle.phase);
    expect(viewer.problems).toEqual([]);
  });

  test('steps are smeared in the order and the colours that were said', async () => {
    await open({ width: 1400, height: 900 });
    const before = await viewer.exactPicture();
    await paintBy('Smear');
    await viewer.until('a smear', (s) => s.mode === 'smear');
    const steps = viewer.page.getByLabel('Steps', { exact: true });
    await steps.fill('1-3');
    await steps.blur();
    await viewer.until('three steps', (s) => s.smear.steps.join() === '0,1,2');
    expect(difference(before, await viewer.exactPicture())).toBeGreaterThan(0.1);
    await viewer.photograph('modes-smear.png');
    await steps.fill('9');
    await steps.blur();
    await expect.poll(() => viewer.page.getByRole('alert').allInnerTexts()).toContainEqual(expect.stringContaining('Step 9'));
    expect(viewer.state.smear.steps).toEqual([0, 1, 2]);
  });

  test('a range of another array is combined, and a time between steps is shown', async () => {
    await open({ width: 900, height: 700 });
    const before = await viewer.exactPicture();
    await viewer.page.getByRole('button', { name: /Combine with a range/ }).click();
    await viewer.until('a term', (s) => s.terms.length === 1 && s.terms[0]?.op === 'intersect');
    const both = await viewer.exactPicture();
    expect(difference(before, both)).toBeGreaterThan(0.05);
    await viewer.page.getByLabel('Term 1: operator').selectOption('subtract');
    await viewer.until('another operator', (s) => s.terms[0]?.op === 'subtract');
    expect(difference(both, await viewer.exactPicture())).toBeGreaterThan(0.05);
    await viewer.page.getByRole('button', { name: 'Term 1: delete' }).click();
    await viewer.until('no term', (s) => s.terms.length === 0);
    expect(difference(before, await viewer.exactPicture())).toBe(0);

    await viewer.page.getByLabel('Between steps').selectOption('interpolate');
    await viewer.until('a time', (s) => s.time !== null && s.timeMode === 'interpolate');
    await viewer.page.getByRole('slider', { name: 'Time' }).focus();
    await viewer.page.keyboard.press('Home');
    await viewer.until('the first time', (s) => s.time === 0);
    for (let i = 0; i < 20; i++) await viewer.page.keyboard.press('ArrowRight');
    await viewer.until('a later time', (s) => (s.time ?? 0) > 0);
    await viewer.exactPicture();
    await viewer.photograph('modes-time.png');
    await viewer.page.getByLabel('Between steps').selectOption('step');
    await viewer.until('steps again', (s) => s.time === null);
    expect(viewer.problems).toEqual([]);
  });
});
