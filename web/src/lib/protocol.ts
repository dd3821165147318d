// The one place where Protobuf meets the page's types: commands become bytes, bytes become events.
import { create, fromBinary, toBinary, type MessageInitShape } from '@bufbuild/protobuf';
import {
  ClientMessageSchema,
  FramePhase,
  RenderMode as WireMode,
  ServerMessageSchema,
  type Camera as WireCamera,
  type DatasetInfo as WireDatasetInfo,
  type Frame as WireFrame,
  type Rgb as WireRgb,
  type State as WireState,
  type Vec3 as WireVec3,
  type Welcome as WireWelcome,
} from '../gen/isostrata/v1/isostrata_pb';
import type {
  Camera,
  DatasetInfo,
  Frame,
  Interval,
  IntervalPatch,
  RenderMode,
  Rgb,
  SceneState,
  ServerEvent,
  Vec3,
  Welcome,
} from './model';

export const subprotocol = 'isostrata.v1';
export const protocolMajor = 1;
export const protocolMinor = 0;

/** The body of one ClientMessage. */
export type Command = NonNullable<MessageInitShape<typeof ClientMessageSchema>['body']>;

export interface ViewportSize {
  width: number;
  height: number;
  hidden: boolean;
}

const wireVec = (v: Vec3) => ({ x: v[0], y: v[1], z: v[2] });
const wireRgb = (c: Rgb) => ({ r: c[0], g: c[1], b: c[2] });

export const command = {
  hello: (viewport: ViewportSize, resumeToken: string): Command => ({
    case: 'hello',
    value: {
      protocolMajor,
      protocolMinor,
      client: 'isostrata-web 0.1.0',
      viewport,
      stillFormats: ['png'],
      movingFormats: ['jpeg'],
      resumeToken,
    },
  }),
  openDataset: (id: string): Command => ({ case: 'openDataset', value: { id } }),
  selectArrays: (array: string, colorBy: string): Command => ({ case: 'selectArrays', value: { array, colorBy } }),
  setTimeStep: (step: number): Command => ({ case: 'setTimeStep', value: { step } }),
  setIntervals: (intervals: readonly Interval[]): Command => ({
    case: 'setIntervals',
    value: { intervals: intervals.map((interval) => ({ ...interval, color: wireRgb(interval.color) })) },
  }),
  patchInterval: (id: number, patch: IntervalPatch): Command => {
    const { color, ...rest } = patch;
    return { case: 'patchInterval', value: { id, ...rest, ...(color ? { color: wireRgb(color) } : {}) } };
  },
  removeInterval: (id: number): Command => ({ case: 'removeInterval', value: { id } }),
  reorderPriorities: (ids: readonly number[]): Command => ({ case: 'reorderPriorities', value: { ids: [...ids] } }),
  setCamera: (camera: Camera): Command => ({
    case: 'setCamera',
    value: {
      camera: { eye: wireVec(camera.eye), at: wireVec(camera.at), up: wireVec(camera.up), fovDeg: camera.fovDeg },
    },
  }),
  setView: (view: string): Command => ({ case: 'setView', value: { view } }),
  setAppearance: (change: { mode?: RenderMode; background?: Rgb; unitDistance?: number }): Command => ({
    case: 'setAppearance',
    value: {
      mode: change.mode ? wireMode(change.mode) : WireMode.UNSPECIFIED,
      ...(change.background ? { background: wireRgb(change.background) } : {}),
      ...(change.unitDistance !== undefined ? { unitDistance: change.unitDistance } : {}),
    },
  }),
  viewport: (viewport: ViewportSize): Command => ({ case: 'viewport', value: viewport }),
  interaction: (active: boolean): Command => ({ case: 'interaction', value: { active } }),
  frameAck: (frameId: bigint, decodeMs: number): Command => ({ case: 'frameAck', value: { frameId, decodeMs } }),
  requestStill: (): Command => ({ case: 'requestStill', value: {} }),
  requestHistogram: (array: string, bins: number): Command => ({ case: 'requestHistogram', value: { array, bins } }),
  cancel: (operation: bigint): Command => ({ case: 'cancel', value: { operation } }),
  ping: (clientTimeMs: number): Command => ({ case: 'ping', value: { clientTimeMs } }),
};

export function encodeCommand(seq: number, body: Command): Uint8Array<ArrayBuffer> {
  const bytes = toBinary(ClientMessageSchema, create(ClientMessageSchema, { seq: BigInt(seq), body }));
  return bytes as Uint8Array<ArrayBuffer>;
}

