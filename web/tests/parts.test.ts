// The smaller parts of the store, each by itself.
import { describe, expect, test } from 'vitest';
import type { Command } from '../src/lib/commands';
import { FileList } from '../src/lib/file-list.svelte';
import { begun, continued } from '../src/lib/frame-view.svelte';
import { Hand } from '../src/lib/hand.svelte';
import type { SceneState } from '../src/lib/model';
import type { DatasetEntry, DatasetInfo, Frame, Participant, Purpose } from '../src/lib/told';
import { emptyState } from '../src/lib/model';
import { OpenDataset } from '../src/lib/open-dataset.svelte';
import { People } from '../src/lib/people.svelte';
import { SceneView } from '../src/lib/scene-view.svelte';
import { Selection } from '../src/lib/selection.svelte';
import { Stills } from '../src/lib/stills';
import { Work } from '../src/lib/work.svelte';
import { seeded } from './random';
import { TickedClock } from './ticked';

function line() {
  const sent: Command[] = [];
  return { sent, send: (body: Command) => sent.push(body), cases: () => sent.map((body) => body.case) };
}

describe('a hand', () => {
  test('is told down and up in turns, whatever begins and ends how often', () => {
    for (let seed = 1; seed <= 100; seed++) {
      const random = seeded(seed);
      const told: boolean[] = [];
      const hand = new Hand({
        send: (body) => told.push(body.case === 'interaction' && body.value.active === true),
        slots: { flush() {} } as never,
      });
      let held = 0;
      for (let i = 0; i < 30; i++) {
        if (random() < 0.5) {
          hand.begin();
          held += 1;
        } else {
          hand.end();
          held = Math.max(0, held - 1);
        }
        expect(hand.holds, `seed ${seed}`).toBe(held > 0);
      }
      expect(told, `seed ${seed}`).toEqual(told.map((_, i) => i % 2 === 0));
      expect(told.length % 2 === 1, `seed ${seed}`).toBe(hand.holds);
    }
  });

  test('sends what waits before it is told up, and tells a new connection that it is down', () => {
    const order: string[] = [];
    const hand = new Hand({ send: (body) => order.push(JSON.stringify(body.value)), slots: { flush: () => order.push('flush') } as never });
    hand.goesOn();
    hand.begin();
    hand.goesOn();
    hand.end();
    expect(order).toEqual(['{"active":true}', '{"active":true}', 'flush', '{"active":false}']);
    hand.begin();
    hand.empty();
    hand.end();
    expect(order).toHaveLength(5);
  });
});

describe('what can be opened', () => {
  const entry = (id: string, more: Partial<DatasetEntry> = {}) => ({ id, name: id, news: 'none', writing: false, ...more }) as DatasetEntry;

  test('a swarm of news is answered by one question, and by none when nobody looks', () => {
    const clock = new TickedClock();
    const { sent, send } = line();
    const files = new FileList({ send, after: clock.after });
    files.browse({ folder: 'run', search: '', first: 100 });
    for (let i = 0; i < 50; i++) files.changed([entry(`run/${i}`)]);
    clock.advance(99);
    expect(sent).toHaveLength(1);
    clock.advance(1);
    expect(sent).toHaveLength(2);
    expect(sent[1]).toEqual(sent[0]);
    files.changed([entry('late')]);
    files.browse(null);
    clock.advance(1000);
    expect(sent).toHaveLength(2);
  });

  test('news replace what was told, and what is new comes last', () => {
    const files = new FileList({ send() {}, after() {} });
    files.welcomed([entry('a'), entry('b')]);
    files.changed([entry('c'), entry('a', { news: 'gone' })]);
    expect(files.datasets.map(({ id, news }) => `${id} ${news}`)).toEqual(['a gone', 'b none', 'c none']);
    expect(files.whole[0]?.id).toBe('b');
    files.changed([entry('b', { writing: true })]);
    expect(files.whole[0]?.id).toBe('c');
  });

  test('a list that comes when nobody looks any more is not shown', () => {
    const files = new FileList({ send() {}, after() {} });
    files.told({ folder: 'run' } as never);
    expect(files.listing).toBeNull();
  });
});

