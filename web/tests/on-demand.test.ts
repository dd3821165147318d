import { expect, test } from 'vitest';
import { OnDemand } from '../src/lib/on-demand.svelte';

test('a part is asked for once, however many want it, and anew only if it did not come', async () => {
  let asked = 0;
  let lineIsDown = true;
  const of = new OnDemand(async () => {
    asked++;
    if (lineIsDown) throw new Error('no line');
    return 'the part';
  });
  expect(asked).toBe(0);
  of.want();
  of.want();
  await expect(of.get()).rejects.toThrow('no line');
  expect([asked, of.failures, of.part]).toEqual([1, 1, null]);
  of.want();
  await Promise.resolve();
  await expect(of.get()).rejects.toThrow('no line');
  expect(of.failures).toBeGreaterThan(1);
  lineIsDown = false;
  expect(await of.get()).toBe('the part');
  const until = asked;
  expect(await of.get()).toBe('the part');
  expect([asked, of.failures, of.part]).toEqual([until, 0, 'the part']);
});
