// The scene, as the page's own plain types. Numbers are numbers here; wire-scene.ts is the one place where they meet Protobuf.

export type Vec3 = readonly [number, number, number];

/** Display values (sRGB) in [0, 1]. */
export type Rgb = readonly [number, number, number];

/** Where the viewer stands, in the dataset's space; fovDeg is the full vertical angle of view. */
export interface Camera {
  eye: Vec3;
  at: Vec3;
  up: Vec3;
  fovDeg: number;
  orthographic?: boolean; // parallel rays; what is as far away as `at` is as large as in perspective
}

/** Keeps what has dot(normal, position) >= offset. */
export interface ClipPlane {
  normal: Vec3;
  offset: number;
}

/** What the server draws into its pictures beside the volume. The page draws its own box and axes on the screen. */
export interface Annotations {
  axes: boolean;
  box: boolean;
  legend: boolean;
}

export interface Box {
  lower: Vec3;
  upper: Vec3;
}

/** A span of values: of an array, or of a histogram's axis. */
export interface Range {
  lower: number;
  upper: number;
}

/** How a layer's boundary is drawn. */
export interface Surface {
  lower: boolean; // where f = lower
  upper: boolean;
  domain: boolean; // where the grid ends
  color: Rgb | null; // null: the layer's own
  opacity: number;
  ambient: number;
  diffuse: number;
  specular: number;
  shininess: number;
  silhouette: number; // in [0, 1]: how far it turns black where it is seen edge-on
  texture: string; // empty: none; "stripes"; a colour map
  textureRepeat: number; // periods over the texture array's range
}

export const noSurface: Surface = {
  lower: false,
  upper: false,
  domain: false,
  color: null,
  opacity: 1,
  ambient: 0.25,
  diffuse: 0.75,
  specular: 0.3,
  shininess: 30,
  silhouette: 0,
  texture: '',
  textureRepeat: 1,
};

/** A control point of a transfer function. */
export interface TransferPoint {
  value: number;
  color: Rgb;
  opacity: number; // of a layer one unit distance thick
}

/** One layer: the solid region lower <= f <= upper. */
export interface Interval {
  id: number;
  lower: number;
  upper: number;
  color: Rgb;
  colorMap: string; // empty: the constant colour
  opacity: number; // of a layer one unit distance thick
  priority: number; // higher is painted over lower
  visible: boolean;
  opacityUpper?: number | null; // at the top of the range that colour runs over; null: one opacity
  ownRange?: boolean; // colour and opacity run over the layer's own range
  surface?: Surface | null;
  name?: string; // for the legend
  number?: number; // what it is called by without one, as long as it is there; given by the server
  // How it looks, in place of colour, map and opacities, from its first point at `lower` to its last one at `upper`; null: it has none.
  transfer?: TransferPoint[] | null;
}

/** What PatchInterval can change. */
export type IntervalPatch = Partial<Omit<Interval, 'id' | 'priority' | 'number'>>;

export type ColorSpan = 'step' | 'all_steps' | 'own';

/** The values that colour maps, and opacity that runs, begin and end at. */
export interface ColorRange extends Range {
  span: ColorSpan; // lower and upper are those of "own"
  log: boolean; // colours run with the value's logarithm
}
export const stepRange: ColorRange = { span: 'step', lower: 0, upper: 0, log: false };

export type RenderMode = 'sorted' | 'prioritized' | 'cycled' | 'smear';

/** Of the mode "cycled": one layer at a time. */
export interface Cycle {
  seconds: number; // that each is shown
  phase: number; // counts the visible layers
  playing: boolean;
}

/** Of the mode "smear": time steps, or times, over one another. */
export interface Smear {
  steps: number[];
  times: number[]; // in place of steps, if there are any
  colors: Rgb[];
}

export type RangeOperator = 'intersect' | 'unite' | 'subtract' | 'exclusive_or';

/** One step of a combination: how the range of another array changes all layers. */
export interface RangeTerm extends Range {
  op: RangeOperator;
  array: string;
  color: Rgb | null; // of what the term brings in; null: as the first layer
  colorMap: string;
  opacity: number | null;
  priority: number | null;
  hidden: boolean;
}

export type TimeMode = 'step' | 'interpolate' | 'spacetime';

/** What lies between the values of the array: whole cells and labels have nothing there. */
export type FieldValues = 'interpolated' | 'whole';

export interface SceneState {
  revision: number;
  dataset: string; // empty: nothing is open
  step: number;
  array: string;
  values?: FieldValues;
  colorBy: string;
  intervals: Interval[]; // in the order they were added
  mode: RenderMode;
  camera: Camera | null; // null: the whole dataset
  background: Rgb;
  unitDistance: number; // 0: the server's default
  terms: RangeTerm[];
  time: number | null; // null: the step
  timeMode: TimeMode;
  texture: string; // the array of the surfaces' textures; empty: colorBy
  cycle: Cycle;
  smear: Smear;
  clipPlanes?: ClipPlane[];
  annotations?: Annotations;
  colorRange?: ColorRange;
  occlusion?: number; // in [0, 1]; what the picture's depth adds to its light
  depthFade?: number;
  bodyShading?: number; // in [0, 1]; how far interiors are shaded along the array's gradient
  axisScale?: Vec3; // how many times as long each axis is drawn; absent: 1, 1, 1. The camera is in the drawn space, cuts in the dataset's
}

export const emptyState: SceneState = {
  revision: 0,
  dataset: '',
  step: 0,
  array: '',
  colorBy: '',
  intervals: [],
  mode: 'sorted',
  camera: null,
  background: [0.05, 0.06, 0.08],
  unitDistance: 0,
  terms: [],
  time: null,
  timeMode: 'step',
  texture: '',
  cycle: { seconds: 1, phase: 0, playing: true },
  smear: { steps: [], times: [], colors: [] },
};