describe('the open dataset', () => {
  const info = (times: number, upper = 1, onDisk?: DatasetInfo['onDisk']) =>
    ({ id: 'fin', arrays: [{ name: 'Density', lower: 0, upper }], times: Array.from({ length: times }, (_, i) => i), onDisk }) as unknown as DatasetInfo;
  const shown: SceneState = { ...emptyState, dataset: 'fin', array: 'Density' };

  test('asks for each histogram once, and again only when it would be another or was refused', () => {
    const dataset = new OpenDataset();
    expect(dataset.wants(shown)).toBeNull(); // not described yet
    dataset.told(info(1));
    expect(dataset.wants(shown)?.case).toBe('requestHistogram');
    expect(dataset.wants({ ...shown, revision: 9 })).toBeNull();
    expect(dataset.wants({ ...shown, step: 1 })).not.toBeNull();
    dataset.told(info(1, 2));
    expect(dataset.wants({ ...shown, step: 1 })).not.toBeNull();
    dataset.sent(5);
    dataset.refused(4, 'no', false);
    expect([dataset.uncounted, dataset.wants({ ...shown, step: 1 })]).toEqual(['', null]); // of what was shown before
    dataset.refused(5, 'no', false);
    expect(dataset.uncounted).toBe('no');
    expect(dataset.wants({ ...shown, step: 1 })).not.toBeNull();
    dataset.sent(6);
    dataset.refused(6, 'Cancelled.', true);
    expect(dataset.wants({ ...shown, step: 1 })).toBeNull();
    expect(dataset.wants({ ...shown, step: 1 }, true)).not.toBeNull();
    for (const onDisk of ['changed', undefined] as const) dataset.told(info(1, 2, onDisk));
    expect(dataset.wants({ ...shown, step: 1 }), 'other values of the same range').not.toBeNull();
    dataset.turnedTo('other');
    expect(dataset.info).toBeNull();
  });

  test('wants bins that hold as many whole numbers each, and 256 of other numbers', () => {
    const bins = (upper: number, type: string, association = 'point', values = 'interpolated') => {
      const dataset = new OpenDataset();
      dataset.told({ id: 'fin', arrays: [{ name: 'Density', lower: 0, upper, type, association, cells: { lower: 0, upper } }], times: [0] } as unknown as DatasetInfo);
      const wanted = dataset.wants({ ...shown, values: values as SceneState['values'] });
      return wanted?.case === 'requestHistogram' ? wanted.value.bins : null;
    };
    expect(bins(197, 'uint8')).toBe(198);
    expect(bins(255, 'uint8')).toBe(256);
    expect(bins(4095, 'int16')).toBe(256);
    expect(bins(3999, 'uint16')).toBe(250);
    expect(bins(197, 'float32')).toBe(256);
    expect(bins(197, 'uint8', 'cell_averaged')).toBe(256); // means are not whole
    expect(bins(197, 'uint8', 'cell_averaged', 'whole')).toBe(198);
    expect(bins(0, 'uint8')).toBe(256);
  });

  test('counts the steps that have come, but not those of a file that was written anew', () => {
    const dataset = new OpenDataset();
    expect(dataset.told(info(2))).toBe(0);
    expect(dataset.told(info(5))).toBe(3);
    expect(dataset.told(info(4))).toBe(0);
    dataset.told(info(4, 1, 'changed'));
    expect(dataset.told(info(9))).toBe(0);
  });

  test('keeps its description and histogram in a session that goes on, and in no other', () => {
    for (const resumed of [true, false]) {
      const dataset = new OpenDataset();
      dataset.told(info(1));
      dataset.toldHistogram({ counts: [1] } as never);
      dataset.welcomed(null, 'fin', resumed);
      expect(dataset.info !== null).toBe(resumed);
      expect(dataset.histogram !== null).toBe(resumed);
      expect(dataset.wants(shown) !== null).toBe(resumed); // asked anew of a new connection
    }
  });
});

describe('people', () => {
  const who = (id: bigint, role: Participant['role']): Participant => ({ id, name: '', role, invited: false, client: '' });

  const anySize = { width: 0, height: 0 };

  test('only a change of this page’s own role is told', () => {
    const people = new People(() => {});
    people.welcomed({ role: 'controller', participant: 2n, resumeToken: 't' });
    expect(people.told([who(1n, 'viewer'), who(2n, 'controller')], anySize)).toBe(false);
    expect(people.told([who(1n, 'viewer'), who(2n, 'viewer')], anySize)).toBe(true);
    expect(people.viewOnly).toBe(true);
    expect(people.told([who(1n, 'controller'), who(2n, 'viewer')], anySize)).toBe(false);
    expect(people.told([who(1n, 'controller')], anySize)).toBe(false);
    expect(people.viewOnly).toBe(true);
  });

  test('how large pictures of those who only look are is asked of the server, and is what it tells', () => {
    const { send, cases } = line();
    const people = new People(send);
    people.setViewerSize({ width: 640, height: 360 });
    expect(cases()).toEqual(['setViewerSize']);
    expect(people.viewerSize).toEqual(anySize);
    people.told([], { width: 640, height: 360 });
    expect(people.viewerSize).toEqual({ width: 640, height: 360 });
  });

  test('a link that was just made is shown until another is asked for or it is revoked; who only looks sees no list', () => {
    const { send, cases } = line();
    const people = new People(send);
    people.welcomed({ role: 'controller', participant: 1n, resumeToken: 't' });
    people.toldMade({ id: 'a', token: 'x' } as never);
    expect(cases()).toEqual(['listInvitations']);
    people.revoke('b');
    expect(people.made?.id).toBe('a');
    people.revoke('a');
    expect(people.made).toBeNull();
    people.toldMade({ id: 'c', token: 'y' } as never);
    people.invite('viewer', 60, '');
    expect(people.made).toBeNull();
    people.welcomed({ role: 'viewer', participant: 1n, resumeToken: '' });
    expect(people.invited).toBe(true);
    const before = cases().length;
    people.listInvitations();
    expect(cases()).toHaveLength(before);
  });
});

