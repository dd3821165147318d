// Values along a line and over the steps: who asks when, which end is picked, what is drawn and saved.
import { create, toBinary } from '@bufbuild/protobuf';
import { beforeEach, describe, expect, test } from 'vitest';
import { ServerMessageSchema } from '../src/gen/isostrata/v1/isostrata_pb';
import type { Command } from '../src/lib/commands';
import { curvePath, curveRange, lineTable, nearestSample, stepsTable, valueAt } from '../src/lib/curve-shape';
import { Curves } from '../src/lib/curves.svelte';
import { decodeEvent } from '../src/lib/events';
import { emptyState, type SceneState, type Vec3 } from '../src/lib/model';
import { parsePlots, plotsText, type SavedPlots } from '../src/lib/saved-plots';
import type { ProbedCurve } from '../src/lib/told';

const a: Vec3 = [0, 0, 0];
const b: Vec3 = [2, 0, 0];
const state = (more: Partial<SceneState> = {}): SceneState => ({ ...emptyState, dataset: 'd', array: 'f', ...more });
const curve = (more: Partial<ProbedCurve> = {}): ProbedCurve => ({ revision: 1, array: 'f', at: [0, 1, 2], values: [1, 3, 2], thinned: false, gridsDiffer: false, layers: [], ...more });

describe('curves', () => {
  const sent: Command[] = [];
  let live = true;
  const make = () => {
    const one = new Curves((body) => (live ? sent.push(body) : 0));
    one.told(state());
    return one;
  };
  beforeEach(() => {
    sent.length = 0;
    live = true;
  });

  test('two picked places are a line, and one more changes the end that is picked', () => {
    const one = make();
    one.pick('from');
    one.picked(a);
    expect([one.start, one.picking, sent.length]).toEqual([a, 'to', 0]);
    one.picked(b);
    expect([one.place, one.picking]).toEqual([{ kind: 'line', from: a, to: b }, null]);
    expect(sent).toMatchObject([{ case: 'probeLine', value: { from: { x: 0 }, to: { x: 2 }, array: '' } }]);
    one.pick('from');
    one.picked([1, 1, 1]);
    expect(one.place).toEqual({ kind: 'line', from: [1, 1, 1], to: b });
    one.picked([5, 5, 5]); // nobody picks
    expect(one.place).toEqual({ kind: 'line', from: [1, 1, 1], to: b });
    one.beginAt(a);
    one.pick(null);
    expect([one.start, one.place]).toEqual([null, { kind: 'line', from: [1, 1, 1], to: b }]);
  });

  test('a line is asked for again when what it shows changes, once at a time, and not when the camera moves', () => {
    const one = make();
    one.show({ kind: 'line', from: a, to: b });
    one.told(state({ revision: 2, step: 1 }));
    one.told(state({ revision: 3, step: 2 }));
    expect(sent).toHaveLength(1); // one is on its way
    one.answered(1, curve());
    expect(one.answer).toEqual(curve());
    expect(sent).toHaveLength(2); // the newest step
    one.answered(2, curve({ revision: 3 }));
    one.told(state({ revision: 4, step: 2, camera: { eye: [0, 0, 9], at: a, up: [0, 1, 0], fovDeg: 30 } }));
    expect(sent).toHaveLength(2);
    one.ofArray('g');
    expect(sent[2]).toMatchObject({ case: 'probeLine', value: { array: 'g' } });
    expect(one.answered(99, 'not mine')).toBe(false);
  });

  test('over the steps, neither the step nor the layers matter; closing gives up what is being read', () => {
    const one = make();
    one.show({ kind: 'steps', at: a });
    one.answered(1, curve());
    one.told(state({ revision: 2, step: 4 }));
    expect(sent).toHaveLength(1);
    one.told(state({ revision: 3, array: 'g' }));
    expect(sent[1]).toMatchObject({ case: 'probeSteps', value: { array: 'g' } });
    one.answered(2, 'cancelled');
    one.again();
    expect([one.answer, one.waits, sent.length]).toEqual([null, true, 3]);
    one.close();
    expect(sent[3]).toEqual({ case: 'probeSteps', value: { array: '' } });
    expect(one.answered(3, 'cancelled')).toBe(true);
    expect([one.place, one.answer]).toEqual([null, null]);
  });

  test('another dataset closes it, and what a lost connection took is asked for again', () => {
    const one = make();
    one.show({ kind: 'line', from: a, to: b });
    one.lost();
    expect(one.answered(1, curve())).toBe(false);
    one.told(state({ revision: 1 }));
    expect(sent).toHaveLength(2);
    one.told(state({ dataset: 'another' }));
    expect(one.place).toBeNull();
    live = false;
    one.show({ kind: 'line', from: a, to: b });
    expect(one.answer).toBe('There is no connection.');
  });

  test('files that are read anew are asked again; steps that come concern curves over the steps alone', () => {
    const one = make();
    one.dataTold(0, 4);
    one.show({ kind: 'line', from: a, to: b });
    one.answered(1, curve());
    one.dataTold(0, 5);
    expect(sent).toHaveLength(1);
    one.dataTold(1, 5);
    expect(sent).toHaveLength(2);
    one.answered(2, curve());
    one.show({ kind: 'steps', at: a });
    one.answered(3, curve());
    one.dataTold(1, 5);
    expect(sent).toHaveLength(3);
    one.dataTold(1, 6);
    expect(sent[3]).toMatchObject({ case: 'probeSteps' });
  });

  test('what is open is saved as a text, and asked for again where nothing is open', () => {
    let saved: SavedPlots | null = null;
    const one = new Curves((body) => sent.push(body), () => (saved = parsePlots(plotsText({ dataset: 'd', curve: one.open, layers: [[3, 'g']] }))));
    one.told(state());
    one.ofArray('g');
    one.show({ kind: 'line', from: a, to: b });
    expect(saved).toEqual({ dataset: 'd', curve: { place: { kind: 'line', from: a, to: b }, array: 'g' }, layers: [[3, 'g']] });
    const again = make();
    again.restore(saved!.curve!);
    expect(sent.at(-1)).toMatchObject({ case: 'probeLine', value: { to: { x: 2 }, array: 'g' } });
    again.restore({ place: { kind: 'steps', at: a }, array: '' });
    expect(again.place?.kind).toBe('line');
    one.close();
    expect(saved).toEqual({ dataset: 'd', curve: null, layers: [[3, 'g']] });
    expect(plotsText({ dataset: 'd', curve: null, layers: [] })).toBe('');
    for (const text of ['', 'x', '{}', '{"dataset":"d","curve":{"place":{"kind":"line","from":[0,0],"to":[1,1,1]},"array":""},"layers":[]}', '{"dataset":"d","curve":null,"layers":[["1","g"]]}', '{"dataset":"d","curve":{"place":{"kind":"x"},"array":""},"layers":[]}'])
      expect(parsePlots(text), text).toBeNull();
  });

  test('an answer comes as the server says it', () => {
    const value = { inReplyTo: 5n, revision: 8n, array: 'f', at: [0, 1], value: [2, NaN], thinned: true, gridsDiffer: true, layers: [{ from: 0, to: 0.5, interval: 3 }] };
    const event = decodeEvent(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body: { case: 'probedCurve', value } })));
    expect(event).toEqual({
      kind: 'probedCurve',
      inReplyTo: 5,
      curve: { revision: 8, array: 'f', at: [0, 1], values: [2, NaN], thinned: true, gridsDiffer: true, layers: [{ from: 0, to: 0.5, interval: 3, term: null }] },
    });
  });
});

