import { describe, expect, test } from 'vitest';
import { emptyState, type SceneState } from '../src/lib/model';
import type { DatasetInfo } from '../src/lib/told';
import { parseSavedState, restoreStep } from '../src/lib/restore';
import { SavedTab } from '../src/lib/saved';
import { socketUrl, takeToken } from '../src/lib/token';

const saved: SceneState = {
  ...emptyState,
  dataset: 'fin',
  array: 'Density',
  colorBy: 'Momentum',
  step: 2,
  intervals: [{ id: 41, lower: 1, upper: 2, color: [1, 0, 0], colorMap: '', opacity: 0.4, priority: 3, visible: true }],
  mode: 'prioritized',
  camera: { eye: [0, 0, 9], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 30 },
};
const info = (id: string, ...names: string[]): DatasetInfo => ({
  id,
  name: id,
  grid: 'uniform',
  points: 8,
  cells: 1,
  cellTypes: [],
  bounds: null,
  arrays: names.map((name) => ({ name, association: 'point', type: 'float32', components: 1, unit: '', lower: 0, upper: 1, nanCount: 0, steps: [] })),
  times: [0, 1, 2],
  missingRangeSteps: 0,
  nothingToShow: '',
  notes: [],
});
const datasets = [{ id: 'fin', name: 'fin.bin' }];

describe('after the server was restarted', () => {
  test('the dataset is opened first, then waited for, then all the rest is sent at once', () => {
    const first = restoreStep(saved, emptyState, null, datasets, false);
    expect(first.kind === 'send' && first.commands.map((c) => c.case)).toEqual(['openDataset']);
    expect(restoreStep(saved, emptyState, null, datasets, true).kind).toBe('wait');
    const opened = { ...emptyState, dataset: 'fin', array: 'Density' };
    expect(restoreStep(saved, opened, null, datasets, true).kind).toBe('wait');
    const last = restoreStep(saved, opened, info('fin', 'Density', 'Momentum'), datasets, true);
    if (last.kind !== 'send') throw new Error(last.kind);
    expect(last.done).toBe(true);
    expect(last.commands.map((c) => c.case)).toEqual(['selectArrays', 'setTimeStep', 'setIntervals', 'setAppearance', 'setCamera']);
  });

  test('the light stays on', () => {
    const step = restoreStep({ ...saved, occlusion: 0.5, depthFade: 0.25, bodyShading: 0.75, axisScale: [1, 1, 50] }, { ...emptyState, dataset: 'fin' }, info('fin', 'Density'), datasets, false);
    const look = step.kind === 'send' && step.commands.find((c) => c.case === 'setAppearance');
    expect(look && look.value).toMatchObject({ occlusion: 0.5, depthFade: 0.25, bodyShading: 0.75, axisScale: { x: 1, y: 1, z: 50 } });
  });

  test('values stay whole, and a part is there as long as what it is of', () => {
    const whole = { ...saved, dataset: 'fin@:9,:,:*2', values: 'whole' as const };
    const first = restoreStep(whole, emptyState, null, datasets, false);
    expect(first.kind === 'send' && first.commands.map((c) => c.value)).toEqual([{ id: 'fin@:9,:,:*2' }]);
    const step = restoreStep(whole, { ...emptyState, dataset: whole.dataset }, info(whole.dataset, 'Density'), datasets, false);
    const arrays = step.kind === 'send' && step.commands.find((c) => c.case === 'selectArrays');
    expect(arrays && arrays.value).toMatchObject({ array: 'Density', values: 2 });
  });

  test('intervals are sent as new ones: the old ids mean nothing now', () => {
    const step = restoreStep(saved, { ...emptyState, dataset: 'fin' }, info('fin', 'Density'), datasets, false);
    if (step.kind !== 'send') throw new Error(step.kind);
    const intervals = step.commands.find((c) => c.case === 'setIntervals');
    expect(intervals?.case === 'setIntervals' && intervals.value.intervals?.map((i) => [i.id, i.lower, i.priority])).toEqual([[0, 1, 3]]);
  });

  test('what is no longer there is said', () => {
    const gone = restoreStep(saved, emptyState, null, [{ id: 'other', name: 'other' }], false);
    expect(gone).toMatchObject({ kind: 'impossible' });
    // Of a list of which these are the first, it may be among the others.
    expect(restoreStep(saved, emptyState, null, [{ id: 'other', name: 'other' }], false, 2)).toMatchObject({ kind: 'send' });
    const changed = restoreStep(saved, { ...emptyState, dataset: 'fin' }, info('fin', 'Pressure'), datasets, false);
    expect(changed.kind === 'impossible' && changed.reason).toContain('Density');
  });

  test('a session with nothing open needs nothing', () => {
    expect(restoreStep(emptyState, emptyState, null, [], false)).toEqual({ kind: 'send', commands: [], done: true });
  });
});

describe('what a tab remembers', () => {
  const memory = () => {
    const map = new Map<string, string>();
    return { getItem: (key: string) => map.get(key) ?? null, setItem: (key: string, value: string) => void map.set(key, value), map };
  };

  test('survives a reload, separately for each place the page is mounted at', () => {
    const store = memory();
    const tab = new SavedTab(store, '/a/');
    tab.session = { id: 'one', resumeToken: 'r1' };
    tab.state = saved;
    const again = new SavedTab(store, '/a/');
    expect(again.session).toEqual({ id: 'one', resumeToken: 'r1' });
    expect(again.state).toEqual(saved);
    expect(new SavedTab(store, '/b/').state).toBeNull();
  });

  test('is not trusted', () => {
    for (const text of [null, '', '{', 'null', '7', '{"dataset":3}', JSON.stringify({ ...saved, intervals: [{ lower: 2, upper: 1, opacity: 1 }] })])
      expect(parseSavedState(text), String(text)).toBeNull();
    expect(parseSavedState(JSON.stringify(saved))).toEqual(saved);
  });

  test('is nothing where storage is forbidden', () => {
    const forbidden = {
      getItem: () => {
        throw new Error('denied');
      },
      setItem: () => {
        throw new Error('denied');
      },
    };
    const tab = new SavedTab(forbidden, '/');
    tab.session = { id: 'x', resumeToken: 'y' };
    expect(tab.session).toEqual({ id: '', resumeToken: '' });
    expect(takeToken({ location: { href: 'http://h/?token=t' }, storage: forbidden, replaceUrl: () => {} })).toBe('t');
    expect(takeToken({ location: { href: 'http://h/' }, storage: forbidden, replaceUrl: () => {} })).toBe('');
  });

  test('the token leaves the address bar and nothing else does', () => {
    const store = memory();
    const urls: string[] = [];
    const take = (href: string) => takeToken({ location: { href }, storage: store, replaceUrl: (url) => urls.push(url) });
    expect(take('http://h:1/base/?token=s%2Fe&x=1#here')).toBe('s/e');
    expect(urls).toEqual(['http://h:1/base/?x=1#here']);
    expect(take('http://h:1/base/?x=1')).toBe('s/e');
    expect(urls).toHaveLength(1);
  });

  test('the socket stands beside the page, with its security', () => {
    expect(socketUrl('http://localhost:8080/', '')).toBe('ws://localhost:8080/ws');
    expect(socketUrl('https://hub.example/user/me/proxy/9/index.html?x=1#y', 'a b')).toBe('wss://hub.example/user/me/proxy/9/ws?token=a%20b');
  });
});
