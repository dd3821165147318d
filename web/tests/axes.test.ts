import { expect, test } from 'vitest';
import { asInFile, axisTitle, unitOf } from '../src/lib/axes';

const axis = (name: string, unit: string, downward = false) => ({ name, unit, downward });

test('an axis is called by its name, or its letter, with its unit', () => {
  const axes = [axis('longitude', 'degrees_east'), axis('', 'mm'), axis('', '')];
  expect([0, 1, 2].map((a) => axisTitle(axes, a as 0 | 1 | 2))).toEqual(['longitude (degrees_east)', 'y (mm)', 'z']);
  expect(axisTitle(undefined, 0)).toBe('x');
});

test('places are counted as in the file, and back', () => {
  const axes = [axis('', ''), axis('', ''), axis('depth', 'm', true)];
  expect(asInFile(axes, 2, -850)).toBe(850);
  expect(asInFile(axes, 2, asInFile(axes, 2, 12.5))).toBe(12.5);
  expect(Object.is(asInFile(axes, 2, 0), 0)).toBe(true);
  expect(asInFile(axes, 0, -850)).toBe(-850);
  expect(asInFile(undefined, 2, 1)).toBe(1);
});

test('volumes have the unit that all axes have, areas that of two', () => {
  const mm = [axis('', 'mm'), axis('', 'mm'), axis('', 'mm')];
  expect([1, 2, 3].map((power) => unitOf(mm, power as 1 | 2 | 3))).toEqual([' mm', ' mm²', ' mm³']);
  const sheet = [axis('', 'mm'), axis('', 'mm'), axis('', '')];
  expect([1, 2, 3].map((power) => unitOf(sheet, power as 1 | 2 | 3))).toEqual(['', ' mm²', '']);
  expect(unitOf([axis('', 'm'), axis('', 'mm'), axis('', 'm')], 3)).toBe('');
  expect(unitOf(undefined, 3)).toBe('');
});
