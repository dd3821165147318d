// The page's own plain types. Numbers are numbers here; protocol.ts is the one place where they meet Protobuf.

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
  times: number[]; // in place of steps, where there are any
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
}

export interface ArrayInfo extends Range {
  name: string;
  association: string;
  type: string;
  components: number;
  nanCount: number;
  cells?: Range | null; // of an array that is averaged from cells: their own range
  steps: Range[]; // at each step; lower > upper: no value, or not read yet. Of a long series the first alone. The range itself is over all that are known
}

/** What was noticed of a dataset's files since the server began. */
export type DatasetNews = 'none' | 'appeared' | 'grown' | 'changed' | 'gone';

export interface DatasetEntry {
  id: string;
  name: string; // below the served folder
  kind: string;
  bytes: number;
  changedMs: number; // when the newest of its files was; 0: it has none
  files: number;
  steps: number; // 0: only opening it says
  news: DatasetNews;
  noticedMs: number;
  writing: boolean;
}

export interface DatasetFolder {
  name: string; // below the served folder
  datasets: number;
  changedMs: number;
  news: number;
}

/** One page of one folder, or of what a search finds. */
export interface DatasetList {
  folder: string;
  search: string;
  first: number;
  total: number;
  folders: DatasetFolder[];
  datasets: DatasetEntry[];
  all: number;
  passedOver: { reason: string; files: number; examples: string[] }[];
  cutOff: boolean;
  watching: string;
  nowMs: number; // the server's clock
}

/** What has become of the files of the open dataset since they were read. */
export type OnDisk = 'as read' | 'changed' | 'gone';

export interface DatasetInfo {
  id: string;
  name: string;
  grid: string;
  points: number;
  cells: number;
  cellTypes: [string, number][];
  bounds: Box | null;
  arrays: ArrayInfo[];
  times: number[];
  missingRangeSteps: number; // that the arrays' ranges leave out until they have been read
  nothingToShow: string; // why a session of it begins without layers; '': it begins with some
  onDisk?: OnDisk; // absent: as read
  notes: string[];
}

export interface Histogram extends Range {
  dataset: string;
  step: number;
  array: string;
  counts: number[];
}

export interface Welcome {
  protocolMajor: number;
  server: string;
  session: string;
  resumeToken: string;
  datasets: DatasetEntry[]; // the first of them
  datasetsAll?: number; // that there are
  state: SceneState | null;
  datasetInfo: DatasetInfo | null;
  device: string;
  deviceIsSoftware: boolean;
  colorMaps: string[];
  movingFormats: string[]; // the best first
  limits: { maxIntervals: number; maxTransferPoints?: number; maxClipPlanes?: number; maxWidth: number; maxHeight: number };
  role?: Role; // of this page; absent: controller
  participant?: bigint; // which of the participants this page is
  lastCommand?: number; // the newest of this page's commands that the session has judged
}

/** A viewer sees what a controller shows. */
export type Role = 'controller' | 'viewer';

export interface Participant {
  id: bigint;
  name: string;
  role: Role;
  invited: boolean;
  client: string;
}

export interface Invitation {
  id: string;
  role: Role;
  expiresUnixMs: number;
  name: string;
  token: string; // empty but for whoever has just made it
  present: number;
}

/** With `notice` the server goes on until the deadline, else it ends now. */
export interface Ending {
  reason: string;
  notice: boolean;
  seconds: number;
  comesBack: boolean;
}

export interface StageTimes {
  extractMs: number;
  orderMs: number;
  drawMs: number;
  readbackMs: number;
  encodeMs: number;
  totalMs: number;
}

export interface IntervalFacts {
  id: number;
  activeCells: number;
  tetrahedra: number;
  volume: number;
  /** Of a flat grid, in place of a volume. */
  area?: number;
}

/** How far a layer's volume may be from that of the field as its cells interpolate it; 0: it is cut exactly. */
export interface VolumeError {
  id: number;
  volume: number;
  error: number;
}

/** moving: as good as the link carries; settled: of full size and quality, not yet lossless; exact: lossless. */
export type FramePhase = 'moving' | 'settled' | 'exact';

/** How far the field that is drawn may be from that of all points, in the unit of the array that is cut. */
export interface CoarseError {
  largest: number;
  mean: number;
}

export interface Frame {
  frameId: bigint;
  revision: number;
  inputSeq: number;
  step: number;
  phase: FramePhase;
  format: string;
  width: number;
  height: number;
  stages: StageTimes;
  device: string;
  order: string;
  orderExact: boolean;
  tetrahedra: number;
  pointStride: number; // above 1: a first picture, of every n-th point of the grid along each axis
  coarseError: CoarseError | null; // of such a picture, once it is known
  samples: number; // each way, of a pixel
  intervals: IntervalFacts[];
  camera: Camera | null;
  streamId: number; // of video; 0: a picture by itself
  key: boolean; // of a stream: decodes without those before it
  inReplyTo: number; // of a picture for keeping, the message that asked for it; 0: it is for the screen
  band: { firstRow: number; rows: number; index: number; count: number } | null; // a part of the picture only
  decoder: string; // of key frames: VideoDecoderConfig's codec
  forecasts: FormatForecast[]; // of moving frames, where the server chooses their format
  payload: Uint8Array<ArrayBuffer>;
}

/** What the server expects that a frame takes in a format: drawing, encoding, the way here, decoding. */
export interface FormatForecast {
  format: string;
  ms: number;
}

export interface Progress {
  operation: bigint;
  stage: string;
  fraction: number;
  background: boolean; // no picture waits for it
}

export interface Done {
  operation: bigint;
  cancelled: boolean;
  superseded: boolean; // by a newer choice
}

export interface ServerError {
  inReplyTo: number;
  code: string;
  message: string;
  field: string;
}

/** What the server says, one case per message. */
export type ServerEvent =
  | { kind: 'welcome'; welcome: Welcome }
  | { kind: 'state'; state: SceneState }
  | { kind: 'datasetInfo'; info: DatasetInfo }
  | { kind: 'histogram'; histogram: Histogram }
  | { kind: 'frame'; frame: Frame }
  | { kind: 'volumeErrors'; errors: VolumeError[] }
  | { kind: 'progress'; progress: Progress }
  | { kind: 'done'; done: Done }
  | { kind: 'error'; error: ServerError }
  | { kind: 'pong'; clientTimeMs: number }
  | { kind: 'shutdown'; ending: Ending }
  | { kind: 'participants'; participants: Participant[] }
  | { kind: 'invitation'; invitation: Invitation }
  | { kind: 'invitations'; invitations: Invitation[] }
  | { kind: 'datasetList'; list: DatasetList }
  | { kind: 'datasetsChanged'; entries: DatasetEntry[] } // those with other news, at most some
  | { kind: 'unknown' };

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
