// Windows as small as a zoom of 200 or 400 % makes them: everything is there, in one direction of scrolling.
import { expect, test } from 'vitest';
import { Stage } from './stage';

const stage = new Stage({ data: ['torus:32'] });

test.for([[320, 256], [640, 360], [640, 400], [900, 400]] as const)('in a window of %i x %i the picture is seen, and all else is reached', async ([width, height]) => {
  const viewer = await stage.open({ width, height });
  const { page } = viewer;
  await viewer.until('layers', (state) => state.intervals.length > 0);
  await viewer.exactPicture();
  const picture = page.getByRole('application');
  const buttons = page.getByRole('group', { name: 'Views' });
  const [whole, row] = [(await picture.boundingBox())!, (await buttons.boundingBox())!];
  expect(whole.height).toBeGreaterThanOrEqual(Math.min(240, height - 100));
  expect(row.height).toBeLessThan(36); // one row
  // What is read at a place stays in the picture, and what does not fit is scrolled to.
  await picture.focus();
  await page.keyboard.press('p');
  const card = page.locator('.probe');
  await card.getByText('distance').waitFor();
  const read = (await card.boundingBox())!;
  expect(read.y).toBeGreaterThanOrEqual(whole.y);
  expect(read.y + read.height).toBeLessThanOrEqual(whole.y + whole.height);
  await page.keyboard.press('Escape');
  // Each control can be brought into sight.
  for (const name of ['Add layer', 'Screenshot', 'Share', 'Export', 'Whole box']) {
    const control = page.getByRole('button', { name, exact: true });
    await control.scrollIntoViewIfNeeded();
    const at = (await control.boundingBox())!;
    expect(at.x >= 0 && at.x + at.width <= width && at.y >= 0 && at.y + at.height <= height, `${name} at ${JSON.stringify(at)}`).toBe(true);
  }
  if (width < 480) {
    await page.getByLabel('View from', { exact: true }).selectOption('+z');
    await viewer.until('the view from above', ({ camera }) => !!camera && camera.eye[2] > 2 && Math.abs(camera.eye[0]) < 0.1);
  }
  expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(width);
  await page.mouse.move(0, 0);
  await viewer.photograph(`small-${width}x${height}.png`);
  expect(viewer.problems).toEqual([]);
});
