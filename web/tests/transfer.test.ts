import { expect, test } from 'vitest';
import { mapRange, mapStops, placeIn } from '../src/lib/map-range';
import type { ColorRange, Interval, Range, SceneState, TransferPoint } from '../src/lib/model';
import type { ArrayInfo } from '../src/lib/told';
import { colorMapColors, colorMapGradient } from '../src/lib/color-maps';
import { command } from '../src/lib/commands';
import { addBeside, addPoint, curve, keyToPoint, lookAt, movePoint, removePoint, startPoints, stretched, withEnds } from '../src/lib/transfer';
import { seeded } from './random';

const axis: Range = { lower: 0, upper: 10 };
const layer: Interval = { id: 1, lower: 2, upper: 6, color: [1, 0, 0], colorMap: '', opacity: 0.5, priority: 0, visible: true };
const points: TransferPoint[] = [
  { value: 2, color: [1, 0, 0], opacity: 0 },
  { value: 4, color: [0, 0, 1], opacity: 0.75 },
  { value: 6, color: [0, 0, 1], opacity: 0.75 },
];

test('a function begins as the layer looks', () => {
  expect(startPoints(layer, axis).map(({ value, opacity }) => [value, opacity])).toEqual([
    [2, 0.5],
    [4, 0.5],
    [6, 0.5],
  ]);
  const mapped = startPoints({ ...layer, colorMap: '#000000-#ffffff', ownRange: true, opacityUpper: 0.75 }, axis);
  expect(mapped.map((p) => p.color[0])).toEqual([0, 0.25, 0.5, 0.75, 1]);
  expect(mapped[0]?.opacity).toBeCloseTo(0.5);
  expect(mapped[2]?.opacity).toBeCloseTo(1 - Math.sqrt(0.5 * 0.25)); // straight in extinction
  expect(startPoints({ ...layer, colorMap: '#000000-#ffffff' }, axis)[0]?.color[0]).toBeCloseTo(0.2); // over the array's range
});

test('a function of a colour map has at each point the colour that the map has there, over whatever range and by the logarithm too', () => {
  const array = { name: 'a', association: 'point', type: 'float32', components: 1, nanCount: 0, unit: '', steps: [{ lower: 1, upper: 9 }], lower: 0, upper: 100 } as ArrayInfo;
  const of = (more: Partial<ColorRange>, ownRange = false) => {
    const mapped = { ...layer, colorMap: '#000000-#ffffff', ownRange };
    const range = mapRange({ step: 0, colorRange: { span: 'step', lower: 0, upper: 0, log: false, ...more } } as SceneState, array, mapped);
    for (const { value, color } of startPoints(mapped, array, range)) expect(color[0]).toBeCloseTo(placeIn(range, value), 9);
    for (const { value, color } of mapStops(mapped.colorMap, range)) expect(color[0]).toBeCloseTo(placeIn(range, value), 9);
    return range;
  };
  expect(of({})).toEqual({ lower: 1, upper: 9, log: false });
  expect(of({ span: 'all_steps' })).toEqual({ lower: 0, upper: 100, log: false });
  expect(of({ span: 'all_steps', log: true })).toEqual({ lower: 0.01, upper: 100, log: true });
  expect(of({ span: 'own', lower: 2, upper: 4 })).toEqual({ lower: 2, upper: 4, log: false });
  expect(of({ span: 'own', lower: 2, upper: 4, log: true }, true)).toEqual({ lower: 2, upper: 6, log: true });
  expect(placeIn({ lower: 1, upper: 100, log: true }, 10)).toBeCloseTo(0.5, 12);
  expect([-5, 0, 1000].map((value) => placeIn({ lower: 1, upper: 100, log: true }, value))).toEqual([0, 0, 1]);
});

test('a map that is named the other way round has its colours so', () => {
  expect(colorMapColors('viridis_r')).toEqual([...colorMapColors('viridis')!].reverse());
  expect(colorMapGradient('gray_r')).toBe('linear-gradient(to right, #ffffff, #000000)');
  expect([colorMapColors('jet_r'), colorMapColors('_r')]).toEqual([null, null]);
});

