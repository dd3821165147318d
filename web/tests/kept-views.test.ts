import { describe, expect, test } from 'vitest';
import { KeptViews, mostKept } from '../src/lib/kept-views';
import type { Camera } from '../src/lib/model';

const camera: Camera = { eye: [1, 2, 3], at: [0, 0, 0.1], up: [0, 0, 1], fovDeg: 25, orthographic: true };
class Store {
  readonly texts = new Map<string, string>();
  getItem = (key: string) => this.texts.get(key) ?? null;
  setItem = (key: string, text: string) => void this.texts.set(key, text);
}

describe('views that are kept', () => {
  test('are there again for the same page and dataset, to the last digit, and for no other', () => {
    const store = new Store();
    new KeptViews(() => store, '/a/', 'fin').keep('  the tip ', camera, [1, 1, 50]);
    expect(new KeptViews(() => store, '/a/', 'fin').list).toEqual([{ name: 'the tip', camera, axisScale: [1, 1, 50] }]);
    expect(new KeptViews(() => store, '/a/', 'fins').list).toEqual([]);
    expect(new KeptViews(() => store, '/b/', 'fin').list).toEqual([]);
  });

  test('have names that differ: the next number, or the one that takes the place of the view before', () => {
    const kept = new KeptViews((store => () => store)(new Store()), '/', 'fin');
    kept.keep('', camera);
    kept.keep('View 2', camera);
    kept.keep('', camera);
    expect(kept.keep('View 1', { ...camera, fovDeg: 40 }).map(({ name, camera }) => [name, camera.fovDeg])).toEqual([['View 1', 40], ['View 2', 25], ['View 3', 25]]);
    expect(kept.remove('View 2').map(({ name }) => name)).toEqual(['View 1', 'View 3']);
    expect(kept.keep('', camera).map(({ name }) => name)).toEqual(['View 1', 'View 3', 'View 4']);
  });

  test('are read as if anybody had written them', () => {
    const store = new Store();
    const kept = new KeptViews(() => store, '/', 'fin');
    const good = { name: 'good', camera, axisScale: [1, 1, 1] };
    for (const bad of [null, 7, {}, { ...good, name: 3 }, { ...good, camera: null }, { ...good, camera: { ...camera, eye: [1, 2] } }, { ...good, axisScale: ['1', 1, 1] }]) {
      store.setItem('isostrata./.views.fin', JSON.stringify([bad, good]));
      expect(kept.list).toEqual([good]);
    }
    for (const text of ['', '{', '{"list":1}', 'null']) {
      store.setItem('isostrata./.views.fin', text);
      expect(kept.list).toEqual([]);
    }
    store.setItem('isostrata./.views.fin', JSON.stringify(Array.from({ length: 60 }, () => good)));
    expect(kept.list.length).toBe(mostKept);
  });

  test('live as long as the page shows them if nothing may be stored', () => {
    const kept = new KeptViews(
      () => {
        throw new Error('forbidden');
      },
      '/',
      'fin',
    );
    expect(kept.list).toEqual([]);
    expect(kept.keep('', camera).length).toBe(1);
  });
});
