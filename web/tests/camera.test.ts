import { describe, expect, test } from 'vitest';
import { boxInView, projectSegment, rescaled, sameCamera, screenFromView, viewAxes, viewFromWorld, worldPerPixel } from '../src/lib/camera';
import type { Camera, Vec3 } from '../src/lib/model';
import { dolly, orbit, pan, roll, rollBy, wheelFactor } from '../src/lib/trackball';
import { add, cross, dot, length, normalize, scale, sub } from '../src/lib/vec';
import { seeded } from './random';

function randomCamera(random: () => number): Camera {
  const vector = (): Vec3 => [random() - 0.5, random() - 0.5, random() - 0.5];
  const eye = scale(vector(), 20);
  return { eye, at: scale(vector(), 4), up: normalize(vector()), fovDeg: 20 + 60 * random() };
}
const project = (camera: Camera, w: number, h: number, p: Vec3) =>
  screenFromView(camera, w, h, viewFromWorld(camera, viewAxes(camera), p));

describe('the camera', () => {
  test('has right-handed, orthonormal axes', () => {
    for (let seed = 1; seed <= 50; seed++) {
      const { right, up, back } = viewAxes(randomCamera(seeded(seed)));
      for (const axis of [right, up, back]) expect(length(axis), `seed ${seed}`).toBeCloseTo(1, 12);
      expect(dot(cross(right, up), back), `seed ${seed}`).toBeCloseTo(1, 12);
    }
  });

  test('puts what it looks at in the middle of the screen', () => {
    for (let seed = 1; seed <= 50; seed++) {
      const camera = randomCamera(seeded(seed));
      const [x, y] = project(camera, 640, 480, camera.at);
      expect(x, `seed ${seed}`).toBeCloseTo(320, 6);
      expect(y, `seed ${seed}`).toBeCloseTo(240, 6);
    }
  });

  test('shows the full vertical angle from the top to the bottom edge, whatever the width', () => {
    for (const width of [200, 600, 1500]) {
      const camera: Camera = { eye: [0, 0, 10], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 40 };
      const top = 10 * Math.tan((20 * Math.PI) / 180);
      expect(project(camera, width, 600, [0, top, 0])[1]).toBeCloseTo(0, 9);
      expect(project(camera, width, 600, [0, -top, 0])[1]).toBeCloseTo(600, 9);
      // x to the right, y up
      expect(project(camera, width, 600, [1, 0, 0])[0]).toBeGreaterThan(width / 2);
      expect(worldPerPixel(camera, 600) * 600).toBeCloseTo(2 * top, 9);
    }
  });

  test('cuts lines at the eye instead of drawing them mirrored', () => {
    const camera: Camera = { eye: [0, 0, 1], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 40 };
    const axes = viewAxes(camera);
    expect(projectSegment(camera, axes, 100, 100, [0, 0, 2], [1, 0, 3])).toBeNull();
    const through = projectSegment(camera, axes, 100, 100, [0.1, 0, -5], [0.1, 0, 5]);
    expect(through).not.toBeNull();
    for (const [x] of through ?? []) expect(x).toBeGreaterThan(50); // stays on the side it is on
  });
});

describe('the trackball', () => {
  test('keeps the distance and what is looked at while it turns', () => {
    for (let seed = 1; seed <= 50; seed++) {
      const random = seeded(seed);
      let camera = randomCamera(random);
      const before = camera;
      for (let i = 0; i < 20; i++) {
        const point = () => ({ x: random() * 800, y: random() * 600 });
        camera = orbit(camera, point(), point(), 800, 600);
      }
      expect(camera.at, `seed ${seed}`).toEqual(before.at);
      expect(length(sub(camera.eye, camera.at)), `seed ${seed}`).toBeCloseTo(length(sub(before.eye, before.at)), 9);
      expect(Math.abs(dot(camera.up, normalize(sub(camera.eye, camera.at)))), `seed ${seed}`).toBeLessThan(1e-9);
    }
  });

  test('turns the scene with the pointer: what faces the viewer goes where the pointer goes', () => {
    const camera: Camera = { eye: [0, 0, 10], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 30 };
    const front: Vec3 = [0, 0, 1];
    const right = orbit(camera, { x: 400, y: 300 }, { x: 440, y: 300 }, 800, 600);
    expect(project(right, 800, 600, front)[0]).toBeGreaterThan(401);
    const down = orbit(camera, { x: 400, y: 300 }, { x: 400, y: 340 }, 800, 600);
    expect(project(down, 800, 600, front)[1]).toBeGreaterThan(301);
  });

  test('comes back when the drag is undone', () => {
    for (let seed = 1; seed <= 30; seed++) {
      const random = seeded(seed);
      const camera = randomCamera(random);
      const level = { ...camera, up: viewAxes(camera).up };
      const a = { x: random() * 800, y: random() * 600 };
      const b = { x: random() * 800, y: random() * 600 };
      const back = orbit(orbit(level, a, b, 800, 600), b, a, 800, 600);
      expect(length(sub(back.eye, level.eye)), `seed ${seed}`).toBeLessThan(1e-6);
      expect(length(sub(back.up, level.up)), `seed ${seed}`).toBeLessThan(1e-6);
    }
  });

  test('pans so that what is looked at stays under the pointer', () => {
    for (let seed = 1; seed <= 30; seed++) {
      const camera = randomCamera(seeded(seed));
      const [x, y] = project(pan(camera, 37, -21, 600), 800, 600, camera.at);
      expect(x, `seed ${seed}`).toBeCloseTo(437, 6);
      expect(y, `seed ${seed}`).toBeCloseTo(279, 6);
    }
  });

  test('zooms along the view and never through what is looked at or out of reach', () => {
    const camera: Camera = { eye: [0, 0, 10], at: [0, 0, 2], up: [0, 1, 0], fovDeg: 30 };
    expect(dolly(camera, 0.5, 1).eye).toEqual([0, 0, 6]);
    expect(length(sub(dolly(camera, 0, 1).eye, camera.at))).toBeCloseTo(1e-4, 12);
    expect(length(sub(dolly(camera, 1e9, 1).eye, camera.at))).toBeCloseTo(1e3, 6);
    expect(wheelFactor(100, 0)).toBeGreaterThan(1);
    expect(wheelFactor(-100, 0) * wheelFactor(100, 0)).toBeCloseTo(1, 12);
    expect(wheelFactor(1e9, 0)).toBeLessThan(2);
  });

  test('does nothing when the pointer has not moved', () => {
    const camera: Camera = { eye: [1, 2, 3], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 30 };
    const p = { x: 12, y: 34 };
    expect(sameCamera(orbit(camera, p, p, 800, 600), camera)).toBe(true);
    expect(sameCamera(camera, { ...camera, eye: add(camera.eye, [0, 0, 1]) })).toBe(false);
    expect(sameCamera(null, null)).toBe(true);
  });
});

