// The server's camera, on this side: right-handed, looking down -z, fovDeg the full vertical angle of view. The overlay is drawn with it,
// so it must agree with server/scene/camera.h.
import type { Box, Camera, Vec3 } from './model';
import { add, cross, dot, length, normalize, scale, sub, times } from './vec';

/** The camera's axes in world space: right, up, and back (from what is looked at to the eye). */
export interface ViewAxes {
  right: Vec3;
  up: Vec3;
  back: Vec3;
}

export function viewAxes(camera: Camera): ViewAxes {
  const back = normalize(sub(camera.eye, camera.at));
  const right = normalize(cross(camera.up, back));
  return { right, up: cross(back, right), back };
}

/** A point in view space: x right, y up, z towards the viewer; what is seen has z < 0. */
export function viewFromWorld(camera: Camera, axes: ViewAxes, point: Vec3): Vec3 {
  const d = sub(point, camera.eye);
  return [dot(d, axes.right), dot(d, axes.up), dot(d, axes.back)];
}

/** Pixels from the top left corner, of a view-space point in front of the eye, or anywhere where rays are parallel. */
export function screenFromView(camera: Camera, width: number, height: number, view: Vec3): [number, number] {
  const depth = camera.orthographic ? length(sub(camera.eye, camera.at)) : -view[2];
  const pixelsPerUnit = height / 2 / Math.tan((camera.fovDeg * Math.PI) / 360) / depth;
  return [width / 2 + view[0] * pixelsPerUnit, height / 2 - view[1] * pixelsPerUnit];
}

/** World units that one pixel covers at the distance of `at`. */
export function worldPerPixel(camera: Camera, height: number): number {
  return (2 * length(sub(camera.eye, camera.at)) * Math.tan((camera.fovDeg * Math.PI) / 360)) / height;
}

/** A line between two world points on the screen, cut at a plane just before the eye; null if all of it lies behind. */
export function projectSegment(
  camera: Camera,
  axes: ViewAxes,
  width: number,
  height: number,
  from: Vec3,
  to: Vec3,
): [[number, number], [number, number]] | null {
  const near = camera.orthographic ? Infinity : -1e-4 * Math.max(length(sub(camera.eye, camera.at)), 1e-30);
  let a = viewFromWorld(camera, axes, from);
  let b = viewFromWorld(camera, axes, to);
  if (a[2] > near && b[2] > near) return null;
  const cut = (p: Vec3, q: Vec3): Vec3 => {
    const [x, y] = add(p, scale(sub(q, p), (near - p[2]) / (q[2] - p[2])));
    return [x, y, near]; // which rounding would lose far from the eye
  };
  if (a[2] > near) a = cut(a, b);
  else if (b[2] > near) b = cut(b, a);
  return [screenFromView(camera, width, height, a), screenFromView(camera, width, height, b)];
}

export const center = (box: Box): Vec3 => scale(add(box.lower, box.upper), 0.5);
export const diagonal = (box: Box): number => length(sub(box.upper, box.lower));

/** From the same direction, so that the whole box is in the picture, with a little room about it. aspect: width over height. */
export function boxInView(camera: Camera, box: Box, aspect: number): Camera {
  const at = center(box);
  const { right, up, back } = viewAxes(camera);
  const tan = Math.tan((camera.fovDeg * Math.PI) / 360);
  const half = scale(sub(box.upper, box.lower), 0.5);
  let distance = 0;
  for (const [sx, sy, sz] of [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) => [x, y, z] as const)))) {
    const corner: Vec3 = [half[0] * sx, half[1] * sy, half[2] * sz];
    const needed = Math.max(Math.abs(dot(corner, right)) / (tan * aspect), Math.abs(dot(corner, up)) / tan);
    distance = Math.max(distance, needed + (camera.orthographic ? 0 : dot(corner, back)));
  }
  return { ...camera, at, eye: add(at, scale(back, distance * 1.08 || length(sub(camera.eye, camera.at)))) };
}

/** From the same side and as far away, with another place in the middle: the one that it turns about. */
export const lookingAt = (camera: Camera, at: Vec3): Camera => ({ ...camera, at, eye: add(at, sub(camera.eye, camera.at)) });

export function sameCamera(a: Camera | null, b: Camera | null): boolean {
  if (!a || !b) return a === b;
  const same = (p: Vec3, q: Vec3) => p[0] === q[0] && p[1] === q[1] && p[2] === q[2];
  return same(a.eye, b.eye) && same(a.at, b.at) && same(a.up, b.up) && a.fovDeg === b.fovDeg && !a.orthographic === !b.orthographic;
}
/** As it is drawn (SceneState.axisScale). */
export const scaledBox = ({ lower, upper }: Box, factors: Vec3 = [1, 1, 1]): Box => ({ lower: times(lower, factors), upper: times(upper, factors) });

/** At the same place of the file and from the same side if axes are drawn longer or shorter, as server/scene/axis_scale.h says. */
export function rescaled(camera: Camera, from: Vec3, to: Vec3, bounds: Box): Camera {
  if (from.every((factor, i) => factor === to[i])) return camera;
  const before = diagonal(scaledBox(bounds, from));
  const at = times(camera.at, [to[0] / from[0], to[1] / from[1], to[2] / from[2]]);
  return { ...camera, at, eye: add(at, scale(sub(camera.eye, camera.at), before > 0 ? diagonal(scaledBox(bounds, to)) / before : 1)) };
}
