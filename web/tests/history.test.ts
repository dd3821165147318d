import { describe, expect, test } from 'vitest';
import { changesBetween, type Plan } from '../src/lib/changes';
import { History } from '../src/lib/history.svelte';
import { seeded } from './random';
import { emptyState, type Interval, type SceneState } from '../src/lib/model';

const layer = (id: number, more: Partial<Interval> = {}): Interval => ({ id, lower: 0, upper: 1, color: [1, 0, 0], colorMap: '', opacity: 0.5, priority: id, visible: true, number: id, ...more });
const turn = () => Promise.resolve();

/** A page whose server does at once what it is told, but says so only when it is let. */
function harness(...intervals: Interval[]) {
  const clock = { now: 0 };
  const hand = { grip: 0 };
  let view: SceneState = { ...emptyState, dataset: 'fin', array: 'Density', intervals };
  const plans: Plan[] = [];
  const said: string[] = [];
  const history = new History({
    scene: () => ({ view, server: view }),
    grip: () => hand.grip,
    now: () => clock.now,
    bring: (plan) => {
      plans.push(plan);
      view = { ...view, ...(plan.scene as Partial<SceneState>), intervals: view.intervals.filter(({ id }) => !plan.removed.includes(id)).map((l) => ({ ...l, ...plan.patches.get(l.id) })) };
      return 7;
    },
    say: (text) => said.push(text),
    name: (dataset) => dataset,
    leave: () => view,
    visit: (state) => visited.push(state),
  });
  const visited: SceneState[] = [];
  let fresh = 100;
  /** What the server says when another dataset is open: its first view, whose layers have the ids of those before. */
  const turned = (dataset: string) => {
    history.turned(dataset);
    view = { ...emptyState, dataset, array: 'Density', intervals: [layer(1), layer(2)] };
  };
  const open = (dataset: string) => {
    history.opens(dataset);
    turned(dataset);
    history.told(1);
  };
  /** The dataset that is visited opens, and what it showed comes back with layers of new ids. */
  const arrive = () => {
    const state = visited.pop()!;
    turned(state.dataset);
    history.arrived(9, state);
    view = { ...state, intervals: state.intervals.map((l) => ({ ...l, id: ++fresh })) };
    history.told(9);
  };
  const set = (change: Partial<SceneState>) => (view = { ...view, ...change });
  const patch = (id: number, change: Partial<Interval>) => set({ intervals: view.intervals.map((l) => (l.id === id ? { ...l, ...change } : l)) });
  const opacity = async (value: number, kind = 'layer 1 opacity') => {
    history.note(kind, () => patch(1, { opacity: value }));
    await turn();
  };
  return { history, clock, hand, plans, said, set, patch, opacity, view: () => view, visited, turned, open, arrive };
}

