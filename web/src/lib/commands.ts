// What the page says: commands become bytes.
import { create, toBinary, type MessageInitShape } from '@bufbuild/protobuf';
import { ClientMessageSchema, RenderMode as WireMode } from '../gen/isostrata/v1/isostrata_pb';
import type {
  Annotations,
  Camera,
  ClipPlane,
  ColorRange,
  Cycle,
  FieldValues,
  Interval,
  IntervalPatch,
  RangeTerm,
  RenderMode,
  Rgb,
  Smear,
  TimeMode,
  Vec3,
} from './model';
import type { Role, Size } from './told';
import { protocolMajor, protocolMinor, roles } from './protocol';
import { fieldValues, modes, spans, timeModes, wireInterval, wireRgb, wireSurface, wireTerm, wireTransfer, wireVec } from './wire-scene';

/** The body of one ClientMessage. */
export type Command = NonNullable<MessageInitShape<typeof ClientMessageSchema>['body']>;

export interface ViewportSize {
  width: number;
  height: number;
  hidden: boolean;
}

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
    bodyShading?: number;
    axisScale?: Vec3;
  }): Command => ({
    case: 'setAppearance',
    value: {
      mode: change.mode ? modes.wire(change.mode) : WireMode.UNSPECIFIED,
      ...(change.background ? { background: wireRgb(change.background) } : {}),
      ...(change.unitDistance !== undefined ? { unitDistance: change.unitDistance } : {}),
      ...(change.occlusion !== undefined ? { occlusion: change.occlusion } : {}),
      ...(change.depthFade !== undefined ? { depthFade: change.depthFade } : {}),
      ...(change.bodyShading !== undefined ? { bodyShading: change.bodyShading } : {}),
      ...(change.axisScale ? { axisScale: wireVec(change.axisScale) } : {}),
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
  requestStill: (width: number, height: number, annotations: Annotations, transparent = false): Command => ({
    case: 'requestStill',
    value: { width, height, annotations, ...(transparent ? { transparent } : {}) },
  }),
  requestHistogram: (array: string, bins: number): Command => ({ case: 'requestHistogram', value: { array, bins } }),
  probePoint: (x: number, y: number): Command => ({ case: 'probePoint', value: { x, y } }),
  probeLine: (from: Vec3, to: Vec3, array: string): Command => ({ case: 'probeLine', value: { from: wireVec(from), to: wireVec(to), array } }),
  /** null: what was asked before and is not answered is given up. */
  probeSteps: (at: Vec3 | null, array: string): Command => ({ case: 'probeSteps', value: { ...(at ? { at: wireVec(at) } : {}), array } }),
  requestLayerStatistics: (interval: number, array: string): Command => ({ case: 'requestLayerStatistics', value: { interval, array } }),
  reloadDataset: (): Command => ({ case: 'reloadDataset', value: {} }),
  listDatasets: (folder: string, search: string, first: number, most: number): Command => ({
    case: 'listDatasets',
    value: { folder, search, first, most },
  }),
  cancel: (operation: bigint): Command => ({ case: 'cancel', value: { operation } }),
  setRole: (participant: bigint, role: Role): Command => ({ case: 'setRole', value: { participant, role: roles.wire(role) } }),
  setViewerSize: (size: Size): Command => ({ case: 'setViewerSize', value: size }),
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
