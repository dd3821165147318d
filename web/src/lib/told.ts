// What the server tells, as the page's own plain types: datasets, frames, people, work. Numbers are numbers here; events.ts is where they meet Protobuf.
import type { Box, Camera, Range, SceneState, Vec3 } from './model';

export interface ArrayInfo extends Range {
  name: string;
  association: string;
  type: string;
  components: number;
  nanCount: number;
  unit: string; // as the file says it; may be empty
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
  foundStep: number; // from 1: the step of the file that the words of a search name; 0: none
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

export interface Axis {
  name: string; // '': the file says none
  unit: string; // likewise
  downward: boolean; // the file's numbers are those of places times -1
}

export interface DatasetInfo {
  id: string;
  name: string;
  grid: string;
  points: number;
  cells: number;
  cellTypes: [string, number][];
  bounds: Box | null;
  axes?: readonly Axis[]; // x, y and z; absent: nothing is known of them
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

/** What lies at a place of the picture. Where nothing is, `miss` says why, and the rest says nothing. */
export interface ProbeResult {
  revision: number; // of the state that was looked at
  hit: boolean;
  miss: string;
  position: Vec3;
  distance: number; // from the eye
  interval: number; // its id; 0: what a combined range has brought in
  term: number | null; // that range
  end: 'lower' | 'upper' | 'domain' | 'range' | 'cut' | 'eye';
  cell: number | null;
  point: number | null; // the nearest of the cell's
  cellIndex: number[]; // i, j, k on structured grids
  pointIndex: number[];
  step: number;
  time: number | null;
  arrays: { name: string; value: number | null; cellValue: number | null }[]; // null: no number, or not of cells
}

/** The values of an array along a line, or at a place over all steps. NaN: none; along a line a gap begins. */
export interface ProbedCurve {
  revision: number; // of the state that was looked at
  array: string;
  at: number[]; // distances from the line's first end, rising; or the steps
  values: number[];
  thinned: boolean; // of a line's samples the extremes are left
  gridsDiffer: boolean; // over the steps: the grid is not the same at all of them
  layers: { from: number; to: number; interval: number; term: number | null }[]; // where the line lies in layers that are shown
}

/** One layer in numbers. Means are over its solid. */
export interface LayerStatistics {
  revision: number; // of the state that was measured
  interval: number;
  array: string;
  flat: boolean; // areas stand in place of volumes
  volume: number;
  centroid: Vec3;
  pieces: number; // that do not touch
  largest: number; // the volume of the largest
  valued: number; // the volume in which the array has values; those that follow are said of it, if it is not 0
  lower: number;
  upper: number;
  mean: number;
  standardDeviation: number;
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

/** In pixels. */
export interface Size {
  width: number;
  height: number;
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

/** What is missing until work is done: an answer to one client, who is told itself; what all see; ranges of all steps, for which nobody waits. */
export type Purpose = 'answer' | 'picture' | 'dataset' | 'ranges';

export interface Progress {
  operation: bigint;
  stage: string;
  fraction: number;
  purpose: Purpose;
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
  | { kind: 'state'; state: SceneState; heeded: number } // the newest of this connection's messages that has been judged
  | { kind: 'datasetInfo'; info: DatasetInfo }
  | { kind: 'histogram'; histogram: Histogram }
  | { kind: 'frame'; frame: Frame }
  | { kind: 'probeResult'; inReplyTo: number; result: ProbeResult }
  | { kind: 'probedCurve'; inReplyTo: number; curve: ProbedCurve }
  | { kind: 'layerStatistics'; inReplyTo: number; statistics: LayerStatistics }
  | { kind: 'volumeErrors'; errors: VolumeError[] }
  | { kind: 'progress'; progress: Progress }
  | { kind: 'done'; done: Done }
  | { kind: 'error'; error: ServerError }
  | { kind: 'pong'; clientTimeMs: number }
  | { kind: 'shutdown'; ending: Ending }
  | { kind: 'participants'; participants: Participant[]; viewerSize: Size }
  | { kind: 'invitation'; invitation: Invitation }
  | { kind: 'invitations'; invitations: Invitation[] }
  | { kind: 'datasetList'; list: DatasetList }
  | { kind: 'datasetsChanged'; entries: DatasetEntry[] } // those with other news, at most some
  | { kind: 'unknown' };
