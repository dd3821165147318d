// The scene on the wire, both ways: what is declared in Protobuf for a scene is handled here and nowhere else.
import {
  ColorSpan as WireSpan,
  FieldValues as WireFieldValues,
  RangeOperator as WireOperator,
  RenderMode as WireMode,
  TimeMode as WireTimeMode,
  type Camera as WireCamera,
  type Interval as WireInterval,
  type RangeTerm as WireTerm,
  type Rgb as WireRgb,
  type State as WireState,
  type Surface as WireSurface,
  type Vec3 as WireVec3,
} from '../gen/isostrata/v1/isostrata_pb';
import { create, type MessageInitShape } from '@bufbuild/protobuf';
import { StateSchema } from '../gen/isostrata/v1/isostrata_pb';
import {
  noSurface,
  stepRange,
  type Camera,
  type Interval,
  type RangeTerm,
  type Rgb,
  type SceneState,
  type Surface,
  type TransferPoint,
  type Vec3,
} from './model';
import { names, plain } from './protocol';

export const modes = names(WireMode, 'sorted');
export const spans = names(WireSpan, 'step');
export const timeModes = names(WireTimeMode, 'step');
export const fieldValues = names(WireFieldValues, 'interpolated');
const operators = names(WireOperator, 'intersect');

export const wireVec = (v: Vec3) => ({ x: v[0], y: v[1], z: v[2] });
export const wireRgb = (c: Rgb) => ({ r: c[0], g: c[1], b: c[2] });

export const wireSurface = ({ color, ...rest }: Surface) => ({ ...rest, ...(color ? { color: wireRgb(color) } : {}) });
export const wireTransfer = (points: readonly TransferPoint[]) => ({
  points: points.map(({ value, color, opacity }) => ({ value, color: wireRgb(color), opacity })),
});
export const wireInterval = ({ color, surface, opacityUpper, transfer, ...rest }: Interval) => ({
  ...rest,
  color: wireRgb(color),
  ...(surface ? { surface: wireSurface(surface) } : {}),
  ...(typeof opacityUpper === 'number' ? { opacityUpper } : {}),
  ...(transfer ? { transferFunction: wireTransfer(transfer) } : {}),
});
export const wireTerm = ({ op, color, opacity, priority, ...rest }: RangeTerm) => ({
  ...rest,
  op: operators.wire(op),
  ...(color ? { color: wireRgb(color) } : {}),
  ...(opacity !== null ? { opacity } : {}),
  ...(priority !== null ? { priority } : {}),
});

export const vecOf = (v: WireVec3 | undefined): Vec3 => (v ? [v.x, v.y, v.z] : [0, 0, 0]);
const rgbOf = (c: WireRgb | undefined): Rgb => (c ? [c.r, c.g, c.b] : [0, 0, 0]);

const surfaceOf = (surface: WireSurface): Surface => ({
  ...noSurface,
  ...plain(surface), // what is not said is not in it
  color: surface.color ? rgbOf(surface.color) : null,
});

function intervalOf(interval: WireInterval): Interval {
  const { color, opacityUpper = null, surface, transferFunction, ...rest } = plain(interval);
  return {
    ...rest,
    color: rgbOf(color),
    opacityUpper,
    surface: surface ? surfaceOf(surface) : null,
    transfer: transferFunction?.points.length ? transferFunction.points.map((point) => ({ ...plain(point), color: rgbOf(point.color) })) : null,
  };
}

function termOf(term: WireTerm): RangeTerm {
  const { op, color, opacity = null, priority = null, ...rest } = plain(term);
  return { ...rest, op: operators.name(op), color: color ? rgbOf(color) : null, opacity, priority };
}

export function cameraOf(camera: WireCamera | undefined): Camera | null {
  if (!camera?.eye || !camera.at || !camera.up) return null;
  return { ...plain(camera), eye: vecOf(camera.eye), at: vecOf(camera.at), up: vecOf(camera.up) };
}

const wireCamera = ({ eye, at, up, ...rest }: Camera) => ({ ...rest, eye: wireVec(eye), at: wireVec(at), up: wireVec(up) });

export function wireState(state: SceneState): WireState {
  const { annotations, axisScale, background, camera, clipPlanes, colorRange, cycle, intervals, mode, revision, smear, terms, time, timeMode, values, ...rest } = state;
  const init: MessageInitShape<typeof StateSchema> = {
    ...rest,
    background: wireRgb(background),
    clipPlanes: (clipPlanes ?? []).map(({ normal, offset }) => ({ normal: wireVec(normal), offset })),
    cycle,
    intervals: intervals.map(wireInterval),
    mode: modes.wire(mode),
    revision: BigInt(revision),
    smear: { ...smear, colors: smear.colors.map(wireRgb) },
    terms: terms.map(wireTerm),
    timeMode: timeModes.wire(timeMode),
    values: fieldValues.wire(values ?? 'interpolated'),
    ...(annotations ? { annotations } : {}),
    ...(axisScale ? { axisScale: wireVec(axisScale) } : {}),
    ...(camera ? { camera: wireCamera(camera) } : {}),
    ...(colorRange ? { colorRange: { ...colorRange, span: spans.wire(colorRange.span) } } : {}),
    ...(time !== null ? { time } : {}),
  };
  return create(StateSchema, init);
}

export function stateOf(state: WireState): SceneState {
  const { annotations, axisScale, background, camera, clipPlanes, colorRange, cycle, intervals, mode, revision, smear, terms, time, timeMode, values, ...rest } =
    plain(state);
  return {
    ...rest,
    annotations: annotations ? plain(annotations) : { axes: false, box: false, legend: false },
    background: rgbOf(background),
    camera: cameraOf(camera),
    axisScale: axisScale ? vecOf(axisScale) : [1, 1, 1],
    clipPlanes: clipPlanes.map(({ normal, offset }) => ({ normal: vecOf(normal), offset })),
    colorRange: colorRange ? { ...plain(colorRange), span: spans.name(colorRange.span) } : stepRange,
    cycle: cycle ? { ...plain(cycle), seconds: cycle.seconds || 1 } : { seconds: 1, phase: 0, playing: false },
    intervals: intervals.map(intervalOf),
    mode: modes.name(mode),
    revision: Number(revision),
    smear: { steps: smear?.steps ?? [], times: smear?.times ?? [], colors: (smear?.colors ?? []).map(rgbOf) },
    terms: terms.map(termOf),
    time: time ?? null,
    timeMode: timeModes.name(timeMode),
    values: fieldValues.name(values),
  };
}
