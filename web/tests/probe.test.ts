// A place of the picture: who asks, whose answer is shown, what it says; what is a click.
import { create, toBinary } from '@bufbuild/protobuf';
import { afterEach, beforeEach, describe, expect, test, vi } from 'vitest';
import { ProbeEnd, ServerMessageSchema } from '../src/gen/isostrata/v1/isostrata_pb';
import type { Command } from '../src/lib/commands';
import { decodeEvent } from '../src/lib/events';
import { emptyState, type Camera } from '../src/lib/model';
import { Press } from '../src/lib/press';
import { precisely, probedLayer, probeText } from '../src/lib/probe-words';
import { Probe } from '../src/lib/probe.svelte';
import type { ProbeResult } from '../src/lib/told';

const camera: Camera = { eye: [0, 0, 9], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 30 };
const found = (revision: number, more: Partial<ProbeResult> = {}): ProbeResult => ({
  revision,
  hit: true,
  miss: '',
  position: [0.5, -0.25, 1e-9],
  distance: 3,
  interval: 7,
  term: null,
  end: 'lower',
  cell: 12,
  point: 30,
  cellIndex: [1, 2, 3],
  pointIndex: [2, 2, 3],
  step: 0,
  time: null,
  arrays: [
    { name: 'distance', value: 0.1, cellValue: null },
    { name: 'label', value: null, cellValue: 4 },
  ],
  ...more,
});

describe('a place of the picture', () => {
  const sent: Command[] = [];
  let live = true;
  const probe = () => new Probe((body) => (live ? sent.push(body) : 0));
  beforeEach(() => {
    sent.length = 0;
    live = true;
  });

  test('shows the answer to the newest question alone, and takes late ones without a word', () => {
    const one = probe();
    one.ask(0.25, 0.5, camera);
    one.ask(0.5, 0.75, camera);
    expect(sent).toEqual([
      { case: 'probePoint', value: { x: 0.25, y: 0.5 } },
      { case: 'probePoint', value: { x: 0.5, y: 0.75 } },
    ]);
    expect(one.answer(1, 'a newer probe of this connection has taken its place')).toBe(true);
    expect(one.shown).toEqual({ x: 0.5, y: 0.75, answer: null });
    expect(one.answer(2, found(3))).toBe(true);
    expect(one.shown?.answer).toEqual(found(3));
    expect(one.answer(2, found(4))).toBe(false);
    expect(one.answer(9, 'a refusal of something else')).toBe(false);
    one.ask(0.1, 0.1, camera);
    one.close();
    expect(one.answer(3, found(5))).toBe(true);
    expect(one.shown).toBeNull();
  });

  test('stays until the camera moves, and is asked for again when the layers change', () => {
    const one = probe();
    one.ask(0.25, 0.5, camera);
    one.stateTold(9);
    expect(sent).toHaveLength(1); // an answer is on its way
    one.answer(1, found(3));
    one.stateTold(3);
    expect(sent).toHaveLength(1);
    one.stateTold(4);
    expect(sent).toHaveLength(2);
    expect(one.shown?.answer).toEqual(found(3)); // until the new one is there
    one.answer(2, found(4));
    one.seenFrom({ ...camera, eye: [0, 0, 9] });
    expect(one.shown?.answer).toEqual(found(4));
    one.seenFrom({ ...camera, eye: [0, 0, 8] });
    expect(one.shown).toBeNull();
  });

  test('says that there is no connection, and a lost one takes it away', () => {
    const one = probe();
    live = false;
    one.ask(0.25, 0.5, camera);
    expect(one.shown?.answer).toBe('There is no connection.');
    live = true;
    one.ask(0.25, 0.5, camera);
    one.lost();
    expect(one.shown).toBeNull();
    expect(one.answer(1, found(1))).toBe(false);
  });

  test('comes as the server says it', () => {
    const value = {
      inReplyTo: 5n,
      revision: 8n,
      hit: true,
      position: { x: 1, y: 2, z: 3 },
      interval: 7,
      end: ProbeEnd.CLIP_PLANE,
      cell: 0n,
      cellIndex: [0n, 0n, 0n],
      arrays: [{ name: 'a', value: 0 }, { name: 'b' }],
    };
    const event = decodeEvent(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body: { case: 'probeResult', value } })));
    expect(event).toMatchObject({ kind: 'probeResult', inReplyTo: 5 });
    expect(event.kind === 'probeResult' && event.result).toMatchObject({
      revision: 8,
      position: [1, 2, 3],
      end: 'cut',
      cell: 0,
      point: null,
      term: null,
      cellIndex: [0, 0, 0],
      arrays: [
        { name: 'a', value: 0, cellValue: null },
        { name: 'b', value: null, cellValue: null },
      ],
    });
  });
});

