import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { ClientMessageSchema, FramePhase, RenderMode, ServerMessageSchema } from '../src/gen/isostrata/v1/isostrata_pb';
import { command, encodeCommand } from '../src/lib/commands';
import { decodeEvent } from '../src/lib/events';
import { noSurface, type Interval } from '../src/lib/model';
import { modes } from '../src/lib/wire-scene';

const decode = (bytes: Uint8Array) => fromBinary(ClientMessageSchema, bytes);

test('a patch carries the fields that changed and no others', () => {
  const { seq, body } = decode(encodeCommand(7, command.patchInterval(3, { lower: 0, visible: false })));
  expect(seq).toBe(7n);
  if (body.case !== 'patchInterval') throw new Error(`unexpected ${String(body.case)}`);
  expect(body.value.id).toBe(3);
  expect(body.value.lower).toBe(0); // zero and false are values too
  expect(body.value.visible).toBe(false);
  expect(body.value.upper).toBeUndefined();
  expect(body.value.color).toBeUndefined();
  expect(body.value.opacity).toBeUndefined();
});

test('an appearance without a mode leaves the mode alone', () => {
  const { body } = decode(encodeCommand(1, command.setAppearance({ unitDistance: 0 })));
  if (body.case !== 'setAppearance') throw new Error(`unexpected ${String(body.case)}`);
  expect(body.value.mode).toBe(RenderMode.UNSPECIFIED);
  expect(body.value.unitDistance).toBe(0);
  expect(body.value.background).toBeUndefined();
});

test('a camera comes back from the server as it was sent, to the last bit', () => {
  const camera = { eye: [0.1, 1 / 3, -7e-9], at: [1, 2, 3], up: [0, 1, 0], fovDeg: 31.7, orthographic: true } as const;
  const sent = decode(encodeCommand(1, command.setCamera(camera))).body;
  if (sent.case !== 'setCamera') throw new Error(`unexpected ${String(sent.case)}`);
  const message = create(ServerMessageSchema, { body: { case: 'state', value: { camera: sent.value.camera } } });
  const event = decodeEvent(toBinary(ServerMessageSchema, message));
  expect(event.kind === 'state' && event.state.camera).toEqual(camera);
});

test('a frame becomes plain numbers, its phase in words', () => {
  const message = create(ServerMessageSchema, {
    body: {
      case: 'frame',
      value: { frameId: 9n, revision: 4n, inputSeq: 12n, phase: FramePhase.LOSSLESS, format: 'png', payload: new Uint8Array([1, 2]) },
    },
  });
  const event = decodeEvent(toBinary(ServerMessageSchema, message));
  if (event.kind !== 'frame') throw new Error(`unexpected ${event.kind}`);
  expect(event.frame).toMatchObject({ frameId: 9n, revision: 4, inputSeq: 12, phase: 'exact', camera: null, tetrahedra: 0 });
  expect([...event.frame.payload]).toEqual([1, 2]);
});

test('the three phases are told apart', () => {
  const phaseOf = (phase: FramePhase) => {
    const event = decodeEvent(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body: { case: 'frame', value: { phase } } })));
    return event.kind === 'frame' ? event.frame.phase : event.kind;
  };
  expect([FramePhase.MOVING, FramePhase.SETTLED, FramePhase.LOSSLESS, FramePhase.UNSPECIFIED].map(phaseOf)).toEqual([
    'moving',
    'settled',
    'exact',
    'moving',
  ]);
});

test('a message of a later version is unknown, not an error', () => {
  expect(decodeEvent(new Uint8Array([0x08, 0x01, 0xfa, 0x01, 0x00]))).toEqual({ kind: 'unknown' });
});

test('a welcome without limits still has some', () => {
  const message = create(ServerMessageSchema, { body: { case: 'welcome', value: { protocolMajor: 1 } } });
  const event = decodeEvent(toBinary(ServerMessageSchema, message));
  expect(event.kind === 'welcome' && event.welcome.limits.maxIntervals).toBeGreaterThan(0);
  expect(event.kind === 'welcome' && event.welcome.state).toBeNull();
});

test('the range of colours goes out as a whole and comes back as it was sent', () => {
  const range = { span: 'own', lower: 0.1, upper: 1 / 3, log: true } as const;
  const sent = decode(encodeCommand(1, command.setAppearance({ colorRange: range }))).body;
  if (sent.case !== 'setAppearance') throw new Error(`unexpected ${String(sent.case)}`);
  const message = create(ServerMessageSchema, { body: { case: 'state', value: { colorRange: sent.value.colorRange } } });
  const event = decodeEvent(toBinary(ServerMessageSchema, message));
  expect(event.kind === 'state' && event.state.colorRange).toEqual(range);
  const none = decodeEvent(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body: { case: 'state', value: {} } })));
  expect(none.kind === 'state' && none.state.colorRange).toEqual({ span: 'step', lower: 0, upper: 0, log: false });
});

