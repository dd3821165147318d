// The bounding box and its axes as lines and labels on the screen, for the overlay that moves at once while the frame follows.
import { asInFile, axisTitle, letters } from './axes';
import { center, projectSegment, screenFromView, viewAxes, viewFromWorld } from './camera';
import type { Box, Camera, Vec3 } from './model';
import { formatNumber, ticks, tickText } from './ticks';
import type { Axis } from './told';
import { sub, dot } from './vec';

export interface EdgeLine {
  x1: number;
  y1: number;
  x2: number;
  y2: number;
  hidden: boolean; // behind the box as seen from the eye
}

export interface AxisLabel {
  x: number;
  y: number;
  text: string;
  kind: 'tick' | 'name';
}

export interface BoxLines {
  edges: EdgeLine[];
  ticks: Omit<EdgeLine, 'hidden'>[];
  labels: AxisLabel[];
}

interface Edge {
  axis: 0 | 1 | 2;
  from: Vec3;
  to: Vec3;
  facing: number; // how many of its two faces are seen: 0, 1, 2
}

/** The twelve edges, each with how many of its faces look at the eye. */
function edgesOf(box: Box, camera: Camera, towards: Vec3): Edge[] {
  const { eye } = camera;
  const corner = (i: number, j: number, k: number): Vec3 => [
    i ? box.upper[0] : box.lower[0],
    j ? box.upper[1] : box.lower[1],
    k ? box.upper[2] : box.lower[2],
  ];
  const seen = (axis: number, side: number) =>
    camera.orthographic
      ? (towards[axis] as number) * (side ? 1 : -1) > 1e-9
      : side ? (eye[axis] as number) > (box.upper[axis] as number) : (eye[axis] as number) < (box.lower[axis] as number);
  const edges: Edge[] = [];
  for (const axis of [0, 1, 2] as const) {
    const [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
    for (const sb of [0, 1])
      for (const sc of [0, 1]) {
        const ends = [0, 1].map((sa) => {
          const s = [0, 0, 0];
          s[axis] = sa;
          s[b] = sb;
          s[c] = sc;
          return corner(s[0] as number, s[1] as number, s[2] as number);
        });
        edges.push({ axis, from: ends[0] as Vec3, to: ends[1] as Vec3, facing: Number(seen(b, sb)) + Number(seen(c, sc)) });
      }
  }
  return edges;
}

/** `factors`: the box is that of the dataset times these; numbers are the file's. */
export function boxLines(camera: Camera, box: Box, width: number, height: number, factors: Vec3 = [1, 1, 1], meaning?: readonly Axis[]): BoxLines {
  const axes = viewAxes(camera);
  const edges = edgesOf(box, camera, axes.back);
  const result: BoxLines = { edges: [], ticks: [], labels: [] };
  const inside = edges.every((edge) => edge.facing === 0); // the eye is within the box
  for (const edge of edges) {
    const line = projectSegment(camera, axes, width, height, edge.from, edge.to);
    if (!line) continue;
    const [[x1, y1], [x2, y2]] = line;
    result.edges.push({ x1, y1, x2, y2, hidden: edge.facing === 0 && !inside });
  }

  const middleView = viewFromWorld(camera, axes, center(box));
  if ((middleView[2] >= 0 && !camera.orthographic) || inside) return result;
  const middle = screenFromView(camera, width, height, middleView);
  for (const axis of [0, 1, 2] as const) {
    // Labels stand on the outline, if they do not cover the picture: of its edges along this axis, the lowest on the screen.
    let best: { edge: Edge; line: [[number, number], [number, number]]; y: number } | null = null;
    for (const edge of edges) {
      if (edge.axis !== axis || edge.facing !== 1) continue;
      const whole = [edge.from, edge.to].every((p) => camera.orthographic || dot(sub(p, camera.eye), axes.back) < 0);
      const line = whole && projectSegment(camera, axes, width, height, edge.from, edge.to);
      if (!line) continue;
      const y = (line[0][1] + line[1][1]) / 2 + (line[0][0] + line[1][0]) * 1e-3;
      if (!best || y > best.y) best = { edge, line, y };
    }
    if (best) label(result, best.edge, best.line, middle, camera, axes, width, height, factors[axis], meaning);
  }
  return result;
}

function label(
  result: BoxLines,
  edge: Edge,
  [a, b]: [[number, number], [number, number]],
  middle: [number, number],
  camera: Camera,
  axes: ReturnType<typeof viewAxes>,
  width: number,
  height: number,
  factor: number,
  meaning: readonly Axis[] | undefined,
): void {
  const pixels = Math.hypot(b[0] - a[0], b[1] - a[1]);
  if (pixels < 36) return; // seen end on
  // Outward: across the edge, away from the box's middle.
  let out: [number, number] = [(b[1] - a[1]) / pixels, -(b[0] - a[0]) / pixels];
  const [mx, my] = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
  if ((mx - middle[0]) * out[0] + (my - middle[1]) * out[1] < 0) out = [-out[0], -out[1]];

  const { axis } = edge;
  const numbers = [edge.from, edge.to].map((end) => asInFile(meaning, axis, end[axis] / factor)) as [number, number];
  for (const value of ticks(Math.min(...numbers), Math.max(...numbers), Math.max(1, Math.min(6, pixels / 64)))) {
    const point = [...edge.from] as [number, number, number];
    point[axis] = asInFile(meaning, axis, value) * factor;
    const view = viewFromWorld(camera, axes, point);
    if (view[2] >= 0 && !camera.orthographic) continue;
    const [x, y] = screenFromView(camera, width, height, view);
    result.ticks.push({ x1: x, y1: y, x2: x + out[0] * 5, y2: y + out[1] * 5 });
    const label: AxisLabel = { x: x + out[0] * 16, y: y + out[1] * 13, text: tickText(value), kind: 'tick' };
    // Where two axes meet, one number is enough.
    if (result.labels.every((other) => Math.hypot(other.x - label.x, other.y - label.y) > 18)) result.labels.push(label);
  }
  // The whole name beyond the numbers, else beyond an end of the axis, else the letter.
  const scaled = factor === 1 ? '' : ` ×${formatNumber(factor, 3)}`;
  const title = axisTitle(meaning, axis) + scaled;
  const half = 3.4 * title.length;
  const [ux, uy] = [(b[0] - a[0]) / pixels, (b[1] - a[1]) / pixels];
  const places = [
    [mx + out[0] * (33 + half), my + out[1] * 30],
    [b[0] + ux * (10 + half), b[1] + uy * 16],
    [a[0] - ux * (10 + half), a[1] - uy * 16],
  ] as const;
  const free = (x: number, y: number) => result.labels.every((other) => Math.abs(other.x - x) > half + 12 || Math.abs(other.y - y) > 9);
  const [x, y] = places.find(([x, y]) => x >= half && x <= width - half && y >= 8 && y <= height - 8 && free(x, y)) ?? [];
  if (x !== undefined && y !== undefined) result.labels.push({ x, y, text: title, kind: 'name' });
  else result.labels.push({ x: mx + out[0] * 36, y: my + out[1] * 30, text: letters[axis] + scaled, kind: 'name' });
}
