// A person points at the picture and reads what is there, by mouse, key and finger.
import { describe, expect, test } from 'vitest';
import { Stage } from './stage';
import { nearest, type Viewer } from './viewer';

const stage = new Stage({ data: ['torus:48', 'mixed:9'] });
let viewer: Viewer;

const viewport = () => viewer.page.getByRole('application');
const card = () => viewer.page.getByRole('region', { name: 'Values at this place' });
const marker = () => viewer.page.locator('.marker');
/** What the card says behind a name. */
const said = (name: string) => card().locator('div', { has: viewer.page.locator(`dt:text-is("${name}")`) }).locator('dd').innerText();

describe('values at a place', () => {
  test('a click on the torus says the layer, the place and its value; it goes when the camera moves', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.layersOfOurOwn(1);
    const there = nearest(await viewer.exactPicture(), true);
    await viewport().click({ position: there });
    await expect.poll(() => card().getByText('distance').count()).toBe(1);
    const layer = viewer.state.intervals[0]!;
    const value = Number(await said('distance'));
    expect(value).toBeGreaterThanOrEqual(layer.lower - 1e-6);
    expect(value).toBeLessThanOrEqual(layer.upper + 1e-6);
    const [x, y, z] = [Number(await said('x')), Number(await said('y')), Number(await said('z'))] as [number, number, number];
    // The field there, by its formula: what the cell interpolates is near it.
    expect(Math.abs(Math.hypot(Math.hypot(x, y) - 0.6, z) - value)).toBeLessThan(0.01);
    expect(await card().locator('strong').innerText()).toMatch(/^Layer \d+$/);
    expect(await said('i, j, k of the cell')).toMatch(/^\d+, \d+, \d+$/);
    await viewer.photograph('probe.png');

    // What is said follows the layer under it.
    const revision = viewer.state.revision;
    await viewer.page.getByRole('button', { name: 'Close the values' }).click();
    await viewport().click({ position: there });
    await expect.poll(() => card().getByText('distance').count()).toBe(1);
    expect(viewer.state.revision).toBe(revision); // reading changes nothing
    await viewer.page.keyboard.press('Escape');
    expect(await card().count()).toBe(0);

    await viewport().click({ position: there });
    await expect.poll(() => marker().count()).toBe(1);
    await viewport().click({ position: there });
    expect(await card().count()).toBe(0); // another click on it closes it

    await viewport().click({ position: there });
    await expect.poll(() => card().getByText('distance').count()).toBe(1);
    await viewer.drag(viewport(), 60, 20);
    expect(await card().count()).toBe(0);
    expect(viewer.problems).toEqual([]);
  });

  test('a place comes to the middle and is what the picture turns about, also where an axis is drawn longer', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.layersOfOurOwn(1);
    const scale = viewer.page.getByLabel('Scale of z');
    await scale.fill('2');
    await scale.press('Enter');
    await viewer.until('a longer axis', (state) => state.axisScale?.[2] === 2);
    const there = nearest(await viewer.exactPicture(), true);
    await viewport().click({ position: there });
    await expect.poll(() => card().getByText('distance').count()).toBe(1);
    const value = await said('distance');
    const place = [Number(await said('x')), Number(await said('y')), 2 * Number(await said('z'))];
    const { eye, at } = viewer.state.camera!;
    await card().getByRole('button', { name: 'Turn about here' }).click();
    const { camera } = await viewer.until('another middle', (state) => JSON.stringify(state.camera!.at) !== JSON.stringify(at));
    place.forEach((of, i) => expect(camera!.at[i]).toBeCloseTo(of, 3));
    eye.forEach((of, i) => expect(camera!.eye[i]! - camera!.at[i]!).toBeCloseTo(of - at[i]!, 9));
    // What was read is in the middle now.
    const { width, height } = await viewer.exactPicture();
    await viewport().click({ position: { x: width / 2, y: height / 2 } });
    await expect.poll(() => card().getByText('distance').count()).toBe(1);
    expect(Number(await said('distance'))).toBeCloseTo(Number(value), 2);
    expect(viewer.problems).toEqual([]);
  });

  test('P reads under the pointer, the background says so, and the values can be copied', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
    await viewer.layersOfOurOwn(1);
    const picture = await viewer.exactPicture();
    const box = (await viewport().boundingBox())!;
    const nothing = nearest(picture, false), there = nearest(picture, true);
    await viewer.page.mouse.move(box.x + nothing.x, box.y + nothing.y);
    await viewer.page.keyboard.press('p');
    await expect.poll(() => card().innerText()).toMatch(/background/);
    await viewer.page.keyboard.press('Escape'); // the card may lie over the next place
    await viewer.page.mouse.move(box.x + there.x, box.y + there.y);
    await viewer.page.keyboard.press('p');
    await expect.poll(() => card().getByText('distance').count()).toBe(1);
    await card().getByRole('button', { name: 'Copy the values' }).click();
    await expect.poll(() => card().innerText()).toContain('Copied');
    const text = await viewer.page.evaluate(() => navigator.clipboard.readText());
    expect(text).toMatch(/^layer\tLayer \d+\nposition(\t-?[\d.e-]+){3}\ncell i j k/);
    expect(viewer.problems).toEqual([]);
  });

  test('a finger that rests reads, and a tap does not', async () => {
    viewer = await stage.open();
    await viewer.until('layers', (state) => state.intervals.length > 0);
    await viewer.layersOfOurOwn(1);
    const there = nearest(await viewer.exactPicture(), true);
    const box = (await viewport().boundingBox())!;
    const touch = { pointerType: 'touch', pointerId: 7, button: 0, clientX: box.x + there.x, clientY: box.y + there.y };
    // Chromium's own touch would need another kind of context; setPointerCapture wants a pointer that is there.
    await viewer.page.evaluate(() => (Element.prototype.setPointerCapture = () => undefined));
    await viewport().dispatchEvent('pointerdown', touch);
    await viewport().dispatchEvent('pointerup', touch);
    await viewer.page.waitForTimeout(700);
    expect(await card().count()).toBe(0);
    await viewport().dispatchEvent('pointerdown', touch);
    await expect.poll(() => card().getByText('distance').count()).toBe(1);
    await viewport().dispatchEvent('pointerup', touch);
    expect(await card().count()).toBe(1);
    expect(viewer.problems).toEqual([]);
  });
});
