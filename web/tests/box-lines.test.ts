import { expect, test } from 'vitest';
import { boxLines } from '../src/lib/box-lines';
import type { Box, Camera, Vec3 } from '../src/lib/model';
import { seeded } from './random';

const box: Box = { lower: [-1, -2, -3], upper: [3, 2, 1] };

test('three edges of a box seen from outside and a corner are hidden, nine are seen', () => {
  const camera: Camera = { eye: [20, 15, 25], at: [1, 0, -1], up: [0, 1, 0], fovDeg: 30 };
  const { edges } = boxLines(camera, box, 800, 600);
  expect(edges).toHaveLength(12);
  expect(edges.filter((edge) => edge.hidden)).toHaveLength(3);
});

test('the labels stand outside the box on the screen', () => {
  const camera: Camera = { eye: [20, 15, 25], at: [1, 0, -1], up: [0, 1, 0], fovDeg: 30 };
  const { edges, labels } = boxLines(camera, box, 800, 600);
  expect(labels.filter((label) => label.kind === 'name').map((label) => label.text).sort()).toEqual(['x', 'y', 'z']);
  const xs = edges.flatMap((edge) => [edge.x1, edge.x2]);
  const z = labels.find((label) => label.kind === 'name' && label.text === 'y');
  expect(z && (z.x < Math.min(...xs) + 1 || z.x > Math.max(...xs) - 1)).toBe(true);
});

test('every number drawn is a number of the axis that it stands on', () => {
  for (let seed = 1; seed <= 40; seed++) {
    const random = seeded(seed);
    const far = () => (random() - 0.5) * 60;
    const camera: Camera = { eye: [far(), far(), far()], at: [1, 0, -1], up: [0.1, 1, 0.2], fovDeg: 30 };
    const { edges, labels, ticks } = boxLines(camera, box, 800, 600);
    for (const edge of edges)
      for (const x of [edge.x1, edge.y1, edge.x2, edge.y2]) expect(Number.isFinite(x), `seed ${seed}`).toBe(true);
    expect(ticks.length, `seed ${seed}`).toBeGreaterThanOrEqual(labels.filter((label) => label.kind === 'tick').length);
    for (const [i, a] of labels.entries())
      for (const b of labels.slice(0, i))
        if (a.kind === 'tick' && b.kind === 'tick') expect(Math.hypot(a.x - b.x, a.y - b.y), `seed ${seed}`).toBeGreaterThan(18);
    for (const label of labels) if (label.kind === 'tick') expect(Math.abs(Number(label.text)), `seed ${seed}`).toBeLessThanOrEqual(3);
  }
});

test('from inside nothing is called hidden and no label is drawn', () => {
  const camera: Camera = { eye: [1, 0, 0], at: [1, 0, -1], up: [0, 1, 0], fovDeg: 60 };
  const { edges, labels } = boxLines(camera, box, 800, 600);
  expect(edges.length).toBeGreaterThan(0);
  expect(edges.some((edge) => edge.hidden)).toBe(false);
  expect(labels).toEqual([]);
});

test('a flat box is drawn too', () => {
  const camera: Camera = { eye: [0, 0, 10], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 30 };
  const { edges } = boxLines(camera, { lower: [-1, -1, 0], upper: [1, 1, 0] }, 400, 400);
  expect(edges.every((edge) => Number.isFinite(edge.x1 + edge.y1 + edge.x2 + edge.y2))).toBe(true);
});

test('with parallel rays the box is as large wherever the eye stands on its line', () => {
  const near: Camera = { eye: [1, 0, 9], at: [1, 0, -1], up: [0, 1, 0], fovDeg: 60, orthographic: true };
  const { edges } = boxLines(near, box, 800, 600);
  const xs = edges.flatMap((edge) => [edge.x1, edge.x2]);
  // The box is 4 wide; 600 pixels show 2 * 10 * tan(30 degrees).
  expect(Math.max(...xs) - Math.min(...xs)).toBeCloseTo((4 * 600) / (20 * Math.tan(Math.PI / 6)), 6);
  expect(edges.filter((edge) => edge.hidden)).toHaveLength(8); // straight on, one face is seen
});

