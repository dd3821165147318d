import { expect, test } from 'vitest';
import { typedFactor } from '../src/lib/axis-scale';

test('a scale is a number above 0, in the ways that people write one', () => {
  for (const [text, factor] of [['50', 50], [' 0.1 ', 0.1], ['0,5', 0.5], ['×20', 20], ['x3', 3], ['1e-3', 0.001]] as const)
    expect(typedFactor(text), text).toBe(factor);
  for (const text of ['', 'abc', '0', '-2', 'inf', '1e13', '1,000,000', '1,234']) expect(typedFactor(text), text).toMatch(/is not a scale; expected a number above 0/);
});
