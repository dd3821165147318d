// What can be undone goes through a text and comes back the same, as much of it as there is room for.
import { describe, expect, test } from 'vitest';
import { changesBetween, planOf } from '../src/lib/changes';
import { emptyState, type Interval, type SceneState } from '../src/lib/model';
import { parseSteps, stepsText } from '../src/lib/saved-steps';

const layer = (id: number, more: Partial<Interval> = {}): Interval => ({ id, lower: 0, upper: 1, color: [1, 0, 0], colorMap: '', opacity: 0.5, priority: id, visible: true, number: id, ...more });
const state = (...intervals: Interval[]): SceneState => ({ ...emptyState, dataset: 'd', array: 'f', intervals });
const step = (before: SceneState, after: SceneState) => ({ changes: changesBetween(before, after), kind: 'k' });

describe('steps as a text', () => {
  test('do the same as before', () => {
    const before = state(layer(1), layer(2));
    const after = { ...state(layer(1, { lower: -Infinity, name: 'shell' }), layer(3)), step: 4 };
    const one = step(before, after);
    const saved = parseSteps(stepsText({ undo: [one], redo: [step(after, before)] }));
    expect(saved).toEqual({ undo: [one], redo: [step(after, before)] });
    expect(planOf((saved!.undo[0] as typeof one).changes, after, 'before')).toEqual(planOf(one.changes, after, 'before'));
  });
  test('to another dataset have what was shown of the one before', () => {
    const before = state(layer(1, { upper: Infinity }));
    const one = { ...step(before, before), turn: { before, after: null, to: 'e' } };
    expect(parseSteps(stepsText({ undo: [one], redo: [{ ...one, turn: { ...one.turn, after: before } }] }))?.undo).toEqual([one]);
    expect(parseSteps(stepsText({ undo: [{ ...one, turn: { ...one.turn, before: { dataset: 'd' } } }], redo: [] }))).toBeNull();
  });
  test('that are too many leave out the oldest, and of those undone the farthest', () => {
    const long = 'x'.repeat(2000);
    const steps = Array.from({ length: 200 }, (_, i) => step(state(layer(1)), state(layer(1, { name: `${i} ${long}` }))));
    const saved = parseSteps(stepsText({ undo: steps, redo: [] }))!;
    expect(saved.undo.length).toBeGreaterThan(20);
    expect(saved.undo.length).toBeLessThan(200);
    expect(saved.undo.at(-1)).toEqual(steps.at(-1));
    expect(parseSteps(stepsText({ undo: [], redo: steps }))!.redo.at(-1)).toEqual(steps.at(-1));
    expect(stepsText({ undo: [], redo: [] })).toBe('');
  });
  test('that are none are none', () => {
    for (const text of [null, '', '{', '[]', '{"undo":[{}],"redo":[]}', '{"undo":[{"changes":{"scene":1}}],"redo":[]}']) expect(parseSteps(text)).toBeNull();
  });
});