describe('the shape of a curve', () => {
  test('has its values between samples, none in gaps and beyond its ends', () => {
    const of = curve({ at: [1, 2, 2, 3, 4, 5], values: [0, 10, 20, 30, NaN, 50] });
    expect([0.5, 1, 1.5, 2.5, 3.5, 4.5, 5, 5.5].map((at) => valueAt(of, at))).toEqual([null, 0, 5, 25, null, null, 50, null]);
    expect(curveRange(of.values)).toEqual({ lower: 0, upper: 50 });
    expect(curveRange([NaN])).toBeNull();
    expect(curvePath(of.at, of.values, (x) => x, (y) => y)).toBe('M1.00 0.00L2.00 10.00L2.00 20.00L3.00 30.00M5.00 50.00h0.01');
    expect(nearestSample([0, 1, 5], 2.9)).toBe(1);
  });
  test('is saved with all digits, places along the line, and steps from 1', () => {
    expect(lineTable(curve({ array: 'p, "x"', at: [0, 1], values: [1 / 3, NaN] }), a, b)).toBe('distance,x,y,z,"p, ""x"""\r\n0,0,0,0,0.3333333333333333\r\n1,1,0,0,\r\n');
    const axes = [true, false, false].map((downward) => ({ name: '', unit: '', downward }));
    expect(lineTable(curve({ array: 'p', at: [0, 1], values: [1, 2] }), a, b, axes)).toBe('distance,x,y,z,p\r\n0,0,0,0,1\r\n1,-1,0,0,2\r\n');
    expect(stepsTable(curve({ at: [0, 1], values: [5, 6] }), [0, 0.5])).toBe('step,time,f\r\n1,0,5\r\n2,0.5,6\r\n');
  });
});