describe('a place in words', () => {
  const layer = { id: 7, lower: 0, upper: 1, color: [1, 0, 0] as const, colorMap: '', opacity: 1, priority: 0, visible: true, number: 3 };
  const term = { op: 'unite', array: 'pressure', lower: 0, upper: 1, color: null, colorMap: '', opacity: null, priority: null, hidden: false };
  const scene = { ...emptyState, intervals: [layer], terms: [term] } as unknown as typeof emptyState;

  test('a layer is called what the list calls it, and what a range brings in by its array', () => {
    expect(probedLayer(found(1), scene)).toBe('Layer 3');
    expect(probedLayer(found(1), { ...scene, intervals: [{ ...scene.intervals[0]!, name: 'shell' }] })).toBe('shell');
    expect(probedLayer(found(1, { interval: 0, term: 0 }), scene)).toBe('What pressure brings in');
  });
  test('numbers have the digits in which neighbours differ, and what is copied has all', () => {
    expect(precisely(0.123456789)).toBe('0.1234568');
    expect(precisely(-0)).toBe('0');
    expect(precisely(1000000.0007, 0.0017)).toBe('1000000.0007'); // all values lie so near to each other
    expect(precisely(101325.0234567, 1e5)).toBe('101325.02');
    expect(precisely(0.1, Number.MIN_VALUE)).toBe('0.1');
    for (const value of [3.5e-31, 7e29]) expect(precisely(value, 1e30)).toBe(String(value));
    expect(precisely(null)).toBe('no number');
    const text = probeText(found(1, { position: [1 / 3, 0, 0] }), scene);
    expect(text.split('\n')).toEqual([
      'layer\tLayer 3',
      'position\t0.3333333333333333\t0\t0',
      'cell i j k\t1\t2\t3',
      'nearest point i j k\t2\t2\t3',
      'step\t0',
      'distance\t0.1',
      'label\t',
      'label (cell)\t4',
    ]);
    expect(probeText(found(1, { cellIndex: [], pointIndex: [], time: 2.5 }), scene)).toContain('cell\t12\nnearest point\t30\ntime\t2.5');
  });
});

describe('a press', () => {
  const event = { pointerId: 1, pointerType: 'mouse', button: 0, shiftKey: false, ctrlKey: false, altKey: false, metaKey: false };
  const long = vi.fn();
  beforeEach(() => {
    vi.useFakeTimers();
    long.mockClear();
  });
  afterEach(() => {
    vi.useRealTimers();
  });

  test('is a click where it ends near its beginning, alone', () => {
    const press = new Press(long);
    press.begin(event, { x: 10, y: 10 });
    press.moveTo({ x: 12, y: 11 });
    expect(press.end(event)).toEqual({ x: 10, y: 10 });
    expect(press.end(event)).toBeNull();
    press.begin(event, { x: 10, y: 10 });
    press.moveTo({ x: 30, y: 10 });
    press.moveTo({ x: 10, y: 10 });
    expect(press.end(event)).toBeNull(); // a drag that came back
    press.begin({ ...event, shiftKey: true }, { x: 10, y: 10 });
    expect(press.end(event)).toBeNull();
    press.begin({ ...event, button: 2 }, { x: 10, y: 10 });
    expect(press.end(event)).toBeNull();
    press.begin(event, { x: 10, y: 10 });
    press.begin({ ...event, pointerId: 2 }, { x: 50, y: 50 });
    expect(press.end(event)).toBeNull(); // two pointers
  });

  test('of a finger is a long one that rests', () => {
    const press = new Press(long);
    const finger = { ...event, pointerType: 'touch' };
    press.begin(finger, { x: 10, y: 10 });
    press.moveTo({ x: 16, y: 12 });
    vi.advanceTimersByTime(499);
    expect(long).not.toHaveBeenCalled();
    vi.advanceTimersByTime(1);
    expect(long).toHaveBeenCalledWith({ x: 10, y: 10 });
    expect(press.end(finger)).toBeNull();
    press.begin(finger, { x: 10, y: 10 });
    expect(press.end(finger)).toBeNull(); // a tap
    vi.advanceTimersByTime(1000);
    press.begin(finger, { x: 10, y: 10 });
    press.moveTo({ x: 60, y: 10 });
    vi.advanceTimersByTime(1000);
    expect(long).toHaveBeenCalledTimes(1);
  });

  test('of a finger is a tap as well while a place is being picked', () => {
    let picking = true;
    const press = new Press(long, () => picking);
    const finger = { ...event, pointerType: 'touch' };
    press.begin(finger, { x: 10, y: 10 });
    expect(press.end(finger)).toEqual({ x: 10, y: 10 });
    press.begin(finger, { x: 10, y: 10 });
    press.moveTo({ x: 60, y: 10 });
    expect(press.end(finger)).toBeNull(); // it has turned the picture
    picking = false;
    press.begin(finger, { x: 10, y: 10 });
    expect(press.end(finger)).toBeNull();
  });
});