/** Throws where the bytes are not a ServerMessage. */
export function decodeEvent(bytes: Uint8Array): ServerEvent {
  const { body } = fromBinary(ServerMessageSchema, bytes);
  switch (body.case) {
    case 'welcome':
      return { kind: 'welcome', welcome: welcomeOf(body.value) };
    case 'state':
      return { kind: 'state', state: stateOf(body.value) };
    case 'datasetInfo':
      return { kind: 'datasetInfo', info: datasetInfoOf(body.value) };
    case 'histogram': {
      const { dataset, step, array, lower, upper, counts } = body.value;
      return { kind: 'histogram', histogram: { dataset, step, array, lower, upper, counts: counts.map(Number) } };
    }
    case 'frame':
      return { kind: 'frame', frame: frameOf(body.value) };
    case 'progress': {
      const { operation, stage, fraction } = body.value;
      return { kind: 'progress', progress: { operation, stage, fraction } };
    }
    case 'done':
      return { kind: 'done', operation: body.value.operation, cancelled: body.value.cancelled };
    case 'error': {
      const { inReplyTo, code, message, field } = body.value;
      return { kind: 'error', error: { inReplyTo: Number(inReplyTo), code, message, field } };
    }
    case 'pong':
      return { kind: 'pong', clientTimeMs: body.value.clientTimeMs };
    case 'shutdown':
      return { kind: 'shutdown', reason: body.value.reason };
    default:
      return { kind: 'unknown' };
  }
}

const vecOf = (v: WireVec3 | undefined): Vec3 => (v ? [v.x, v.y, v.z] : [0, 0, 0]);
const rgbOf = (c: WireRgb | undefined): Rgb => (c ? [c.r, c.g, c.b] : [0, 0, 0]);
const wireMode = (mode: RenderMode) => (mode === 'prioritized' ? WireMode.PRIORITIZED : WireMode.SORTED);

function cameraOf(c: WireCamera | undefined): Camera | null {
  if (!c?.eye || !c.at || !c.up) return null;
  return { eye: vecOf(c.eye), at: vecOf(c.at), up: vecOf(c.up), fovDeg: c.fovDeg };
}

function stateOf(s: WireState): SceneState {
  return {
    revision: Number(s.revision),
    dataset: s.dataset,
    step: s.step,
    array: s.array,
    colorBy: s.colorBy,
    intervals: s.intervals.map(({ id, lower, upper, color, colorMap, opacity, priority, visible }) => ({
      id,
      lower,
      upper,
      color: rgbOf(color),
      colorMap,
      opacity,
      priority,
      visible,
    })),
    mode: s.mode === WireMode.PRIORITIZED ? 'prioritized' : 'sorted',
    camera: cameraOf(s.camera),
    background: rgbOf(s.background),
    unitDistance: s.unitDistance,
  };
}

function datasetInfoOf(d: WireDatasetInfo): DatasetInfo {
  return {
    id: d.id,
    name: d.name,
    grid: d.grid,
    points: Number(d.points),
    cells: Number(d.cells),
    cellTypes: Object.entries(d.cellTypes).map(([type, count]) => [type, Number(count)]),
    bounds: d.lower && d.upper ? { lower: vecOf(d.lower), upper: vecOf(d.upper) } : null,
    arrays: d.arrays.map(({ name, association, type, components, lower, upper, nanCount }) => ({
      name,
      association,
      type,
      components,
      lower,
      upper,
      nanCount: Number(nanCount),
    })),
    times: d.times,
    notes: d.notes,
  };
}

function welcomeOf(w: WireWelcome): Welcome {
  return {
    protocolMajor: w.protocolMajor,
    server: w.server,
    session: w.session,
    resumeToken: w.resumeToken,
    datasets: w.datasets.map(({ id, name }) => ({ id, name })),
    state: w.state ? stateOf(w.state) : null,
    datasetInfo: w.datasetInfo ? datasetInfoOf(w.datasetInfo) : null,
    device: w.device,
    deviceIsSoftware: w.deviceIsSoftware,
    colorMaps: w.colorMaps,
    limits: {
      maxIntervals: w.limits?.maxIntervals || 256,
      maxWidth: w.limits?.maxWidth || 4096,
      maxHeight: w.limits?.maxHeight || 4096,
    },
  };
}

function frameOf(f: WireFrame): Frame {
  const stages = f.stages;
  return {
    frameId: f.frameId,
    revision: Number(f.revision),
    inputSeq: Number(f.inputSeq),
    step: f.step,
    lossless: f.phase === FramePhase.LOSSLESS,
    format: f.format,
    width: f.width,
    height: f.height,
    stages: {
      extractMs: stages?.extractMs ?? 0,
      orderMs: stages?.orderMs ?? 0,
      drawMs: stages?.drawMs ?? 0,
      readbackMs: stages?.readbackMs ?? 0,
      encodeMs: stages?.encodeMs ?? 0,
      totalMs: stages?.totalMs ?? 0,
    },
    device: f.facts?.device ?? '',
    order: f.facts?.order ?? '',
    orderExact: f.facts?.orderExact ?? false,
    tetrahedra: Number(f.facts?.tetrahedra ?? 0n),
    intervals: (f.facts?.intervals ?? []).map(({ id, activeCells, tetrahedra, volume }) => ({
      id,
      activeCells: Number(activeCells),
      tetrahedra: Number(tetrahedra),
      volume,
    })),
    camera: cameraOf(f.camera),
    payload: f.payload as Uint8Array<ArrayBuffer>,
  };
}
