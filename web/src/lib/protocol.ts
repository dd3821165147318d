// The one place where Protobuf meets the page's types: commands become bytes, bytes become events.
import { create, fromBinary, toBinary, type MessageInitShape } from '@bufbuild/protobuf';
import {
  ClientMessageSchema,
  ColorSpan as WireSpan,
  DatasetNews as WireNews,
  FramePhase,
  OnDisk as WireOnDisk,
  RangeOperator as WireOperator,
  RenderMode as WireMode,
  Role as WireRole,
  ServerMessageSchema,
  FieldValues as WireFieldValues,
  TimeMode as WireTimeMode,
  type Camera as WireCamera,
  type DatasetEntry as WireEntry,
  type DatasetInfo as WireDatasetInfo,
  type DatasetList as WireList,
  type Frame as WireFrame,
  type Interval as WireInterval,
  type Invitation as WireInvitation,
  type RangeTerm as WireTerm,
  type Rgb as WireRgb,
  type State as WireState,
  type Surface as WireSurface,
  type Vec3 as WireVec3,
  type Welcome as WireWelcome,
} from '../gen/isostrata/v1/isostrata_pb';
import type {
  Annotations,
  Camera,
  ClipPlane,
  ColorRange,
  ColorSpan,
  Cycle,
  DatasetEntry,
  DatasetInfo,
  DatasetList,
  DatasetNews,
  Frame,
  Interval,
  IntervalPatch,
  Invitation,
  OnDisk,
  RangeOperator,
  RangeTerm,
  RenderMode,
  Rgb,
  Role,
  SceneState,
  ServerEvent,
  Smear,
  Surface,
  FieldValues,
  TimeMode,
  TransferPoint,
  Vec3,
  Welcome,
} from './model';

export const subprotocol = 'isostrata.v1';
export const protocolMajor = 1;
export const protocolMinor = 2;

/** The body of one ClientMessage. */
export type Command = NonNullable<MessageInitShape<typeof ClientMessageSchema>['body']>;

export interface ViewportSize {
  width: number;
  height: number;
  hidden: boolean;
}

const wireVec = (v: Vec3) => ({ x: v[0], y: v[1], z: v[2] });
const wireRgb = (c: Rgb) => ({ r: c[0], g: c[1], b: c[2] });

/** The names of a wire enumeration's values, and back. */
const byWire = <Name extends string, Wire extends number>(pairs: readonly (readonly [Name, Wire])[]) => ({
  wire: (name: Name): Wire => (pairs.find(([n]) => n === name) ?? pairs[0]!)[1],
  name: (wire: number): Name => (pairs.find(([, w]) => w === wire) ?? pairs[0]!)[0],
});
const modes = byWire<RenderMode, WireMode>([
  ['sorted', WireMode.SORTED],
  ['prioritized', WireMode.PRIORITIZED],
  ['cycled', WireMode.CYCLED],
  ['smear', WireMode.SMEAR],
]);
const spans = byWire<ColorSpan, WireSpan>([
  ['step', WireSpan.STEP],
  ['all_steps', WireSpan.ALL_STEPS],
  ['own', WireSpan.OWN],
]);
const operators = byWire<RangeOperator, WireOperator>([
  ['intersect', WireOperator.INTERSECT],
  ['unite', WireOperator.UNITE],
  ['subtract', WireOperator.SUBTRACT],
  ['exclusive_or', WireOperator.EXCLUSIVE_OR],
]);
const timeModes = byWire<TimeMode, WireTimeMode>([
  ['step', WireTimeMode.STEP],
  ['interpolate', WireTimeMode.INTERPOLATE],
  ['spacetime', WireTimeMode.SPACETIME],
]);
const fieldValues = byWire<FieldValues, WireFieldValues>([
  ['interpolated', WireFieldValues.INTERPOLATED],
  ['whole', WireFieldValues.WHOLE],
]);
const news = byWire<DatasetNews, WireNews>([
  ['none', WireNews.UNSPECIFIED],
  ['appeared', WireNews.APPEARED],
  ['grown', WireNews.GROWN],
  ['changed', WireNews.CHANGED],
  ['gone', WireNews.GONE],
]);
const onDisk = byWire<OnDisk, WireOnDisk>([
  ['as read', WireOnDisk.UNSPECIFIED],
  ['changed', WireOnDisk.CHANGED],
  ['gone', WireOnDisk.GONE],
]);
const roles = byWire<Role, WireRole>([
  ['controller', WireRole.CONTROLLER],
  ['viewer', WireRole.VIEWER],
]);

