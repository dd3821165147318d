import { expect, test } from 'vitest';
import { filmOf, usualSeconds, type FilmChoice } from '../src/lib/film';

const size = { width: 1280, height: 720 };
const beside = { axes: true, box: false, legend: true };
const turn: FilmChoice = { turns: true, turnDeg: '360', plays: false, first: '1', last: '10', seconds: '' };
const play: FilmChoice = { ...turn, turns: false, plays: true };

test('a film is what the server takes', () => {
  expect(filmOf(turn, size, 1, beside)).toEqual({ ...size, annotations: beside, turnDeg: 360 });
  expect(filmOf({ ...turn, turnDeg: '-22,5', seconds: '2.5' }, size, 1, beside)).toEqual({ ...size, annotations: beside, turnDeg: -22.5, seconds: 2.5 });
  expect(filmOf(play, size, 10, beside)).toEqual({ ...size, annotations: beside, firstStep: 0, lastStep: 9 });
  expect(filmOf({ ...play, turns: true, first: '9', last: '2', seconds: '4' }, size, 10, beside)).toEqual({ ...size, annotations: beside, turnDeg: 360, firstStep: 8, lastStep: 1, seconds: 4 });
});

test('it takes six seconds, or a tenth of one for each step', () => {
  expect(usualSeconds(turn)).toBe(6);
  expect(usualSeconds({ ...play, turns: true })).toBe(6);
  expect(usualSeconds(play)).toBe(1);
  expect(usualSeconds({ ...play, first: '10', last: '1' })).toBe(1);
  expect(usualSeconds({ ...play, last: 'x' })).toBe(0.1);
});

test('what cannot be one is said in words', () => {
  for (const [choice, of, words] of [
    [{ ...turn, turns: false }, size, 'Choose what moves.'],
    [turn, 'Expected width x height, as 1920x1080.', 'Expected width x height, as 1920x1080.'],
    [turn, { width: 3841, height: 100 }, 'A film has at most 3840x2160 pixels: choose a size of its own.'],
    [{ ...turn, turnDeg: '0' }, size, 'Expected degrees to turn by, as 360 or -90, at most 36000.'],
    [{ ...turn, turnDeg: '' }, size, 'Expected degrees to turn by, as 360 or -90, at most 36000.'],
    [{ ...turn, turnDeg: '1e9' }, size, 'Expected degrees to turn by, as 360 or -90, at most 36000.'],
    [{ ...play, last: '11' }, size, 'Expected steps from 1 to 10.'],
    [{ ...play, first: '0' }, size, 'Expected steps from 1 to 10.'],
    [{ ...play, first: '1.5' }, size, 'Expected steps from 1 to 10.'],
    [{ ...turn, seconds: '0' }, size, 'Expected seconds from 0.1 to 3600.'],
    [{ ...turn, seconds: 'long' }, size, 'Expected seconds from 0.1 to 3600.'],
    [{ ...play, seconds: '0.1' }, size, '10 steps take at least 1 seconds.'],
  ] as const)
    expect(filmOf(choice, of, 10, beside)).toBe(words);
});
