import { describe, expect, test } from 'vitest';
import { emptyState, type SceneState } from '../src/lib/model';
import type { DatasetInfo } from '../src/lib/told';
import { Recovery } from '../src/lib/recovery';
import { SavedTab } from '../src/lib/saved';
import { TickedClock } from './ticked';

const scene = (revision: number, more: Partial<SceneState> = {}): SceneState => ({ ...emptyState, revision, dataset: 'fin', array: 'Density', ...more });
const info = { id: 'fin', arrays: [{ name: 'Density' }], times: [0] } as unknown as DatasetInfo;

function harness(store = new Map<string, string>(), calm = false) {
  const clock = new TickedClock();
  const saved = new SavedTab({ getItem: (key) => store.get(key) ?? null, setItem: (key, value) => void store.set(key, value) }, '/');
  return { clock, saved, store, recovery: new Recovery({ saved, calm: () => calm, after: clock.after }) };
}
const here = (session: string) => ({ session, resumeToken: `token of ${session}` });

describe('a page after a loss or a reload', () => {
  test('knows its session again, over a reload too', () => {
    const first = harness();
    expect(first.recovery.welcomed(here('s'), null)).toBe(false);
    expect(first.recovery.welcomed(here('s'), scene(1))).toBe(true);
    const reloaded = harness(first.store).recovery;
    expect(reloaded.resumeToken).toBe('token of s');
    expect(reloaded.welcomed(here('s'), null)).toBe(true);
    expect(reloaded.active).toBe(false);
    expect(reloaded.welcomed(here('other'), null)).toBe(false);
  });

  test('brings what it showed into another session: the dataset first, the rest when that is described', () => {
    const { recovery } = harness();
    recovery.welcomed(here('s'), null);
    recovery.welcomed(here('other'), scene(7, { step: 0 }));
    const sends = (server: SceneState, of: DatasetInfo | null) => {
      const step = recovery.next(server, of, [{ id: 'fin' } as never], 1);
      return step.kind === 'send' ? step.commands.map((body) => body.case) : step.kind;
    };
    expect(sends(emptyState, null)).toEqual(['openDataset']);
    expect(sends(emptyState, null)).toBe('wait');
    expect(recovery.active).toBe(true);
    expect(sends(scene(1), info)).toContain('setIntervals');
    expect(recovery.active).toBe(false);
    expect(sends(scene(2), info)).toBe('wait'); // once
  });

  test('says why it cannot, but of what it only remembers it is silent', () => {
    const gone = (welcomes: number) => {
      const { recovery, saved } = harness();
      saved.state = scene(1);
      for (let i = 1; i < welcomes; i++) recovery.welcomed(here(`s${i}`), null);
      recovery.welcomed(here('last'), scene(1));
      const step = recovery.next(emptyState, null, [], 0);
      expect(recovery.active).toBe(false);
      return step.kind === 'impossible' ? step.reason : step.kind;
    };
    expect(gone(2)).toContain('no longer has the dataset');
    expect(gone(1)).toBe('');
  });

  test('a guest brings nothing', () => {
    const { recovery, saved } = harness();
    saved.state = scene(1);
    expect(recovery.welcomed({ session: 's', resumeToken: '' }, null)).toBe(false);
    expect(recovery.active).toBe(false);
  });

  test('nothing comes back playing for whom motion is too much', () => {
    for (const calm of [true, false]) {
      const { recovery, saved } = harness(new Map(), calm);
      saved.state = scene(1, { mode: 'cycled', cycle: { seconds: 1, phase: 0, playing: true } });
      recovery.welcomed(here('s'), null);
      const step = recovery.next(scene(1), info, [], 1);
      const cycle = step.kind === 'send' ? step.commands.find((body) => body.case === 'setCycle') : undefined;
      expect(cycle?.value).toMatchObject({ playing: !calm });
    }
  });
});

describe('the scene is written down', () => {
  test('at most every 300 ms, the newest one, and not while it is still being brought back', () => {
    const { recovery, saved, clock } = harness();
    recovery.welcomed(here('s'), null);
    for (let revision = 1; revision <= 60; revision++) {
      recovery.keep(scene(revision), () => 'steps');
      clock.advance(10);
    }
    expect(saved.state?.revision).toBe(60); // that of 300 ms, and that of 600
    recovery.keep(scene(61), () => 'steps');
    recovery.welcomed(here('other'), scene(61));
    recovery.keep(scene(1), () => 'steps');
    clock.advance(1000);
    expect(saved.state?.revision).toBe(60);
  });

  test('never one without a dataset', () => {
    const { recovery, saved, clock } = harness();
    recovery.keep(emptyState, () => 'steps');
    clock.advance(300);
    expect(saved.state).toBeNull();
  });
});