const wireSurface = ({ color, ...rest }: Surface) => ({ ...rest, ...(color ? { color: wireRgb(color) } : {}) });
const wireTransfer = (points: readonly TransferPoint[]) => ({
  points: points.map(({ value, color, opacity }) => ({ value, color: wireRgb(color), opacity })),
});
const wireInterval = ({ color, surface, opacityUpper, transfer, ...rest }: Interval) => ({
  ...rest,
  color: wireRgb(color),
  ...(surface ? { surface: wireSurface(surface) } : {}),
  ...(typeof opacityUpper === 'number' ? { opacityUpper } : {}),
  ...(transfer ? { transferFunction: wireTransfer(transfer) } : {}),
});
const wireTerm = ({ op, color, opacity, priority, ...rest }: RangeTerm) => ({
  ...rest,
  op: operators.wire(op),
  ...(color ? { color: wireRgb(color) } : {}),
  ...(opacity !== null ? { opacity } : {}),
  ...(priority !== null ? { priority } : {}),
});

export const command = {
  hello: (
    viewport: ViewportSize,
    resumeToken: string,
    movingFormats: readonly string[] = ['jpeg'],
    clientId = '',
    movingFormat = '', // always this one of them; empty: the server chooses by measured times
    refines = false, // pictures of more samples follow the one at rest
  ): Command => ({
    case: 'hello',
    value: {
      protocolMajor,
      protocolMinor,
      client: 'isostrata-web 0.1.0',
      viewport,
      stillFormats: ['png', 'png-bands'],
      movingFormats: [...movingFormats],
      resumeToken,
      clientId,
      movingFormat,
      refines,
    },
  }),
  openDataset: (id: string): Command => ({ case: 'openDataset', value: { id } }),
  selectArrays: (array: string, colorBy: string, texture = '', values: FieldValues | null = null): Command => ({
    case: 'selectArrays',
    value: { array, colorBy, texture, ...(values ? { values: fieldValues.wire(values) } : {}) },
  }),
  setTimeStep: (step: number): Command => ({ case: 'setTimeStep', value: { step } }),
  setIntervals: (intervals: readonly Interval[]): Command => ({
    case: 'setIntervals',
    value: { intervals: intervals.map(wireInterval) },
  }),
  patchInterval: (id: number, patch: IntervalPatch): Command => {
    const { color, surface, opacityUpper, transfer, ...rest } = patch;
    const value = {
      id,
      ...rest,
      ...(color ? { color: wireRgb(color) } : {}),
      ...(surface !== undefined ? { surface: surface ? wireSurface(surface) : {} } : {}),
      ...(typeof opacityUpper === 'number' ? { opacityUpper } : {}),
      ...(opacityUpper === null ? { clearOpacityUpper: true } : {}),
      ...(transfer !== undefined ? { transferFunction: wireTransfer(transfer ?? []) } : {}),
    };
    return { case: 'patchInterval', value };
  },
  removeInterval: (id: number): Command => ({ case: 'removeInterval', value: { id } }),
  reorderPriorities: (ids: readonly number[]): Command => ({ case: 'reorderPriorities', value: { ids: [...ids] } }),
  setCamera: (camera: Camera): Command => ({
    case: 'setCamera',
    value: {
      camera: { eye: wireVec(camera.eye), at: wireVec(camera.at), up: wireVec(camera.up), fovDeg: camera.fovDeg,
        orthographic: camera.orthographic ?? false,
      },
    },
  }),
  setClipPlanes: (planes: readonly ClipPlane[]): Command => ({
    case: 'setClipPlanes',
    value: { clipPlanes: planes.map(({ normal, offset }) => ({ normal: wireVec(normal), offset })) },
  }),
  setAnnotations: (annotations: Annotations): Command => ({ case: 'setAnnotations', value: { annotations } }),
  setView: (view: string): Command => ({ case: 'setView', value: { view } }),
  setCombination: (terms: readonly RangeTerm[]): Command => ({ case: 'setCombination', value: { terms: terms.map(wireTerm) } }),
  setTime: (time: number | null, mode: TimeMode): Command => ({
    case: 'setTime',
    value: { mode: timeModes.wire(mode), ...(time !== null ? { time } : {}) },
  }),
  setCycle: (cycle: Partial<Cycle>): Command => ({ case: 'setCycle', value: cycle }),
  setSmear: ({ steps, times, colors }: Smear): Command => ({
    case: 'setSmear',
    value: { smear: { steps: [...steps], times: [...times], colors: colors.map(wireRgb) } },
  }),
  setAppearance: (change: {
    mode?: RenderMode;
    background?: Rgb;
    unitDistance?: number;
    colorRange?: ColorRange;
    occlusion?: number;
    depthFade?: number;
  }): Command => ({
    case: 'setAppearance',
    value: {
      mode: change.mode ? modes.wire(change.mode) : WireMode.UNSPECIFIED,
      ...(change.background ? { background: wireRgb(change.background) } : {}),
      ...(change.unitDistance !== undefined ? { unitDistance: change.unitDistance } : {}),
      ...(change.occlusion !== undefined ? { occlusion: change.occlusion } : {}),
      ...(change.depthFade !== undefined ? { depthFade: change.depthFade } : {}),
      ...(change.colorRange ? { colorRange: { ...change.colorRange, span: spans.wire(change.colorRange.span) } } : {}),
    },
  }),
  viewport: (viewport: ViewportSize): Command => ({ case: 'viewport', value: viewport }),
  interaction: (active: boolean): Command => ({ case: 'interaction', value: { active } }),
  frameAck: (frameId: bigint, decodeMs: number): Command => ({ case: 'frameAck', value: { frameId, decodeMs } }),
  decoderFailed: ({ streamId, message, again }: { streamId: number; message: string; again: boolean }): Command => ({
    case: 'decoderFailed',
    value: { streamId: BigInt(streamId), problem: message.slice(0, 500), again },
  }),
  requestStill: (width: number, height: number, annotations: Annotations): Command => ({
    case: 'requestStill',
    value: { width, height, annotations },
  }),
  requestHistogram: (array: string, bins: number): Command => ({ case: 'requestHistogram', value: { array, bins } }),
  reloadDataset: (): Command => ({ case: 'reloadDataset', value: {} }),
  listDatasets: (folder: string, search: string, first: number, most: number): Command => ({
    case: 'listDatasets',
    value: { folder, search, first, most },
  }),
  cancel: (operation: bigint): Command => ({ case: 'cancel', value: { operation } }),
  setRole: (participant: bigint, role: Role): Command => ({ case: 'setRole', value: { participant, role: roles.wire(role) } }),
  createInvitation: (role: Role, seconds: number, name: string): Command => ({
    case: 'createInvitation',
    value: { role: roles.wire(role), seconds, name },
  }),
  revokeInvitation: (id: string): Command => ({ case: 'revokeInvitation', value: { id } }),
  listInvitations: (): Command => ({ case: 'listInvitations', value: {} }),
  ping: (clientTimeMs: number): Command => ({ case: 'ping', value: { clientTimeMs } }),
};