test('an axis that is drawn longer has the places of the dataset on it, and says how much longer', () => {
  const camera: Camera = { eye: [8, 6, 10], at: [1, 0, -1], up: [0, 1, 0], fovDeg: 30 };
  const plain = boxLines(camera, box, 800, 600);
  const drawn = boxLines(camera, { lower: box.lower, upper: box.upper }, 800, 600, [1, 1, 0.01]);
  expect(drawn.edges).toEqual(plain.edges);
  expect(drawn.labels.some((label) => label.text === 'z ×0.01')).toBe(true);
  const places = (of: typeof plain) => of.labels.filter((label) => label.kind === 'tick').map((label) => Math.abs(Number(label.text.replace('−', '-'))));
  expect(Math.max(...places(drawn))).toBeGreaterThan(50 * Math.max(...places(plain)));
});

test('while the camera is still that of a dataset a thousand billion billion times smaller, every line is a number', () => {
  const near: Camera = { eye: [3e-9, 2e-9, 1e-9], at: [0, 0, 0], up: [0, 1, 0.1], fovDeg: 30 };
  for (const size of [1e-9, 1, 1e12]) {
    const { edges, labels, ticks } = boxLines(near, { lower: [-size, 0.1 * size, -3 * size], upper: [size, 2 * size, 0.3 * size] }, 800, 600);
    for (const of of [...edges, ...ticks]) expect([of.x1, of.y1, of.x2, of.y2].every(Number.isFinite)).toBe(true);
    for (const of of labels) expect(Number.isFinite(of.x + of.y)).toBe(true);
  }
});

test('an axis has the name and the unit of the file, and numbers as it counts them', () => {
  const camera: Camera = { eye: [20, -25, 9], at: [1, 0, -1], up: [0, 0, 1], fovDeg: 30 };
  const factors: Vec3 = [1, 1, 0.005];
  const drawn: Box = { lower: [-1, -2, -5], upper: [3, 2, -0.5] };
  const axes = [
    { name: 'longitude', unit: 'degrees_east', downward: false },
    { name: '', unit: 'm', downward: false },
    { name: 'air pressure', unit: 'hPa', downward: true },
  ];
  const plain = boxLines(camera, drawn, 800, 600, factors);
  const named = boxLines(camera, drawn, 800, 600, factors, axes);
  expect(named.edges).toEqual(plain.edges);
  const names = named.labels.filter((label) => label.kind === 'name').map((label) => label.text);
  expect(names).toContain('longitude (degrees_east)');
  expect(names).toContain('y (m)');
  expect(names).toContain('air pressure (hPa) ×0.005');
  // The same place has the number times -1: pressure is highest below.
  const pressures = named.labels.filter((label) => label.kind === 'tick' && Math.abs(Number(label.text)) >= 100);
  expect(pressures.length).toBeGreaterThan(1);
  for (const { text, x, y } of pressures) {
    expect(Number(text)).toBeGreaterThan(0);
    expect(plain.labels.find((other) => other.x === x && other.y === y)?.text).toBe(`-${text}`);
  }
  const ys = pressures.sort((a, b) => Number(a.text) - Number(b.text)).map(({ y }) => y);
  expect(ys).toEqual([...ys].sort((a, b) => a - b));
});

test('a name that does not fit beside the box is its letter', () => {
  const camera: Camera = { eye: [20, 15, 25], at: [1, 0, -1], up: [0, 1, 0], fovDeg: 30 };
  const long = Array.from({ length: 3 }, () => ({ name: 'a name of which nobody can see the end in so narrow a picture', unit: '', downward: false }));
  const { labels } = boxLines(camera, box, 300, 300, [1, 1, 1], long);
  expect(labels.filter((label) => label.kind === 'name').map((label) => label.text).sort()).toEqual(['x', 'y', 'z']);
});