describe('what the person has done', () => {
  test('is undone by a page that was loaded again in the same session', async () => {
    const before = harness(layer(1), layer(2));
    await before.opacity(0.7);
    await before.opacity(0.8, 'another');
    before.history.undo();
    const after = harness(...before.view().intervals);
    after.history.restore(before.history.text());
    expect([after.history.undoes, after.history.redoes]).toEqual(['the opacity of Layer 1', 'the opacity of Layer 1']);
    after.history.redo();
    expect(after.view().intervals[0]?.opacity).toBe(0.8);
    after.history.undo();
    after.history.undo();
    expect(after.view().intervals[0]?.opacity).toBe(0.5);
    await after.opacity(0.9);
    after.history.restore(before.history.text()); // it has steps of its own
    after.history.undo();
    expect(after.view().intervals[0]?.opacity).toBe(0.5);
    expect(after.history.undoes).toBeNull();
  });

  test('goes over a change of dataset: all that was done in any order is undone and redone', async () => {
    const without = (state: SceneState) => ({ ...state, intervals: state.intervals.map((l) => ({ ...l, id: l.number })) });
    for (let seed = 1; seed <= 60; seed++) {
      const r = seeded(seed);
      const { history, patch, open, arrive, visited, view } = harness(layer(1), layer(2));
      const states = [without(view())];
      for (let i = 0; i < 12; i++) {
        if (r() < 0.4) open(['fin', 'jet', 'cube'].filter((name) => name !== view().dataset)[Math.floor(r() * 2)]!);
        else {
          const { id, opacity } = view().intervals[Math.floor(r() * 2)]!;
          history.note(`${i}`, () => patch(id, { opacity: opacity + r() }));
          await turn();
        }
        states.push(without(view()));
      }
      const go = (one: () => void) => {
        one();
        if (visited.length > 0) arrive();
      };
      for (let round = 0; round < 2; round++) {
        for (let i = states.length - 2; i >= 0; i--) {
          go(() => history.undo());
          expect(without(view()), `seed ${seed}, undo ${i}`).toEqual(states[i]);
        }
        expect(history.undoes, `seed ${seed}`).toBeNull();
        for (let i = 1; i < states.length; i++) {
          go(() => history.redo());
          expect(without(view()), `seed ${seed}, redo ${i}`).toEqual(states[i]);
        }
        expect(history.redoes, `seed ${seed}`).toBeNull();
      }
    }
  });

  test('waits while a dataset is on its way back, stays where that fails, and ends where somebody else opens one', async () => {
    const { history, opacity, open, arrive, visited, turned, view } = harness(layer(1), layer(2));
    await opacity(0.7);
    open('jet');
    expect([history.undoes, history.touched]).toEqual(['opening jet', false]);
    history.undo();
    history.undo(); // of what will be there
    expect(visited.map(({ dataset }) => dataset)).toEqual(['fin']);
    arrive();
    expect([view().dataset, view().intervals[0]?.opacity, history.undoes]).toEqual(['fin', 0.5, null]);
    history.redo();
    expect(view().intervals[0]?.opacity).toBe(0.7);
    history.redo();
    history.redo();
    history.stayed(); // the file is gone
    expect([visited.length, history.redoes]).toEqual([2, 'opening jet']); // it is tried again
    history.stayed();
    expect([view().dataset, history.undoes]).toEqual(['fin', 'the opacity of Layer 1']);

    const text = history.text();
    const again = harness(layer(1), layer(2));
    again.history.restore(text);
    expect(again.history.redoes).toBe('opening jet');
    turned('cube');
    expect([history.undoes, history.redoes]).toEqual([null, null]);
  });

  test('a drag is one step, however long it rests; two drags are two', async () => {
    const { history, hand, clock, opacity, view } = harness(layer(1));
    for (hand.grip = 1; hand.grip <= 2; hand.grip++)
      for (let i = 1; i <= 5; i++) {
        clock.now += 5000;
        await opacity(hand.grip / 10 + i / 100);
      }
    hand.grip = 0;
    history.undo();
    expect(view().intervals[0]?.opacity).toBeCloseTo(0.15);
    history.undo();
    expect(view().intervals[0]?.opacity).toBe(0.5);
    expect(history.undoes).toBe(null);
    history.redo();
    const spoken = history.spoken;
    expect(spoken).toBe('Redone: the opacity of Layer 1.');
    history.redo();
    expect(history.spoken).not.toBe(spoken); // or nobody would hear the second
    expect(view().intervals[0]?.opacity).toBeCloseTo(0.25);
    expect(history.redoes).toBe(null);
  });

  test('keys on a slider are one step until they pause, switches are one step each, one event is one step', async () => {
    const { history, clock, opacity, patch, set, view } = harness(layer(1));
    await opacity(0.1);
    clock.now = 500;
    await opacity(0.2);
    clock.now = 1500;
    await opacity(0.3);
    for (const visible of [false, true, false]) {
      history.note('layer 1 visible', () => patch(1, { visible }));
      await turn();
    }
    history.note('mode', () => set({ mode: 'cycled' }));
    history.note('background', () => set({ background: [1, 1, 1] }));
    await turn();
    history.undo();
    expect(view().mode).toBe('sorted');
    expect(view().background).toEqual(emptyState.background);
    const seen: unknown[] = [];
    while (history.undoes) {
      history.undo();
      seen.push([view().intervals[0]?.visible, view().intervals[0]?.opacity]);
    }
    expect(seen).toEqual([[true, 0.3], [false, 0.3], [true, 0.3], [true, 0.2], [true, 0.5]]);
  });

  test('a series that plays is one step', async () => {
    const { history, set, view, clock } = harness();
    for (let step = 1; step < 9; step++) {
      clock.now += 3000;
      history.note('play', () => set({ step }));
      await turn();
    }
    history.undo();
    expect(view().step).toBe(0);
  });

  test('something new ends what could be redone, and nothing joins what was undone', async () => {
    const { history, opacity, view } = harness(layer(1));
    await opacity(0.1);
    history.undo();
    await opacity(0.2);
    expect(history.redoes).toBe(null);
    history.undo();
    expect(view().intervals[0]?.opacity).toBe(0.5);
  });

  test('says what somebody else has changed since, and leaves it', async () => {
    const { history, opacity, patch, said, view } = harness(layer(1));
    await opacity(0.1);
    patch(1, { opacity: 0.9 });
    history.undo();
    expect(view().intervals[0]?.opacity).toBe(0.9);
    expect(said).toEqual(['Not undone, because it has been changed elsewhere since: the opacity of Layer 1.']);
  });

  test('what was refused is passed over', async () => {
    const { history, opacity, patch, view } = harness(layer(1));
    await opacity(0.1);
    await opacity(0.2, 'another');
    patch(1, { opacity: 0.1 }); // as the server says
    history.undo();
    expect(view().intervals[0]?.opacity).toBe(0.5);
  });

  test('what is done before the server has answered waits for the answer', () => {
    const { history, set, view, plans } = harness(layer(1));
    history.note('add', () => 5, true);
    history.undo();
    expect(plans).toHaveLength(0);
    history.told(4);
    expect(plans).toHaveLength(0);
    set({ intervals: [layer(1), layer(2)] });
    history.told(5);
    expect(plans).toHaveLength(1);
    expect(view().intervals).toHaveLength(1);
  });

  test('a layer that was brought back is the same one for what was done before', async () => {
    const { history, opacity, set, view, plans } = harness(layer(1), layer(2));
    await opacity(0.1);
    history.note('remove', () => set({ intervals: [layer(2)] }));
    history.undo();
    expect(plans[0]?.intervals?.map(({ id }) => id)).toEqual([1, 2]);
    history.undo(); // of the opacity, at once: waits until the layer has come
    expect(plans).toHaveLength(1);
    set({ intervals: [layer(31, { number: 1, opacity: 0.1 }), layer(2)] });
    history.told(7);
    expect(view().intervals[0]).toMatchObject({ id: 31, opacity: 0.5 });
    history.redo();
    history.redo();
    expect(view().intervals.map(({ id }) => id)).toEqual([2]);
  });

  test('after a loss the next State answers; another dataset begins anew', () => {
    const { history, set } = harness(layer(1));
    history.note('add', () => 500, true);
    history.lost();
    set({ intervals: [layer(1), layer(2)] });
    history.told(1);
    expect(history.undoes).toBe('adding Layer 2');
    history.clear();
    expect(history.undoes).toBe(null);
    expect(changesBetween({ ...emptyState }, emptyState).layers.size).toBe(0);
  });
});