test('between points colour and extinction are straight', () => {
  const look = lookAt(points, 3);
  expect(look.color).toEqual([0.5, 0, 0.5]);
  expect(look.opacity).toBeCloseTo(0.5); // half of -ln(1/4) is -ln(1/2)
  const drawn = curve(points, (v) => v, (o) => o);
  expect(drawn[0]).toEqual([2, 0]);
  expect(drawn.find(([x]) => x === 3)?.[1]).toBeCloseTo(0.5);
  expect(drawn[drawn.length - 1]).toEqual([6, 0.75]);
});

test('points stop at their neighbours and at the axis, and leave the layer some width', () => {
  expect(movePoint(points, 1, 99, 2, axis)[1]).toMatchObject({ value: 6, opacity: 1 });
  expect(movePoint(points, 1, -99, -1, axis)[1]).toMatchObject({ value: 2, opacity: 0 });
  expect(movePoint(points, 0, -99, 0, axis)[0]?.value).toBe(0);
  const [first, last] = [movePoint(points.slice(0, 2), 0, 99, 0, axis)[0], points[1]];
  expect(first?.value).toBeLessThan(last?.value ?? 0);
});

test('whatever is done to a function, its values never fall and its ends differ', () => {
  const random = seeded(7);
  let now = points;
  for (let i = 0; i < 2000; i++) {
    const index = Math.floor(random() * now.length);
    const what = random();
    if (what < 0.6) now = movePoint(now, index, random() * 14 - 2, random() * 1.4 - 0.2, axis);
    else if (what < 0.75) now = addBeside(now, index)?.points ?? now;
    else if (what < 0.9) now = removePoint(now, index) ?? now;
    else now = stretched(now, random() * 4, 5 + random() * 5);
    expect(now.every((p, k) => k === 0 || p.value >= (now[k - 1] as TransferPoint).value)).toBe(true);
    expect((now[0] as TransferPoint).value).toBeLessThan((now[now.length - 1] as TransferPoint).value);
    expect(now.every((p) => p.opacity >= 0 && p.opacity <= 1)).toBe(true);
    if (now.length > 40) now = points;
  }
});

test('points are added where they were meant, and the last two stay', () => {
  expect(addPoint(points, 3, 0.9)?.points[1]).toMatchObject({ value: 3, opacity: 0.9, color: [0.5, 0, 0.5] });
  expect(addPoint(points, 7)).toBeNull();
  expect(addBeside(points, 2)?.index).toBe(2);
  expect(removePoint(points.slice(0, 2), 0)).toBeNull();
});

test('keys move a point along values and opacities', () => {
  const point = points[1] as TransferPoint;
  expect(keyToPoint('ArrowRight', false, point, axis)?.value).toBeGreaterThan(4);
  expect(keyToPoint('ArrowUp', false, point, axis)?.opacity).toBeCloseTo(0.77);
  expect(keyToPoint('End', false, point, axis)).toEqual({ value: 4, opacity: 1 });
  expect(keyToPoint('x', false, point, axis)).toBeNull();
});

test('a patch carries the whole function, and null ends it', () => {
  const body = command.patchInterval(3, { transfer: points });
  expect(body).toMatchObject({ value: { transferFunction: { points: [{ value: 2 }, { value: 4 }, { value: 6, opacity: 0.75 }] } } });
  expect(command.patchInterval(3, { transfer: null })).toMatchObject({ value: { transferFunction: { points: [] } } });
  expect(command.patchInterval(3, { opacity: 1 }).value).not.toHaveProperty('transferFunction');
});

test('whatever a patch moves, a layer’s ends and its function stay together', () => {
  const random = seeded(21);
  const own = { ...layer, transfer: points };
  for (let i = 0; i < 200; i++) {
    const lower = random() * 4;
    const patch = [{ lower }, { upper: 5 + random() * 5 }, { lower, upper: 5 }, { transfer: stretched(points, lower, 9) }][i % 4] ?? {};
    const after = { ...own, ...withEnds(own, patch) };
    expect(after).toMatchObject(patch);
    expect([after.transfer?.[0]?.value, after.transfer?.[2]?.value]).toEqual([after.lower, after.upper]);
  }
  expect(withEnds(own, { opacity: 0.5 })).toEqual({ opacity: 0.5 });
  expect(withEnds(own, { transfer: null, lower: 1 })).toEqual({ transfer: null, lower: 1 }); // it ends
  expect(withEnds(layer, { lower: 1 })).toEqual({ lower: 1 });
});
