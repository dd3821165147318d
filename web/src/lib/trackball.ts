// Camera motion by pointer and wheel: cameras in, cameras out.
// Source: G. Bell's virtual trackball (1988): a sphere that joins a hyperbolic sheet, as compared in K. Henriksen, J. Sporring,
// K. Hornbæk, "Virtual Trackballs Revisited", IEEE TVCG 10(2), 2004.
import { viewAxes, worldPerPixel } from './camera';
import type { Camera, Vec3 } from './model';
import { add, cross, dot, length, normalize, rotate, scale, sub } from './vec';

export interface Point2 {
  x: number;
  y: number;
}

const radius = 0.9; // of the ball, in half heights of the viewport

/** The point of the ball under the pointer, in view space. */
function onBall(p: Point2, width: number, height: number): Vec3 {
  const half = Math.min(width, height) / 2 || 1;
  const x = (p.x - width / 2) / half;
  const y = (height / 2 - p.y) / half;
  const d2 = x * x + y * y;
  const r2 = radius * radius;
  return normalize([x, y, d2 <= r2 / 2 ? Math.sqrt(r2 - d2) : r2 / 2 / Math.sqrt(d2)]);
}

/** Turns the scene about `at` as if the ball were dragged from one pixel to another. */
export function orbit(camera: Camera, from: Point2, to: Point2, width: number, height: number): Camera {
  const a = onBall(from, width, height);
  const b = onBall(to, width, height);
  const axisView = cross(a, b);
  const sine = length(axisView);
  if (sine < 1e-9) return camera;
  // Twice the ball's angle: a drag across the viewport turns the scene once around, as viewers of this kind do.
  const angle = 2 * Math.atan2(sine, dot(a, b));
  const { right, up, back } = viewAxes(camera);
  const n = normalize(axisView);
  const axis = normalize(add(add(scale(right, n[0]), scale(up, n[1])), scale(back, n[2])));
  // The scene turns one way, so the eye goes the other.
  return {
    ...camera,
    eye: add(camera.at, rotate(sub(camera.eye, camera.at), axis, -angle)),
    up: normalize(rotate(up, axis, -angle)),
  };
}

/** Turns the picture about its middle, clockwise, by so many radians. */
export function roll(camera: Camera, angle: number): Camera {
  const { up, back } = viewAxes(camera);
  return { ...camera, up: normalize(rotate(up, back, angle)) };
}

/** The same, as if the picture were turned from one pixel to another. */
export function rollBy(camera: Camera, from: Point2, to: Point2, width: number, height: number): Camera {
  const angleOf = (p: Point2) => Math.atan2(p.y - height / 2, p.x - width / 2);
  return roll(camera, angleOf(to) - angleOf(from));
}

/** Moves the scene with the pointer: what lies at the distance of `at` stays under it. */
export function pan(camera: Camera, dx: number, dy: number, height: number): Camera {
  const { right, up } = viewAxes(camera);
  const s = worldPerPixel(camera, height);
  const shift = add(scale(right, -dx * s), scale(up, dy * s));
  return { ...camera, eye: add(camera.eye, shift), at: add(camera.at, shift) };
}

/** factor < 1 comes closer. The distance stays within 1e-4 and 1e3 of `size`, so that the view can always be brought back. */
export function dolly(camera: Camera, factor: number, size: number): Camera {
  const offset = sub(camera.eye, camera.at);
  const distance = length(offset);
  const wanted = Math.min(Math.max(distance * factor, size * 1e-4), size * 1e3);
  return distance > 0 ? { ...camera, eye: add(camera.at, scale(offset, wanted / distance)) } : camera;
}

/** The dolly factor of a wheel event; lines and pages count as so many pixels. */
export function wheelFactor(deltaY: number, deltaMode: number): number {
  const pixels = deltaMode === 1 ? deltaY * 16 : deltaMode === 2 ? deltaY * 240 : deltaY;
  return Math.exp(Math.max(-240, Math.min(240, pixels)) * 0.0015);
}