/** number: of a command that may be sent again, over all connections; 0: none. */
export function encodeCommand(seq: number, body: Command, number = 0): Uint8Array<ArrayBuffer> {
  const bytes = toBinary(ClientMessageSchema, create(ClientMessageSchema, { seq: BigInt(seq), body, command: BigInt(number) }));
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
    case 'datasetList':
      return { kind: 'datasetList', list: listOf(body.value) };
    case 'datasetsChanged':
      return { kind: 'datasetsChanged', all: body.value.all, entries: body.value.entries.map(entryOf) };
    case 'histogram': {
      const { dataset, step, array, lower, upper, counts } = body.value;
      return { kind: 'histogram', histogram: { dataset, step, array, lower, upper, counts: counts.map(Number) } };
    }
    case 'frame':
      return { kind: 'frame', frame: frameOf(body.value) };
    case 'layerFacts':
      return {
        kind: 'volumeErrors',
        errors: body.value.intervals.flatMap(({ id, volume, volumeError: error }) => (error === undefined ? [] : [{ id, volume, error }])),
      };
    case 'progress': {
      const { operation, stage, fraction, background } = body.value;
      return { kind: 'progress', progress: { operation, stage, fraction, background } };
    }
    case 'done':
      return { kind: 'done', operation: body.value.operation, cancelled: body.value.cancelled, superseded: body.value.superseded };
    case 'error': {
      const { inReplyTo, code, message, field } = body.value;
      return { kind: 'error', error: { inReplyTo: Number(inReplyTo), code, message, field } };
    }
    case 'pong':
      return { kind: 'pong', clientTimeMs: body.value.clientTimeMs };
    case 'shutdown':
      return {
        kind: 'shutdown',
        reason: body.value.reason,
        notice: body.value.notice,
        seconds: body.value.seconds,
        comesBack: body.value.comesBack,
      };
    case 'participants':
      return {
        kind: 'participants',
        participants: body.value.participants.map(({ id, name, role, invited, client }) => ({
          id,
          name,
          role: roles.name(role),
          invited,
          client,
        })),
      };
    case 'invitation':
      return { kind: 'invitation', invitation: invitationOf(body.value) };
    case 'invitations':
      return { kind: 'invitations', invitations: body.value.invitations.map(invitationOf) };
    default:
      return { kind: 'unknown' };
  }
}

