import { describe, expect, test } from 'vitest';
import { changesBetween, doesNothing, isNothing, isStream, joined, planOf, wordsOf, type Plan } from '../src/lib/changes';
import { emptyState, type Interval, type SceneState } from '../src/lib/model';
import { seeded } from './random';

const layer = (id: number, more: Partial<Interval> = {}): Interval => ({
  id, lower: id, upper: id + 1, color: [1, 0, 0], colorMap: '', opacity: 0.5, priority: id, visible: true, number: id, surface: null, transfer: null, opacityUpper: null, ...more,
});
const scene = (more: Partial<SceneState> = {}): SceneState => ({ ...emptyState, dataset: 'fin', array: 'Density', intervals: [layer(1), layer(2), layer(3)], ...more });
const with2 = (change: Partial<Interval>, of = scene()): SceneState => ({ ...of, intervals: of.intervals.map((l) => (l.id === 2 ? { ...l, ...change } : l)) });

/** As a server would; layers that come back keep their ids here. */
function done(state: SceneState, { scene: fields, patches, intervals, removed, order }: Plan): SceneState {
  const listed = (intervals ?? state.intervals).filter(({ id }) => !removed.includes(id));
  const changed = listed.map((l) => ({ ...l, ...patches.get(l.id), ...(order ? { priority: order.length - order.indexOf(l.id) } : {}) }));
  return { ...state, ...(fields as Partial<SceneState>), intervals: changed };
}

/** One edit by chance. */
function edited(state: SceneState, random: () => number): SceneState {
  const one = state.intervals[Math.floor(random() * state.intervals.length)];
  const patch = (change: Partial<Interval>) => ({ ...state, intervals: state.intervals.map((l) => (l === one ? { ...l, ...change } : l)) });
  switch (Math.floor(random() * 9)) {
    case 0: return patch({ lower: random(), upper: 1 + random() });
    case 1: return patch({ visible: !one?.visible });
    case 2: return patch({ color: [random(), 0, 0], colorMap: '' });
    case 3: return patch({ transfer: one?.transfer ? null : [{ value: 0, color: [1, 1, 1], opacity: 0 }, { value: random(), color: [0, 0, 0], opacity: 1 }] });
    case 4: return { ...state, intervals: state.intervals.filter((l) => l !== one) };
    case 5: return { ...state, intervals: [...state.intervals, layer(Math.floor(random() * 1e9) + 10)] };
    case 6: return { ...state, clipPlanes: random() < 0.5 ? [] : [{ normal: [1, 0, 0], offset: random() }] };
    case 7: return { ...state, array: random() < 0.5 ? 'Density' : 'Energy', mode: random() < 0.5 ? 'sorted' : 'prioritized', step: Math.floor(random() * 5) };
    default: return { ...state, intervals: state.intervals.map((l, i) => ({ ...l, priority: (i * 7 + Math.floor(random() * 5)) % 11 })) };
  }
}

describe('what a step has changed', () => {
  test('is brought back and done again, whatever it was', () => {
    for (let seed = 1; seed <= 500; seed++) {
      const random = seeded(seed);
      const states = [scene()];
      for (let i = 0; i < 8; i++) states.push(edited(states.at(-1) as SceneState, random));
      const steps = states.slice(1).map((after, i) => changesBetween(states[i] as SceneState, after));
      const same = (a: SceneState, b: SceneState) => expect(isNothing(changesBetween(a, b)), `seed ${seed}`).toBe(true);
      let now = states.at(-1) as SceneState;
      const listed = (state: SceneState) => state.intervals.map(({ id }) => id);
      for (let i = steps.length - 1; i >= 0; i--) {
        now = done(now, planOf(steps[i]!, now, 'before'));
        same(now, states[i] as SceneState);
        expect(listed(now), `seed ${seed}`).toEqual(listed(states[i] as SceneState));
      }
      for (const [i, step] of steps.entries()) {
        now = done(now, planOf(step, now, 'after'));
        same(now, states[i + 1] as SceneState);
      }
    }
  });

  test('stays where somebody else has changed it since', () => {
    const before = scene();
    const mine = with2({ opacity: 0.9, lower: 0 });
    const theirs = with2({ opacity: 0.2 }, mine);
    const plan = planOf(changesBetween(before, mine), theirs, 'before');
    expect(plan.kept).toEqual(['the opacity of Layer 2']);
    expect([...plan.patches]).toEqual([[2, { lower: 2 }]]);
  });

  test('a layer that somebody else has deleted is left alone, one that he has changed is not deleted', () => {
    const gone = { ...scene(), intervals: [layer(1), layer(3)] };
    expect(doesNothing(planOf(changesBetween(scene(), with2({ opacity: 1 })), gone, 'before'))).toBe(true);
    const plan = planOf(changesBetween(gone, scene()), with2({ opacity: 1 }), 'before');
    expect(plan.removed).toEqual([]);
    expect(plan.kept).toEqual(['Layer 2']);
  });

  test('colours that follow the array go on following it', () => {
    const plan = planOf(changesBetween(scene(), scene({ array: 'Energy' })), scene({ array: 'Energy' }), 'before');
    expect(plan.scene).toEqual({ array: 'Density' });
  });

  test('two of one slider are one step; there and back is none', () => {
    const [a, b, c] = [0.1, 0.2, 0.3].map((opacity) => with2({ opacity })) as [SceneState, SceneState, SceneState];
    const both = joined(changesBetween(a, b), changesBetween(b, c));
    expect(planOf(both, c, 'before').patches.get(2)).toEqual({ opacity: 0.1 });
    expect(isNothing(joined(changesBetween(a, b), changesBetween(b, a)))).toBe(true);
    expect(isStream(both)).toBe(true);
    expect(isStream(changesBetween(a, with2({ visible: false }, a)))).toBe(false);
    expect(isStream(changesBetween(a, { ...a, clipPlanes: [{ normal: [1, 0, 0], offset: 1 }] }))).toBe(false);
  });

  test('is said in words', () => {
    expect(wordsOf(changesBetween(scene(), with2({ upper: 9 })), scene())).toBe('the range of Layer 2');
    expect(wordsOf(changesBetween(scene(), scene({ intervals: [layer(1), layer(3)] })), scene())).toBe('deleting Layer 2');
    expect(wordsOf(changesBetween(scene({ intervals: [] }), scene({ intervals: [layer(1, { name: 'Skin' })] })), scene())).toBe('adding Skin');
    expect(wordsOf(changesBetween(scene(), scene({ mode: 'cycled' })), scene())).toBe('the mode');
  });
});