test('of work that ends, a cancellation is told if somebody asked for it or nothing newer overtook it', () => {
  const purposes = ['answer', 'picture', 'dataset', 'ranges'] as const;
  const ends = (purpose: Purpose, asked: boolean, cancelled: boolean, superseded: boolean) => {
    const work = new Work(() => {});
    work.told({ operation: 4n, stage: 'reading', fraction: 0.5, purpose });
    work.told({ operation: 5n, stage: 'drawing', fraction: 0.1, purpose: 'picture' });
    if (asked) work.cancel(4n);
    const left = work.done({ operation: 4n, cancelled, superseded });
    expect(work.list.map(({ operation }) => operation)).toEqual([5n]);
    return left;
  };
  for (const superseded of [false, true]) {
    for (const asked of [false, true]) {
      for (const purpose of purposes) {
        expect(ends(purpose, asked, false, superseded)).toBeNull();
        expect(ends(purpose, asked, true, superseded)).toBe(asked || (!superseded && purpose !== 'ranges') ? purpose : null);
      }
    }
  }
});

test('a layer that was added is selected once, and one that is gone is not selected any more', () => {
  const selection = new Selection();
  selection.told([{ id: 1 }], [{ id: 1 }, { id: 2 }]); // somebody else’s
  expect(selection.layer).toBeNull();
  selection.expectNew();
  selection.told([{ id: 1 }, { id: 2 }], [{ id: 2 }]);
  expect(selection.layer).toBeNull();
  selection.told([{ id: 2 }], [{ id: 2 }, { id: 3 }]);
  expect(selection.layer).toBe(3);
  selection.told([{ id: 2 }, { id: 3 }], [{ id: 2 }, { id: 3 }, { id: 4 }]);
  expect(selection.layer).toBe(3);
  selection.told([{ id: 3 }], []);
  expect(selection.layer).toBeNull();
});

test('while the server opens the dataset again edits keep their patience, and have all of it when it has', () => {
  const clock = { now: 0 };
  const scene = new SceneView(() => clock.now);
  scene.edit((mine, nowMs) => mine.set({ step: 3 }, nowMs));
  scene.waking = true;
  for (let i = 0; i < 100; i++) {
    clock.now += 1000;
    scene.settle();
  }
  expect([scene.view.step, scene.waits]).toEqual([3, true]);
  scene.waking = false;
  clock.now += 2000;
  scene.settle();
  expect(scene.view.step).toBe(3);
  clock.now += 1;
  scene.settle();
  expect([scene.view.step, scene.waits]).toEqual([0, false]);
});

test('a still goes to who asked for it, once', async () => {
  let seq = 0;
  const stills = new Stills(() => ++seq);
  const annotations = { axes: false, box: false, legend: false };
  const [first, second, third] = [stills.ask(1, 1, annotations), stills.ask(2, 2, annotations), stills.ask(3, 3, annotations)];
  expect(stills.answer(2, 'too large')).toBe(true);
  expect(stills.answer(2, 'again')).toBe(false);
  expect(stills.answer(9, 'nobody')).toBe(false);
  stills.answer(1, { width: 1 } as Frame);
  stills.lost();
  expect(await first).toEqual({ width: 1 });
  expect(await second).toBe('too large');
  expect(await third).toContain('connection was lost');
  expect(await new Stills(() => 0).ask(1, 1, annotations)).toBe('There is no connection.');
});

test('a picture in bands is exact with its last band only, and has the bytes of all', () => {
  const frame = (index: number, count: number, bytes: number): Frame =>
    ({ frameId: BigInt(10 + index), phase: 'exact', band: { firstRow: 0, rows: 1, index, count }, payload: new Uint8Array(bytes), device: `of band ${index}` }) as Frame;
  const first = begun(null, frame(0, 3, 5), 30);
  expect(first).toMatchObject({ phase: 'settled', bytes: 5, fps: 30, device: 'of band 0' });
  const second = continued(first, frame(1, 3, 7));
  expect(second).toMatchObject({ frameId: 11n, phase: 'settled', bytes: 12 });
  expect(continued(second, frame(2, 3, 1))).toMatchObject({ frameId: 12n, phase: 'exact', bytes: 13, device: 'of band 0' });
  expect(continued(second, { ...frame(0, 3, 1), frameId: 20n })).toBeNull(); // another picture begins
  expect(continued(null, frame(1, 3, 7))).toBeNull(); // its beginning is not known here
  expect(begun(first, { ...frame(0, 1, 2), band: null }, 0)).toMatchObject({ phase: 'exact', bytes: 2 });
});