const vecOf = (v: WireVec3 | undefined): Vec3 => (v ? [v.x, v.y, v.z] : [0, 0, 0]);
const rgbOf = (c: WireRgb | undefined): Rgb => (c ? [c.r, c.g, c.b] : [0, 0, 0]);

const surfaceOf = (s: WireSurface): Surface => ({
  lower: s.lower,
  upper: s.upper,
  domain: s.domain,
  color: s.color ? rgbOf(s.color) : null,
  opacity: s.opacity ?? 1,
  ambient: s.ambient ?? 0.25,
  diffuse: s.diffuse ?? 0.75,
  specular: s.specular ?? 0.3,
  shininess: s.shininess ?? 30,
  silhouette: s.silhouette,
  texture: s.texture,
  textureRepeat: s.textureRepeat ?? 1,
});

const intervalOf = (i: WireInterval): Interval => ({
  id: i.id,
  lower: i.lower,
  upper: i.upper,
  color: rgbOf(i.color),
  colorMap: i.colorMap,
  opacity: i.opacity,
  priority: i.priority,
  visible: i.visible,
  name: i.name,
  number: i.number,
  opacityUpper: i.opacityUpper ?? null,
  ownRange: i.ownRange,
  surface: i.surface ? surfaceOf(i.surface) : null,
  transfer: i.transferFunction?.points.length
    ? i.transferFunction.points.map((p) => ({ value: p.value, color: rgbOf(p.color), opacity: p.opacity }))
    : null,
});

const invitationOf = ({ id, role, expiresUnixMs, name, token, present }: WireInvitation): Invitation => ({
  id,
  role: roles.name(role),
  expiresUnixMs,
  name,
  token,
  present,
});

const termOf = (t: WireTerm): RangeTerm => ({
  op: operators.name(t.op),
  array: t.array,
  lower: t.lower,
  upper: t.upper,
  color: t.color ? rgbOf(t.color) : null,
  colorMap: t.colorMap,
  opacity: t.opacity ?? null,
  priority: t.priority ?? null,
  hidden: t.hidden,
});

function cameraOf(c: WireCamera | undefined): Camera | null {
  if (!c?.eye || !c.at || !c.up) return null;
  return { eye: vecOf(c.eye), at: vecOf(c.at), up: vecOf(c.up), fovDeg: c.fovDeg, orthographic: c.orthographic };
}

