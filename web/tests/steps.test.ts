import { expect, test } from 'vitest';
import { parseSteps, stepOfTime, stepsText, timeOfStep } from '../src/lib/steps';

test('steps are written as people count them, in the order they are painted', () => {
  expect(parseSteps('1, 3,5', 6)).toEqual([0, 2, 4]);
  expect(parseSteps('2-4 1', 6)).toEqual([1, 2, 3, 0]);
  expect(parseSteps('4-2', 6)).toEqual([3, 2, 1]);
  for (const text of ['', 'x', '0', '7', '1-7', '-1']) expect(typeof parseSteps(text, 6), text).toBe('string');
  expect(typeof parseSteps('1-100', 200)).toBe('string');
});

test('what is read is what was written', () => {
  for (const steps of [[0], [0, 1], [0, 1, 2], [4, 0, 1, 2, 3, 7], [3, 2, 1]]) expect(parseSteps(stepsText(steps), 9)).toEqual(steps);
  expect(stepsText([0, 1, 2, 5])).toBe('1-3, 6');
});

test('a place between two steps is a time, and back', () => {
  const times = [0, 2, 10, 10.5];
  expect(parseSteps('1, 2.5, 4', 4)).toEqual([0, 1.5, 3]);
  expect(parseSteps('.5', 4)).toMatch(/not there/);
  expect(parseSteps('4.5', 4)).toMatch(/not there/);
  for (const step of [0, 0.25, 1, 1.5, 2.75, 3]) expect(stepOfTime(timeOfStep(step, times), times)).toBeCloseTo(step, 12);
  expect(timeOfStep(1.5, times)).toBe(6);
  expect(stepsText([0, 1.5, 3])).toBe('1, 2.5, 4');
});