test('light by depth goes out by itself and comes back as it was sent', () => {
  const sent = decode(encodeCommand(1, command.setAppearance({ occlusion: 0.75 }))).body;
  if (sent.case !== 'setAppearance') throw new Error(`unexpected ${String(sent.case)}`);
  expect([sent.value.occlusion, sent.value.depthFade]).toEqual([0.75, undefined]);
  const fade = decode(encodeCommand(1, command.setAppearance({ depthFade: 0 }))).body;
  expect(fade.case === 'setAppearance' && fade.value.depthFade).toBe(0); // off is something to say
  const message = create(ServerMessageSchema, { body: { case: 'state', value: { occlusion: 0.75, depthFade: 0.25 } } });
  const event = decodeEvent(toBinary(ServerMessageSchema, message));
  expect(event.kind === 'state' && [event.state.occlusion, event.state.depthFade]).toEqual([0.75, 0.25]);
});

test('a scale of axes is three numbers, and 1 where nothing is said', () => {
  const sent = decode(encodeCommand(1, command.setAppearance({ axisScale: [1, 1, 50] }))).body;
  if (sent.case !== 'setAppearance') throw new Error(String(sent.case));
  expect(sent.value.axisScale).toMatchObject({ x: 1, y: 1, z: 50 });
  const said = (value: object) => {
    const event = decodeEvent(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body: { case: 'state', value } })));
    return event.kind === 'state' ? event.state.axisScale : null;
  };
  expect(said({ axisScale: { x: 2, y: 1, z: 0.5 } })).toEqual([2, 1, 0.5]);
  expect(said({})).toEqual([1, 1, 1]);
});

test('body shading goes out by itself and comes back as it was sent', () => {
  const sent = decode(encodeCommand(1, command.setAppearance({ bodyShading: 0.75 }))).body;
  if (sent.case !== 'setAppearance') throw new Error(`unexpected ${String(sent.case)}`);
  expect([sent.value.bodyShading, sent.value.occlusion]).toEqual([0.75, undefined]);
  const off = decode(encodeCommand(1, command.setAppearance({ bodyShading: 0 }))).body;
  expect(off.case === 'setAppearance' && off.value.bodyShading).toBe(0); // off is something to say
  const event = decodeEvent(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body: { case: 'state', value: { bodyShading: 0.5 } } })));
  expect(event.kind === 'state' && event.state.bodyShading).toBe(0.5);
});

test('a surface of which little is said is drawn like any other', () => {
  const layer = { id: 1, color: { r: 1 }, surface: { lower: true, shininess: 0 } };
  const message = create(ServerMessageSchema, { body: { case: 'state', value: { intervals: [layer] } } });
  const event = decodeEvent(toBinary(ServerMessageSchema, message));
  expect(event.kind === 'state' && event.state.intervals[0]?.surface).toEqual({ ...noSurface, lower: true, shininess: 0 });
});

test('a layer goes out and comes back as it was, with and without what it may lack', () => {
  const transfer = [
    { value: 0.5, color: [0.5, 0, 1], opacity: 0.25 },
    { value: 2, color: [0, 1, 0], opacity: 0.75 },
  ] as const;
  const plain: Interval = { id: 3, lower: 0.5, upper: 2, color: [1, 0, 0.5], colorMap: '', opacity: 0.5, priority: 2, visible: true,
    name: 'bone', number: 4, opacityUpper: null, ownRange: true, surface: null, transfer: null };
  const full: Interval = { ...plain, opacityUpper: 0, surface: { ...noSurface, color: [0, 0.5, 1], upper: true }, transfer: [...transfer] };
  const { body } = decode(encodeCommand(1, command.setIntervals([plain, full])));
  if (body.case !== 'setIntervals') throw new Error(`unexpected ${String(body.case)}`);
  const message = create(ServerMessageSchema, { body: { case: 'state', value: { intervals: body.value.intervals } } });
  const event = decodeEvent(toBinary(ServerMessageSchema, message));
  expect(event.kind === 'state' && event.state.intervals).toEqual([plain, full]);
});

test('enumerations have the names of the wire, and what is not known counts as what is not said', () => {
  for (const [value, name] of [[RenderMode.SORTED, 'sorted'], [RenderMode.PRIORITIZED, 'prioritized'], [RenderMode.CYCLED, 'cycled'], [RenderMode.SMEAR, 'smear']] as const) {
    expect([modes.name(value), modes.wire(name)]).toEqual([name, value]);
  }
  expect([modes.name(0), modes.name(99)]).toEqual(['sorted', 'sorted']);
  expect(modes.wire('of an older page' as never)).toBe(RenderMode.SORTED);
  expect(modes.wire('1' as never)).toBe(RenderMode.SORTED);
});