function stateOf(s: WireState): SceneState {
  return {
    revision: Number(s.revision),
    dataset: s.dataset,
    step: s.step,
    array: s.array,
    colorBy: s.colorBy,
    intervals: s.intervals.map(intervalOf),
    mode: modes.name(s.mode),
    camera: cameraOf(s.camera),
    background: rgbOf(s.background),
    unitDistance: s.unitDistance,
    occlusion: s.occlusion,
    depthFade: s.depthFade,
    clipPlanes: s.clipPlanes.map((plane) => ({ normal: vecOf(plane.normal), offset: plane.offset })),
    annotations: {
      axes: s.annotations?.axes ?? false,
      box: s.annotations?.box ?? false,
      legend: s.annotations?.legend ?? false,
    },
    colorRange: {
      span: spans.name(s.colorRange?.span ?? 0),
      lower: s.colorRange?.lower ?? 0,
      upper: s.colorRange?.upper ?? 0,
      log: s.colorRange?.log ?? false,
    },
    terms: s.terms.map(termOf),
    time: s.time ?? null,
    timeMode: timeModes.name(s.timeMode),
    texture: s.texture,
    values: fieldValues.name(s.values),
    cycle: s.cycle
      ? { seconds: s.cycle.seconds || 1, phase: s.cycle.phase, playing: s.cycle.playing }
      : { seconds: 1, phase: 0, playing: false },
    smear: { steps: s.smear?.steps ?? [], times: s.smear?.times ?? [], colors: (s.smear?.colors ?? []).map(rgbOf) },
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
    arrays: d.arrays.map(({ name, association, type, components, lower, upper, nanCount, stepLower, stepUpper, cellLower, cellUpper }) => ({
      name,
      association,
      type,
      components,
      lower,
      upper,
      nanCount: Number(nanCount),
      cells: cellLower !== undefined && cellUpper !== undefined && cellLower <= cellUpper ? { lower: cellLower, upper: cellUpper } : null,
      steps: stepLower.map((least, step) => ({ lower: least, upper: stepUpper[step] ?? least })),
    })),
    missingRangeSteps: d.missingRangeSteps,
    nothingToShow: d.nothingToShow,
    onDisk: onDisk.name(d.onDisk),
    times: d.times,
    notes: d.notes,
  };
}

const entryOf = (e: WireEntry): DatasetEntry => ({
  id: e.id,
  name: e.name,
  kind: e.kind,
  bytes: Number(e.bytes),
  changedMs: e.changedUnixMs,
  files: e.files,
  steps: e.steps,
  news: news.name(e.news),
  noticedMs: e.noticedUnixMs,
  writing: e.writing,
});

const listOf = (l: WireList): DatasetList => ({
  folder: l.folder,
  search: l.search,
  first: l.first,
  total: l.total,
  folders: l.folders.map((f) => ({ name: f.name, datasets: f.datasets, changedMs: f.changedUnixMs, news: f.news })),
  datasets: l.datasets.map(entryOf),
  all: l.all,
  passedOver: l.passedOver.map(({ reason, files, examples }) => ({ reason, files: Number(files), examples })),
  cutOff: l.cutOff,
  watching: l.watching,
  nowMs: l.nowUnixMs,
});

function welcomeOf(w: WireWelcome): Welcome {
  return {
    protocolMajor: w.protocolMajor,
    server: w.server,
    session: w.session,
    resumeToken: w.resumeToken,
    datasets: w.datasets.map(entryOf),
    datasetsAll: w.datasetsAll,
    state: w.state ? stateOf(w.state) : null,
    datasetInfo: w.datasetInfo ? datasetInfoOf(w.datasetInfo) : null,
    device: w.device,
    deviceIsSoftware: w.deviceIsSoftware,
    colorMaps: w.colorMaps,
    role: roles.name(w.role),
    participant: w.participant,
    lastCommand: Number(w.lastCommand),
    endsUnixMs: w.endsUnixMs,
    movingFormats: w.movingFormats,
    limits: {
      maxIntervals: w.limits?.maxIntervals || 256,
      maxTransferPoints: w.limits?.maxTransferPoints || 512,
      maxClipPlanes: w.limits?.maxClipPlanes || 32,
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
    phase: f.phase === FramePhase.LOSSLESS ? 'exact' : f.phase === FramePhase.SETTLED ? 'settled' : 'moving',
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
    pointStride: f.facts?.pointStride || 1,
    coarseError: f.facts?.coarseError ? { largest: f.facts.coarseError.largest, mean: f.facts.coarseError.mean } : null,
    samples: f.facts?.samples || 1,
    intervals: (f.facts?.intervals ?? []).map(({ id, activeCells, tetrahedra, volume, area }) => ({
      id,
      activeCells: Number(activeCells),
      tetrahedra: Number(tetrahedra),
      volume,
      area,
    })),
    camera: cameraOf(f.camera),
    streamId: Number(f.streamId),
    key: f.key,
    decoder: f.decoder,
    inReplyTo: Number(f.inReplyTo),
    band: f.band ? { firstRow: f.band.firstRow, rows: f.band.rows, index: f.band.index, count: f.band.count } : null,
    forecasts: f.forecasts.map(({ format, ms }) => ({ format, ms })),
    payload: f.payload as Uint8Array<ArrayBuffer>,
  };
}
