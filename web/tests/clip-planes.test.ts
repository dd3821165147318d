import { describe, expect, it } from 'vitest';
import { firstPlane, offsetsIn, placeOf, planeAt, sideOf, sides } from '../src/lib/clip-planes';
import type { Box } from '../src/lib/model';

const box: Box = { lower: [-1, 0, 2], upper: [1, 10, 3] };

describe('clip planes', () => {
  it('say what they keep and where', () => {
    for (const side of sides) {
      const plane = planeAt(side, 0.25);
      expect(sideOf(plane)).toBe(side);
      expect(placeOf(plane)).toBe(0.25);
      const axis = 'xyz'.indexOf(side[0] as string);
      const kept = (at: number) => (plane.normal[axis] as number) * at >= plane.offset;
      expect(kept(0.3)).toBe(side.endsWith('>'));
      expect(kept(0.2)).toBe(side.endsWith('<'));
    }
    expect(sideOf({ normal: [1, 1, 0], offset: 0 })).toBeNull();
  });
  it('run over just the box', () => {
    expect(offsetsIn(planeAt('y<', 1), box)).toEqual({ lower: -10, upper: 0 });
    expect(offsetsIn({ normal: [1, 1, 0], offset: 0 }, box)).toEqual({ lower: -1, upper: 11 });
  });
  it('begin in the middle of the longest axis', () => {
    const plane = firstPlane(box);
    expect(sideOf(plane)).toBe('y<');
    expect(placeOf(plane)).toBe(5);
  });
});
