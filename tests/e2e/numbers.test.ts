// Numbers of the page that are read, typed and counted.
import { expect, test } from 'vitest';
import { decodeEvent } from '../../web/src/lib/events';
import { serverSays } from '../../web/tests/server-says';
import { Stage } from './stage';

const stage = new Stage({ data: ['torus:32'] });

test.for([[1280, 720], [375, 812], [320, 640]] as const)('the ends of a layer stand whole in their fields at %i x %i', async ([width, height]) => {
  const viewer = await stage.open({ width, height });
  await viewer.until('layers', (state) => state.intervals.length > 0);
  const [layer] = await viewer.layersOfOurOwn(1);
  const field = (end: string) => viewer.row(layer!).getByRole('textbox', { name: `${end} end` });
  const fits = (end: string) => field(end).evaluate((input) => input.scrollWidth <= input.clientWidth);
  for (const [lower, upper] of [['-1.2345e-30', '0.000123456'], ['0.000123456', '1000000.25'], ['0.12345678901234567', '0.12345678901234569']] as const) {
    for (const [end, text] of [['lower', '-1'], ['upper', upper], ['lower', lower]] as const) {
      await field(end).fill(text);
      await field(end).press('Enter');
      expect(await fits(end), text).toBe(true);
    }
    const state = await viewer.until(`${lower} … ${upper}`, ({ intervals: [now] }) => now?.lower === Number(lower) && now.upper === Number(upper));
    expect(state.intervals).toHaveLength(1);
    await field('lower').blur();
    for (const [end, text] of [['lower', lower], ['upper', upper]] as const) {
      expect(await fits(end), text).toBe(true);
      if (text.length <= 12) expect(await field(end).inputValue()).toBe(text);
    }
    if (upper === '1000000.25') await viewer.photograph(`long-ends-${width}.png`);
  }
  expect(await viewer.page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(width);
  expect(viewer.problems).toEqual([]);
});

test('a histogram that was cancelled says so in the plot, and is counted again by a button', async () => {
  const viewer = await stage.open({ blank: true });
  // The server is quicker than a hand: its first answer becomes the one to a cancelled question.
  let asked = 0;
  await viewer.page.routeWebSocket(/./, (socket) => {
    const server = socket.connectToServer();
    server.onMessage((message) => {
      const event = typeof message === 'string' ? null : decodeEvent(message);
      if (event?.kind !== 'histogram' || asked++) return socket.send(message);
      for (let seq = 1; seq < 40; seq++)
        socket.send(Buffer.from(serverSays({ case: 'error', value: { inReplyTo: BigInt(seq), code: 'cancelled', message: 'cancelled' } })));
    });
  });
  await viewer.page.goto(stage.server.ready.url);
  const plot = viewer.page.getByRole('region', { name: /./ }).filter({ has: viewer.page.getByRole('img', { name: /^Histogram of/ }) });
  await expect.poll(() => plot.innerText()).toContain('Not counted: Cancelled.');
  expect(await plot.innerText()).not.toContain('Counting');
  await viewer.photograph('histogram-cancelled.png');
  await plot.getByRole('button', { name: 'Count again' }).click();
  await expect.poll(() => plot.innerText()).toMatch(/\d.* values/);
  expect(await plot.innerText()).not.toContain('Not counted');
  expect(asked).toBe(2);
});
