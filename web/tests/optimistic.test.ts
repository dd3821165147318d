import { expect, test } from 'vitest';
import { emptyState, type Interval, type SceneState } from '../src/lib/model';
import { OptimisticState } from '../src/lib/optimistic';

const interval = (id: number, lower = 0, upper = 1): Interval => ({
  id,
  lower,
  upper,
  color: [1, 0, 0],
  colorMap: '',
  opacity: 0.5,
  priority: id,
  visible: true,
});
const state = (...intervals: Interval[]): SceneState => ({ ...emptyState, dataset: 'd', array: 'a', intervals });

test('what the person drags is seen at once and not pulled back by older answers', () => {
  const local = new OptimisticState();
  local.patch(1, { lower: 0.2 }, 0);
  local.patch(1, { lower: 0.4 }, 16);
  const older = state(interval(1, 0.2));
  local.settle(older, 20);
  expect(local.view(older).intervals[0]?.lower).toBe(0.4);
});

test('once the server has caught up, its word counts again', () => {
  const local = new OptimisticState();
  local.patch(1, { lower: 0.4 }, 0);
  local.settle(state(interval(1, 0.4)), 20);
  expect(local.view(state(interval(1, 0.7))).intervals[0]?.lower).toBe(0.7);
});

test('a refusal puts back what the server says', () => {
  const local = new OptimisticState();
  local.patch(1, { lower: 5 }, 0);
  local.patch(2, { lower: 6 }, 0);
  local.refuse(1);
  const view = local.view(state(interval(1), interval(2)));
  expect(view.intervals.map((i) => i.lower)).toEqual([0, 6]);
  local.set({ mode: 'prioritized' }, 0);
  local.refuse();
  expect(local.view(state()).mode).toBe('sorted');
});

test('a server that stays of another mind wins in the end', () => {
  const local = new OptimisticState(2000);
  local.patch(1, { opacity: 0.9 }, 0);
  local.set({ background: [1, 1, 1] }, 0);
  local.settle(state(interval(1)), 1000);
  expect(local.view(state(interval(1))).intervals[0]?.opacity).toBe(0.9);
  local.settle(state(interval(1)), 2001);
  expect(local.view(state(interval(1))).intervals[0]?.opacity).toBe(0.5);
  expect(local.view(state()).background).toEqual(emptyState.background);
});

test('colours that come back as 32-bit floats count as the same', () => {
  const local = new OptimisticState();
  local.patch(1, { color: [0.1, 0.2, 0.3] }, 0);
  const answer = state({ ...interval(1), color: [Math.fround(0.1), Math.fround(0.2), Math.fround(0.3)] });
  local.settle(answer, 1);
  expect(local.view({ ...answer, intervals: [{ ...interval(1), color: [0, 1, 0] }] }).intervals[0]?.color).toEqual([0, 1, 0]);
});

test('a removed interval is gone at once and stays gone', () => {
  const local = new OptimisticState();
  local.remove(1, 0);
  const before = state(interval(1), interval(2));
  local.settle(before, 5);
  expect(local.view(before).intervals.map((i) => i.id)).toEqual([2]);
  local.settle(state(interval(2)), 10);
  expect(local.view(state(interval(2))).intervals.map((i) => i.id)).toEqual([2]);
});

test('a new order is seen at once, until the priorities say the same', () => {
  const local = new OptimisticState();
  local.reorder([1, 2], 0);
  const before = state(interval(1), interval(2));
  local.settle(before, 1);
  const seen = local.view(before).intervals;
  expect((seen[0]?.priority ?? 0) > (seen[1]?.priority ?? 0)).toBe(true);
  local.settle(state({ ...interval(1), priority: 1 }, { ...interval(2), priority: 0 }), 2);
  expect(local.view(before).intervals.map((i) => i.priority)).toEqual([1, 2]);
});

test('edits to an interval that is gone are forgotten', () => {
  const local = new OptimisticState();
  local.patch(3, { lower: 0.5 }, 0);
  local.settle(state(interval(1)), 1);
  expect(local.view(state(interval(3))).intervals[0]?.lower).toBe(0);
});
