import { describe, expect, test } from 'vitest';
import { emptyState, type SceneState } from '../src/lib/model';
import { SavedTab } from '../src/lib/saved';
import { Visits } from '../src/lib/visits';

const camera = { eye: [0, 0, 9], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 30 } as const;
const scene = (dataset: string, more: Partial<SceneState> = {}): SceneState => ({ ...emptyState, dataset, array: 'f', camera, ...more });
const tab = (store = new Map<string, string>()) => new SavedTab({ getItem: (key) => store.get(key) ?? null, setItem: (key, value) => void store.set(key, value) }, '/');

describe('a dataset that was left', () => {
  test('is as it was left, also after the page was loaded again, and others are not', () => {
    const store = new Map<string, string>();
    const visits = new Visits(tab(store));
    visits.arrived(scene('fin'));
    visits.left(scene('fin', { mode: 'cycled' }), true);
    for (const then of [visits, new Visits(tab(store))]) {
      expect(then.of('fin')).toMatchObject({ dataset: 'fin', mode: 'cycled' });
      expect(then.of('other')).toBe(null);
    }
  });

  test('is shown as at first where nothing was done, or all was undone', () => {
    const visits = new Visits(tab());
    visits.arrived(scene('fin'));
    visits.left(scene('fin', { mode: 'cycled' }), false); // by somebody else
    expect(visits.of('fin')).toBe(null);
    visits.left(scene('fin', { camera: { ...camera, fovDeg: 20 } }), false);
    expect(visits.of('fin')?.camera?.fovDeg).toBe(20);
    visits.left(scene('fin', { revision: 9 }), true);
    expect(visits.of('fin')).toBe(null);
  });

  test('is kept where nobody knows what it was like at first', () => {
    const visits = new Visits(tab());
    visits.arrived(null);
    visits.left(scene('fin'), false);
    expect(visits.of('fin')).not.toBe(null);
  });
});