describe('the whole box', () => {
  test('is in the picture from any side, with little room about it, by perspective and by parallel rays', () => {
    for (let seed = 1; seed <= 300; seed++) {
      const random = seeded(seed);
      const vec = (size: number): Vec3 => [(random() - 0.5) * size, (random() - 0.5) * size, (random() - 0.5) * size];
      const lower = vec(10);
      const box = { lower, upper: [lower[0] + random() * 9, lower[1] + random() * 0.1, lower[2] + 0.01 + random()] as Vec3 };
      const camera = { eye: vec(40), at: vec(5), up: [0, 0, 1] as const, fovDeg: 10 + random() * 60, orthographic: random() < 0.5 };
      const [width, height] = [300 + random() * 900, 300 + random() * 900];
      const fitted = boxInView(camera, box, width / height);
      const axes = viewAxes(fitted);
      const back = viewAxes(camera).back;
      back.forEach((x, i) => expect(axes.back[i], `seed ${seed}`).toBeCloseTo(x, 9)); // from the same side
      let widest = 0;
      for (let corner = 0; corner < 8; corner++) {
        const at = [0, 1, 2].map((axis) => (corner & (1 << axis) ? box.upper : box.lower)[axis]) as unknown as Vec3;
        const view = viewFromWorld(fitted, axes, at);
        if (!camera.orthographic) expect(view[2], `seed ${seed}`).toBeLessThan(0);
        const [x, y] = screenFromView(fitted, width, height, view);
        widest = Math.max(widest, Math.abs(x / width - 0.5) * 2, Math.abs(y / height - 0.5) * 2);
      }
      expect(widest, `seed ${seed}`).toBeLessThanOrEqual(1);
      expect(widest, `seed ${seed}`).toBeGreaterThan(0.6);
    }
  });
});

describe('a roll', () => {
  test('keeps what is under the pointer under it, and the place and the direction of the eye', () => {
    for (let seed = 1; seed <= 50; seed++) {
      const random = seeded(seed);
      const camera = randomCamera(random);
      const from = { x: 640 * random(), y: 480 * random() };
      const angle = 6 * random() - 3;
      const [dx, dy] = [from.x - 320, from.y - 240];
      const to = { x: 320 + dx * Math.cos(angle) - dy * Math.sin(angle), y: 240 + dx * Math.sin(angle) + dy * Math.cos(angle) };
      const { right, up } = viewAxes(camera);
      const s = worldPerPixel(camera, 480);
      const under = add(camera.at, add(scale(right, dx * s), scale(up, -dy * s)));
      const turned = rollBy(camera, from, to, 640, 480);
      const [x, y] = project(turned, 640, 480, under);
      expect(x, `seed ${seed}`).toBeCloseTo(to.x, 6);
      expect(y, `seed ${seed}`).toBeCloseTo(to.y, 6);
      expect([turned.eye, turned.at]).toEqual([camera.eye, camera.at]);
    }
  });

  test('of a quarter to the right brings what was above to the right; four are none', () => {
    const camera: Camera = { eye: [0, 0, 10], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 40 };
    let turned = roll(camera, Math.PI / 2);
    expect(project(turned, 600, 600, [0, 1, 0])[0]).toBeGreaterThan(310);
    for (let i = 0; i < 3; i++) turned = roll(turned, Math.PI / 2);
    turned.up.forEach((of, i) => expect(of).toBeCloseTo(camera.up[i] as number, 12));
  });
});

describe('a camera of axes that are drawn longer', () => {
  test('looks at the same place of the file from the same side, and comes back', () => {
    const bounds = { lower: [-1, 0, 2] as Vec3, upper: [3, 1, 4] as Vec3 };
    const [from, to]: Vec3[] = [[1, 1, 1], [1, 1, 50]];
    for (let seed = 1; seed <= 50; seed++) {
      const camera = randomCamera(seeded(seed));
      const there = rescaled(camera, from!, to!, bounds);
      expect(there.at).toEqual([camera.at[0], camera.at[1], camera.at[2] * 50]);
      expect(dot(viewAxes(there).back, viewAxes(camera).back), `seed ${seed}`).toBeCloseTo(1, 12);
      const back = rescaled(there, to!, from!, bounds);
      back.eye.forEach((of, i) => expect(of, `seed ${seed}`).toBeCloseTo(camera.eye[i] as number, 9));
    }
  });
});
