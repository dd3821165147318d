// A series that plays, on a clock that stands until it is moved.
import { expect, test } from 'vitest';
import { Playback } from '../src/lib/playback.svelte';
import { TickedClock } from './ticked';

function player(calm = false) {
  const clock = new TickedClock();
  const asked: { step: number; atMs: number }[] = [];
  const playback = new Playback({ go: (step) => asked.push({ step, atMs: clock.now }), now: () => clock.now, after: clock.after, calm: () => calm });
  return { clock, asked, playback };
}

test('no step is asked for before the one before is in the picture, and after the last comes the first', () => {
  const { clock, asked, playback } = player();
  playback.told(1, 3, true);
  playback.toggle();
  clock.advance(0);
  expect(asked.map((a) => a.step)).toEqual([2]);
  playback.told(2, 3, false);
  clock.advance(5000);
  expect(asked.length).toBe(1);
  playback.told(2, 3, true);
  clock.advance(0);
  expect(asked.map((a) => a.step)).toEqual([2, 0]);
});

for (const calm of [false, true])
  test(`steps come as fast as they may and no faster${calm ? ', with little motion three a second' : ''}`, () => {
    const { clock, asked, playback } = player(calm);
    playback.perSecond = 20;
    playback.told(0, 100, true);
    playback.toggle();
    for (let ms = 0; ms < 990; ms++) {
      clock.advance(1);
      if (asked.length) playback.told(asked.at(-1)!.step, 100, true);
    }
    expect(asked.length).toBe(calm ? 3 : 20);
    expect(asked.map((a) => a.step)).toEqual(asked.map((_, i) => i + 1));
  });

test('whoever stops it, or goes elsewhere, is not carried on', () => {
  const { clock, asked, playback } = player();
  playback.perSecond = 1;
  playback.told(0, 9, true);
  playback.toggle();
  clock.advance(0);
  playback.told(1, 9, true);
  playback.told(5, 9, false);
  clock.advance(2000);
  expect(asked.map((a) => a.step)).toEqual([1]);
  playback.told(5, 9, true);
  clock.advance(2000);
  expect(asked.map((a) => a.step)).toEqual([1, 6]);
  playback.told(6, 9, true);
  playback.toggle();
  clock.advance(2000);
  expect(asked.length).toBe(2);
});
