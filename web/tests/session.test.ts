import { describe, expect, test } from 'vitest';
import type { Command } from '../src/lib/commands';
import type { Connection, ConnectionStatus } from '../src/lib/connection';
import { decodeEvent } from '../src/lib/events';
import type { ServerEvent } from '../src/lib/told';
import { badgeOf } from '../src/lib/picture-words';
import { SavedTab } from '../src/lib/saved';
import { Session } from '../src/lib/session.svelte';
import { serverSays, type Body } from './server-says';

function harness(store = new Map<string, string>(), options: { calm?: boolean } = {}) {
  const sent: { seq: number; body: Command; number: number }[] = [];
  const clock = { now: 0 };
  let scheduled: (() => void)[] = [];
  let refused = '';
  let handlers: { hello(): Command; onStatus(s: ConnectionStatus): void; onEvent(e: ServerEvent): void } | undefined;
  const session = new Session({
    connection: (given) => {
      handlers = given;
      return {
        start() {},
        stop() {},
        retryNow() {},
        checkAlive() {},
        refuse: (reason: string) => (refused = reason),
        send: (body: Command, number = 0) => {
          sent.push({ seq: sent.length + 1, body, number });
          return sent.length;
        },
      } as unknown as Connection;
    },
    saved: new SavedTab({ getItem: (key) => store.get(key) ?? null, setItem: (key, value) => void store.set(key, value) }, '/'),
    now: () => clock.now,
    schedule: (callback) => scheduled.push(callback),
    after: (ms, callback) => void setTimeout(callback, ms),
    movingFormats: ['vp9-444', 'jpeg'],
    calm: () => options.calm ?? false,
  });
  const says = (body: Body) => {
    handlers?.onEvent(decodeEvent(serverSays(body) as Uint8Array<ArrayBuffer>));
  };
  const frame = () => {
    const due = scheduled;
    scheduled = [];
    for (const callback of due) callback();
  };
  const cases = () => sent.map(({ body }) => body.case);
  const find = <C extends Command['case']>(name: C) =>
    [...sent].reverse().find(({ body }) => body.case === name) as
      | { seq: number; body: Extract<Command, { case: C }>; number: number }
      | undefined;
  return { session, sent, says, frame, clock, cases, find, store, handlers: handlers as NonNullable<typeof handlers>, refused: () => refused };
}

const camera = { eye: { z: 9 }, at: {}, up: { y: 1 }, fovDeg: 30 };
const interval = (id: number, lower: number, upper: number) => ({ id, lower, upper, color: { r: 1 }, opacity: 0.5, priority: id, visible: true });
const state = (revision: number, ...intervals: ReturnType<typeof interval>[]) => ({
  revision: BigInt(revision),
  dataset: 'fin',
  array: 'Density',
  mode: 1,
  camera,
  background: {},
  intervals,
});
const info = { id: 'fin', name: 'fin.bin', arrays: [{ name: 'Density', lower: 0, upper: 5 }], lower: {}, upper: { x: 1, y: 1, z: 1 } };
const welcome = (session: string, ...intervals: ReturnType<typeof interval>[]): Body => back(session, 0, ...intervals);
const back = (session: string, lastCommand: number, ...intervals: ReturnType<typeof interval>[]): Body => ({
  case: 'welcome',
  value: {
    lastCommand: BigInt(lastCommand),
    protocolMajor: 1,
    session,
    resumeToken: `token of ${session}`,
    datasets: [{ id: 'fin', name: 'fin.bin' }],
    state: state(1, ...intervals),
    datasetInfo: info,
  },
});

describe('the store', () => {
  test('asks for the histogram of what is shown, once per array and step', () => {
    const { says, cases, find } = harness();
    says(welcome('s'));
    says({ case: 'state', value: state(2) });
    expect(cases().filter((c) => c === 'requestHistogram')).toHaveLength(1);
    expect(find('requestHistogram')?.body.value.array).toBe('Density');
    says({ case: 'state', value: { ...state(3), array: 'Momentum' } });
    expect(find('requestHistogram')?.body.value.array).toBe('Momentum');
  });

  test('shows a drag at once and sends only the newest value of each animation frame', () => {
    const { session, says, frame, sent, find } = harness();
    says(welcome('s', interval(1, 0, 1)));
    const before = sent.length;
    for (let i = 1; i <= 60; i++) session.edits.patchInterval(1, { upper: 1 + i / 60 });
    expect(session.scene.view.intervals[0]?.upper).toBe(2);
    frame();
    expect(sent.length - before).toBe(1);
    expect(find('patchInterval')?.body.value).toMatchObject({ id: 1, upper: 2 });
  });

  test('a mode of time and a step that are chosen at once both go out, in their order', () => {
    const { session, says, frame, sent } = harness();
    says(welcome('s'));
    const before = sent.length;
    session.edits.setTime(1.6, 'interpolate');
    session.edits.setTime(null, 'step');
    session.edits.setStep(2);
    frame();
    expect(sent.slice(before).map(({ body }) => body)).toEqual([
      { case: 'setTime', value: { mode: 1 } },
      { case: 'setTimeStep', value: { step: 2 } },
    ]);
  });

  test('sends nothing while a hand that drags is at a stop, and what it says after', () => {
    const { session, says, frame, sent } = harness();
    says(welcome('s', interval(1, 0, 1), interval(2, 1, 2)));
    const before = sent.length;
    const drag = (upper: number) => (session.edits.patchInterval(1, { upper }), frame());
    drag(1);
    expect(sent.length).toBe(before);
    drag(0.5);
    drag(0.5);
    expect(sent.length).toBe(before + 1);
    drag(1); // back to what the server still says
    expect(sent.length).toBe(before + 2);
    session.edits.patchInterval(1, { upper: 1, opacity: 0.25 });
    frame();
    expect(sent.length).toBe(before + 3);
  });

  test('sends what waits before a command that must come after it', () => {
    const { session, says, cases } = harness();
    says(welcome('s', interval(1, 0, 1), interval(2, 1, 2)));
    session.edits.patchInterval(2, { lower: 1.5 });
    session.edits.reorderPriorities([1, 2]);
    expect(cases().slice(-2)).toEqual(['patchInterval', 'reorderPriorities']);
    session.edits.patchInterval(1, { lower: 0.5 });
    session.edits.removeInterval(1);
    expect(cases().slice(-2)).toEqual(['reorderPriorities', 'removeInterval']);
  });

  test('keeps the other layers and their ids when one is added, and selects the new one', () => {
    const { session, says, find } = harness();
    says(welcome('s', interval(1, 0, 1)));
    session.edits.addInterval({ lower: 2, upper: 3, color: [0, 1, 0], colorMap: '', opacity: 0.5, visible: true });
    expect(find('setIntervals')?.body.value.intervals?.map((i) => [i.id, i.priority])).toEqual([[1, 1], [0, 2]]);
    says({ case: 'state', value: state(2, interval(1, 0, 1), interval(7, 2, 3)) });
    expect(session.selection.layer).toBe(7);
  });

  test('puts a refusal beside the layer that it is about and shows the server’s value again', () => {
    const { session, says, frame, find } = harness();
    says(welcome('s', interval(1, 0, 1)));
    session.edits.patchInterval(1, { upper: -4 });
    frame();
    const seq = find('patchInterval')?.seq ?? 0;
    says({ case: 'error', value: { inReplyTo: BigInt(seq), code: 'invalid_argument', message: 'lower 0 is not less than upper -4', field: 'upper' } });
    expect(session.notices.list).toMatchObject([{ place: 'layers', interval: 1, field: 'upper', text: 'lower 0 is not less than upper -4' }]);
    expect(session.scene.view.intervals[0]?.upper).toBe(1);
    session.edits.patchInterval(1, { upper: 0.5 });
    expect(session.notices.list).toEqual([]);
  });

  test('lets a chosen view win over a drag that was not answered yet', () => {
    const { session, says } = harness();
    says(welcome('s'));
    session.edits.moveCamera({ eye: [5, 0, 0], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 30 });
    session.edits.setView('+z');
    says({ case: 'state', value: { ...state(3), camera: { ...camera, eye: { z: 7 } } } });
    expect(session.camera?.eye).toEqual([0, 0, 7]);
  });

  test('comes back to the server’s value by itself when the State that it waits for was merged away', () => {
    const { session, says, clock } = harness();
    says(welcome('s', interval(1, 0, 1)));
    session.edits.patchInterval(1, { upper: 2 });
    says({ case: 'state', value: state(3, interval(1, 0, 3)) });
    expect(session.scene.view.intervals[0]?.upper).toBe(2);
    clock.now = 4000;
    session.heartbeat();
    expect(session.scene.view.intervals[0]?.upper).toBe(3);
  });

  test('keeps a chosen dataset chosen while it is being opened, until it is refused or cancelled', () => {
    const { session, says, clock, find } = harness();
    says(welcome('s'));
    session.edits.openDataset('big');
    clock.now = 60_000;
    session.heartbeat();
    expect(session.scene.view.dataset).toBe('big');
    says({ case: 'error', value: { inReplyTo: BigInt(find('openDataset')?.seq ?? 0), code: 'bad_data', message: 'big: truncated' } });
    expect(session.scene.view.dataset).toBe('fin');
    expect(session.notices.list).toMatchObject([{ place: 'dataset', text: 'big: truncated' }]);
    session.edits.openDataset('big');
    says({ case: 'progress', value: { operation: 1n, purpose: 1 } });
    says({ case: 'done', value: { operation: 1n, cancelled: true } });
    expect(session.scene.view.dataset).toBe('big'); // it was the picture of the old one
    says({ case: 'progress', value: { operation: 2n, purpose: 2 } });
    says({ case: 'done', value: { operation: 2n, cancelled: true } });
    expect(session.scene.view.dataset).toBe('fin');
  });

  test('follows the list of files, asks again for the part that is looked at, and tells of new steps once', async () => {
    const { session, says, cases, find } = harness();
    says(welcome('s'));
    says({ case: 'datasetInfo', value: { ...info, times: [0, 1] } });
    says({ case: 'datasetsChanged', value: { all: 2, entries: [{ id: 'late', name: 'late.vtk', news: 1 }] } });
    expect(session.files.datasets.map((entry) => [entry.id, entry.news]).at(-1)).toEqual(['late', 'appeared']);
    expect(cases()).not.toContain('listDatasets'); // nobody looks
    session.files.browse({ folder: 'run', search: '', first: 0 });
    says({ case: 'datasetList', value: { folder: 'run', total: 1, datasets: [{ id: 'a', name: 'run/a.vtk', bytes: 5n }] } });
    expect(session.files.listing?.datasets[0]).toMatchObject({ name: 'run/a.vtk', bytes: 5 });
    const asked = find('listDatasets')?.seq ?? 0;
    says({ case: 'datasetsChanged', value: { all: 2, entries: [{ id: 'late', name: 'late.vtk', news: 4 }] } });
    await new Promise((done) => setTimeout(done, 150));
    expect(find('listDatasets')?.seq).toBeGreaterThan(asked);
    says({ case: 'datasetInfo', value: { ...info, times: [0, 1, 2] } });
    says({ case: 'datasetInfo', value: { ...info, times: [0, 1, 2] } });
    expect(session.notices.list.filter((notice) => notice.text === 'One more step has come.')).toHaveLength(1);
    says({ case: 'datasetInfo', value: { ...info, times: [0, 1, 2], onDisk: 1 } });
    expect(session.dataset.info?.onDisk).toBe('changed');
    session.edits.reloadDataset();
    expect(find('reloadDataset')).toBeDefined();
    session.files.browse(null);
    expect(session.files.listing).toBeNull();
  });
  test('tells begin and end of overlapping interactions once', () => {
    const { session, says, sent } = harness();
    says(welcome('s'));
    session.hand.begin();
    session.hand.begin();
    session.hand.end();
    session.hand.end();
    session.hand.end();
    expect(sent.flatMap(({ body }) => (body.case === 'interaction' ? [body.value.active] : []))).toEqual([true, false]);
  });

  test('shows work in progress until it is done, and can cancel it', () => {
    const { session, says, find } = harness();
    says(welcome('s'));
    says({ case: 'progress', value: { operation: 4n, stage: 'reading', fraction: 0.2 } });
    says({ case: 'progress', value: { operation: 4n, stage: 'reading', fraction: 0.6 } });
    expect(session.work.list).toEqual([{ operation: 4n, stage: 'reading', fraction: 0.6, purpose: 'answer' }]);
    session.work.cancel(4n);
    expect(find('cancel')?.body.value.operation).toBe(4n);
    says({ case: 'done', value: { operation: 4n, cancelled: true } });
    expect(session.work.list).toEqual([]);
  });

  test('for whom motion is too much no cycle begins by itself, and for others it does', () => {
    const playing = (calm: boolean) => {
      const { session, says, frame, sent } = harness(new Map(), { calm });
      says(welcome('s', interval(1, 0, 1), interval(2, 1, 2)));
      session.edits.setMode('cycled');
      frame();
      return sent.map(({ body }) => body).filter((body) => body.case === 'setCycle' || body.case === 'setAppearance');
    };
    expect(playing(true)).toMatchObject([{ case: 'setCycle', value: { playing: false } }, { case: 'setAppearance' }]);
    expect(playing(false).map((body) => body.case)).toEqual(['setAppearance']);
  });

  test('for whom motion is too much a cycle that is found playing is stopped, and goes on by hand', () => {
    const { session, says, frame, find } = harness(new Map(), { calm: true });
    const playing = { ...state(1, interval(1, 0, 1)), mode: 3, cycle: { seconds: 1, phase: 0, playing: true } };
    const { value } = welcome('s') as { value: object };
    says({ case: 'welcome', value: { ...value, state: playing } } as Body);
    frame();
    expect(find('setCycle')?.body.value).toMatchObject({ playing: false });
    session.edits.setCycle({ playing: true });
    frame();
    expect(find('setCycle')?.body.value).toMatchObject({ playing: true });
    says({ case: 'state', value: { ...playing, revision: 4n } });
    frame();
    expect(find('setCycle')?.body.value).toMatchObject({ playing: true });
  });

  test('a picture for keeping is not shown and comes to who asked for it, or why there is none', async () => {
    const { session, says, find, handlers } = harness();
    says(welcome('s', interval(1, 0, 1)));
    const asked = session.stills.ask(64, 48, { axes: true, box: false, legend: true });
    expect(find('requestStill')?.body.value).toMatchObject({ width: 64, height: 48, annotations: { axes: true, box: false, legend: true } });
    const seq = BigInt(find('requestStill')?.seq ?? 0);
    says({ case: 'frame', value: { inReplyTo: seq, width: 64, height: 48, format: 'png', payload: new Uint8Array([7]) } });
    expect(session.frames.frame).toBeNull();
    expect(await asked).toMatchObject({ width: 64, payload: new Uint8Array([7]) });
    const refused = session.stills.ask(1e6, 1, { axes: false, box: false, legend: false });
    says({ case: 'error', value: { inReplyTo: BigInt(find('requestStill')?.seq ?? 0), code: 'too_large', message: 'width is 1000000' } });
    expect(await refused).toBe('width is 1000000');
    expect(session.notices.list).toEqual([]);
    const lostOnTheWay = session.stills.ask(64, 48, { axes: false, box: false, legend: false });
    handlers.onStatus({ kind: 'waiting', attempt: 1, retryAtMs: 0, reason: '' });
    expect(await lostOnTheWay).toContain('connection was lost');
  });

  test('after Cancel the picture is called older than the controls until a newer one comes', () => {
    const { session, says } = harness();
    says(welcome('s', interval(1, 0, 1)));
    const frame = (revision: bigint): Body => ({ case: 'frame', value: { revision, phase: 2, format: 'png', facts: { tetrahedra: 9n } } });
    const word = () => session.frames.frame && badgeOf(session.frames.frame, { revision: session.scene.view.revision, waits: session.scene.waits }, false, 600).word;
    says(frame(1n));
    expect(word()).toBe('exact');
    says({ case: 'state', value: state(2, interval(1, 0, 3)) });
    says({ case: 'progress', value: { operation: 4n, stage: 'extracting', fraction: 0.2 } });
    session.work.cancel(4n);
    says({ case: 'done', value: { operation: 4n, cancelled: true } });
    expect(word()).toBe('older');
    says(frame(2n));
    expect(word()).toBe('exact');
  });

  test('a picture is not called exact while an edit has no answer', () => {
    const { session, says, clock } = harness();
    says(welcome('s', interval(1, 0, 1)));
    const word = () => session.frames.frame && badgeOf(session.frames.frame, { revision: session.scene.view.revision, waits: session.scene.waits }, false, 600).word;
    says({ case: 'frame', value: { revision: 1n, phase: 2, format: 'png', facts: { tetrahedra: 9n } } });
    session.edits.patchInterval(1, { upper: 3 });
    expect(word()).toBe('older');
    says({ case: 'state', value: state(2, interval(1, 0, 3)) });
    says({ case: 'frame', value: { revision: 2n, phase: 2, format: 'png', facts: { tetrahedra: 9n } } });
    expect(word()).toBe('exact');
    // One whose answer never comes is not waited for without end.
    session.edits.patchInterval(1, { upper: 4 });
    expect(word()).toBe('older');
    clock.now += 5000;
    session.heartbeat();
    expect(word()).toBe('exact');
  });

  test('asks for the histogram again when a series’ ranges are complete, and for nothing else', () => {
    const { says, cases } = harness();
    says(welcome('s', interval(1, 0, 1)));
    const histograms = () => cases().filter((c) => c === 'requestHistogram').length;
    expect(histograms()).toBe(1);
    const array = info.arrays[0];
    if (!array) throw new Error('an array is expected');
    says({ case: 'datasetInfo', value: info });
    expect(histograms()).toBe(1);
    says({ case: 'datasetInfo', value: { ...info, arrays: [{ ...array, upper: (array.upper ?? 0) + 5 }, ...info.arrays.slice(1)] } });
    expect(histograms()).toBe(2);
  });

  test('keeps the dataset that was chosen last when the one before it is given up', () => {
    const { session, says, find } = harness();
    says(welcome('s'));
    session.views.openDataset('big');
    const first = BigInt(find('openDataset')!.seq);
    session.views.openDataset('jet');
    says({ case: 'error', value: { inReplyTo: first, code: 'cancelled', message: 'cancelled' } });
    expect(session.scene.view.dataset).toBe('jet');
    says({ case: 'state', value: { ...state(2), dataset: 'jet' } });
    expect(session.history.undoes).toBe('opening jet');
    session.history.undo();
    expect(find('openDataset')!.body.value.id).toBe('fin');
    session.views.openDataset('big');
    says({ case: 'error', value: { inReplyTo: BigInt(find('openDataset')!.seq), code: 'bad_data', message: 'big: truncated' } });
    expect(session.scene.view.dataset).toBe('jet');
    expect(session.notices.list).toMatchObject([{ text: 'big: truncated' }]);
  });

  test('of a histogram of the dataset before nothing is said', () => {
    const { session, says, find } = harness();
    says(welcome('s'));
    const refuse = (array: string) => says({ case: 'error', value: { inReplyTo: BigInt(find('requestHistogram')!.seq), code: 'not_found', message: `array '${array}' is not in it` } });
    says({ case: 'state', value: { ...state(2), dataset: 'jet', array: 'p' } });
    refuse('Density');
    expect(session.dataset.uncounted).toBe('');
    says({ case: 'datasetInfo', value: { ...info, id: 'jet', arrays: [{ name: 'p', lower: 0, upper: 5 }] } });
    refuse('p');
    expect(session.dataset.uncounted).toBe("array 'p' is not in it");
  });

  test('of what is cancelled the page says what ended: a curve in its place, the picture, a dataset, whatever else is asked', () => {
    const { session, says, find } = harness();
    says(welcome('s'));
    says({ case: 'frame', value: { revision: 1n, phase: 2, format: 'png', facts: { tetrahedra: 9n } } });
    session.curves.show({ kind: 'steps', at: [0, 0, 0] });
    const { seq } = find('probeSteps')!;
    says({ case: 'progress', value: { operation: 4n, stage: 'reading values', fraction: 0.5 } });
    session.work.cancel(4n);
    says({ case: 'done', value: { operation: 4n, cancelled: true } });
    says({ case: 'error', value: { inReplyTo: BigInt(seq), code: 'cancelled', message: 'cancelled' } });
    const told = () => session.notices.list.map(({ text }) => text).filter((text) => text.startsWith('Cancelled'));
    expect(told()).toEqual([]);
    expect(session.curves.answer).toBe('Cancelled.');

    const picture = ['Cancelled. The picture shows the last finished state.'];
    for (const purpose of [1, 2]) {
      session.curves.again(); // and is still asked for while the other is cancelled
      says({ case: 'progress', value: { operation: 5n, purpose } });
      session.work.cancel(5n);
      says({ case: 'done', value: { operation: 5n, cancelled: true } });
      expect(told()).toEqual(picture);
      session.notices.dismiss(session.notices.list[0]!.id);
      expect(session.curves.waits).toBe(true);
    }
  });

  test('a histogram that is cancelled says so in its place, and is counted again if somebody asks for it', () => {
    const { session, says, find, cases } = harness();
    says(welcome('s'));
    says({ case: 'progress', value: { operation: 4n } });
    session.work.cancel(4n);
    says({ case: 'error', value: { inReplyTo: BigInt(find('requestHistogram')!.seq), code: 'cancelled', message: 'cancelled' } });
    says({ case: 'done', value: { operation: 4n, cancelled: true } });
    expect(session.dataset.uncounted).toBe('Cancelled.');
    expect(session.notices.list).toEqual([]);
    const asked = () => cases().filter((name) => name === 'requestHistogram').length;
    says({ case: 'state', value: state(3) }); // nobody has asked again
    expect(asked()).toBe(1);
    session.askHistogram(true);
    expect(asked()).toBe(2);
    expect(session.dataset.uncounted).toBe('');
  });

  test('tells of a dataset that somebody else has opened, and not of its own', () => {
    const { session, says } = harness();
    const words = () => session.notices.list.map(({ text }) => text);
    says(welcome('s'));
    session.views.openDataset('jet');
    says({ case: 'state', value: { ...state(2), dataset: 'jet' } });
    expect(words()).toEqual([]);
    says({ case: 'state', value: { ...state(3), dataset: 'fin' } });
    expect(words()).toEqual(['Somebody else has opened “fin.bin”.']);
  });

  test('says that the values are others since a reload, once all steps are read, and nothing if they are as before', () => {
    const { session, says } = harness();
    const told = (upper: number, more: object = {}) => says({ case: 'datasetInfo', value: { ...info, arrays: [{ name: 'Density', lower: 0, upper }], ...more } });
    const words = () => session.notices.list.map(({ text }) => text);
    says(welcome('s', interval(7, 1, 2)));
    told(5, { onDisk: 1 });
    told(5);
    expect(words()).toEqual([]);
    told(5, { onDisk: 1 });
    told(2, { missingRangeSteps: 1 });
    expect(words()).toEqual([]);
    told(10);
    expect(words()).toEqual(['The values were 0 … 5 and are 0 … 10 now. The layers keep their ends.']);
    session.notices.list[0]?.action?.run();
    expect(session.scene.view.intervals.map(({ lower, upper }) => [lower, upper])).toEqual([[2, 4]]);
    told(20); // without a reload
    expect(words()).toHaveLength(1);
  });

  test('a reading in the background that is cancelled leaves the picture as it is', () => {
    const { session, says } = harness();
    says(welcome('s'));
    says({ case: 'progress', value: { operation: 4n, stage: 'reading', fraction: 0.2, purpose: 3 } });
    session.work.cancel(4n);
    says({ case: 'done', value: { operation: 4n, cancelled: true } });
    expect(session.notices.list.map((notice) => notice.text)).toEqual(['Cancelled. Ranges are those of the steps that were read.']);
  });

  test('after a reconnect to the same session keeps the server’s state', () => {
    const { says, handlers, cases } = harness();
    says(welcome('s', interval(1, 0, 1)));
    handlers.onStatus({ kind: 'waiting', attempt: 1, retryAtMs: 0, reason: '' });
    const hello = handlers.hello();
    expect(hello.case === 'hello' && hello.value.resumeToken).toBe('token of s');
    says(welcome('s', interval(1, 0, 1)));
    expect(cases()).not.toContain('setIntervals');
  });

  test('after a reconnect to a restarted server sends its picture again', () => {
    const { session, says, handlers, find, frame } = harness();
    says(welcome('s', interval(5, 0.25, 0.75)));
    session.edits.patchInterval(5, { upper: 0.9 });
    frame();
    handlers.onStatus({ kind: 'waiting', attempt: 1, retryAtMs: 0, reason: '' });
    says(welcome('another', interval(1, 0, 5)));
    const intervals = find('setIntervals')?.body.value.intervals;
    expect(intervals?.map((i) => [i.id, i.lower, i.upper])).toEqual([[0, 0.25, 0.9]]);
    expect(find('setCamera')?.body.value.camera?.eye).toMatchObject({ z: 9 });
  });

  test('opens the first dataset of a session that has just begun, and leaves a resumed one as it is', () => {
    const empty = (session: string, lastCommand = 0n): Body => ({
      case: 'welcome',
      value: { protocolMajor: 1, session, resumeToken: session, datasets: [{ id: 'fin', name: 'fin.bin' }], state: {}, lastCommand },
    });
    const first = harness();
    first.says(empty('s'));
    expect(first.find('openDataset')?.body.value.id).toBe('fin');
    first.says(empty('s', 1n));
    expect(first.cases().filter((c) => c === 'openDataset')).toHaveLength(1);
  });

  test('goes on to the next dataset where the first cannot be opened, but not from one that somebody has chosen', () => {
    const { session, says, sent, find } = harness();
    const datasets = Array.from({ length: 9 }, (_, i) => ({ id: `d${i}`, name: `d${i}` }));
    const opened = () => sent.flatMap(({ body }) => (body.case === 'openDataset' ? [body.value.id] : []));
    const refuse = () => says({ case: 'error', value: { inReplyTo: BigInt(find('openDataset')?.seq ?? 0), code: 'bad_data', message: 'it is cut off' } });
    says({ case: 'welcome', value: { protocolMajor: 1, session: 's', resumeToken: 's', datasets, state: {} } });
    refuse();
    expect(opened()).toEqual(['d0', 'd1']);
    session.views.openDataset('d7');
    refuse();
    expect(opened()).toEqual(['d0', 'd1', 'd7']);
    expect(session.notices.list).toMatchObject([{ place: 'dataset', text: 'it is cut off' }]);

    const other = harness();
    other.says({ case: 'welcome', value: { protocolMajor: 1, session: 's', resumeToken: 's', datasets, state: {} } });
    for (let i = 0; i < 9; i++) other.says({ case: 'error', value: { inReplyTo: BigInt(other.find('openDataset')?.seq ?? 0), code: 'bad_data', message: 'it is cut off' } });
    expect(other.cases().filter((c) => c === 'openDataset')).toHaveLength(5);
  });

  test('says who it is, the same over all connections and another in each page', () => {
    const [one, two] = [harness(), harness()];
    const id = ({ handlers }: typeof one) => {
      const hello = handlers.hello();
      return hello.case === 'hello' ? hello.value.clientId : '';
    };
    expect(id(one)).toMatch(/^[0-9a-f]{32}$/);
    expect(id(one)).toBe(id(one));
    expect(id(one)).not.toBe(id(two));
  });

  const lost = { kind: 'waiting', attempt: 1, retryAtMs: 0, reason: '' } as const;

  test('sends again what the session has not judged, by the same numbers and before anything new', () => {
    const { session, says, handlers, frame, sent } = harness();
    says(welcome('s', interval(1, 0, 1), interval(2, 2, 3)));
    session.edits.setView('+z');
    session.edits.patchInterval(1, { upper: 1.5 });
    frame();
    session.edits.removeInterval(2);
    const numbers = sent.flatMap(({ number }) => (number ? [number] : []));
    expect(numbers).toEqual([1, 2, 3]);
    handlers.onStatus(lost);
    const before = sent.length;
    says(back('s', 1, interval(1, 0, 1), interval(2, 2, 3)));
    session.edits.setMode('prioritized');
    const again = sent.slice(before).filter(({ number }) => number > 0);
    expect(again.map(({ number, body }) => [number, body.case])).toEqual([[2, 'patchInterval'], [3, 'removeInterval'], [4, 'setAppearance']]);
    expect(session.scene.view.intervals.map((i) => [i.id, i.upper])).toEqual([[1, 1.5]]);
  });

  test('keeps a drag under the hand over a loss: it is shown all the time and goes on where the hand is', () => {
    const { session, says, handlers, frame, sent, clock, find } = harness();
    says(welcome('s', interval(1, 0, 1)));
    session.hand.begin();
    session.edits.patchInterval(1, { upper: 1.25 });
    frame();
    handlers.onStatus(lost);
    const before = sent.length;
    for (let i = 1; i <= 50; i++) {
      session.edits.patchInterval(1, { upper: 1.25 + i / 100 });
      frame();
      clock.now += 200;
      session.heartbeat();
      expect(session.scene.view.intervals[0]?.upper).toBe(1.25 + i / 100);
    }
    expect(sent.slice(before).filter(({ body }) => body.case !== 'ping')).toEqual([]);
    says(back('s', 0, interval(1, 0, 1)));
    const cases = sent.slice(before).map(({ body }) => body.case);
    expect(cases.filter((c) => c === 'patchInterval')).toHaveLength(1);
    expect(find('patchInterval')?.body.value).toMatchObject({ id: 1, upper: 1.75 });
    expect(find('interaction')?.body.value.active).toBe(true);
    expect(cases.indexOf('interaction')).toBeLessThan(cases.indexOf('patchInterval'));
    expect(session.scene.view.intervals[0]?.upper).toBe(1.75);
    session.edits.patchInterval(1, { upper: 1.8 });
    session.hand.end();
    expect(find('patchInterval')?.body.value).toMatchObject({ id: 1, upper: 1.8 });
    expect(find('interaction')?.body.value.active).toBe(false);
    expect(session.notices.list).toEqual([]);
  });

  test('keeps the plot and the edits while a restarted server opens the dataset again', () => {
    const { session, says, handlers, clock } = harness();
    says(welcome('s', interval(1, 0, 1)));
    says({ case: 'histogram', value: { dataset: 'fin', array: 'Density', lower: 0, upper: 5, counts: [1n] } });
    session.edits.patchInterval(1, { upper: 2 });
    handlers.onStatus(lost);
    const asleep = back('s', 0, interval(1, 0, 1));
    if (asleep.case === 'welcome') delete asleep.value.datasetInfo;
    says(asleep);
    for (let i = 0; i < 10; i++) {
      clock.now += 1000;
      session.heartbeat();
    }
    expect(session.dataset.info?.id).toBe('fin');
    expect(session.dataset.histogram?.counts).toEqual([1]);
    expect(session.scene.view.intervals[0]?.upper).toBe(2);
    says({ case: 'datasetInfo', value: info });
    clock.now += 4000;
    session.heartbeat();
    expect(session.scene.view.intervals[0]?.upper).toBe(1);
  });

  test('does not try again what was refused', () => {
    const { session, says, handlers, frame, sent, find } = harness();
    says(welcome('s', interval(1, 0, 1)));
    session.edits.patchInterval(1, { upper: -4 });
    frame();
    says({ case: 'error', value: { inReplyTo: BigInt(find('patchInterval')?.seq ?? 0), code: 'invalid_argument', message: 'no' } });
    handlers.onStatus(lost);
    const before = sent.length;
    says(back('s', 0, interval(1, 0, 1)));
    expect(sent.slice(before).some(({ body }) => body.case === 'patchInterval')).toBe(false);
  });

  test('sends nothing of an old session to a new one', () => {
    const { session, says, handlers, frame, sent } = harness();
    says(welcome('s', interval(5, 0, 1)));
    session.hand.begin();
    session.edits.patchInterval(5, { upper: 0.9 });
    handlers.onStatus(lost);
    const before = sent.length;
    says(welcome('another', interval(1, 0, 5)));
    session.edits.patchInterval(5, { upper: 0.95 }); // the hand is still down
    frame();
    session.hand.end();
    expect(sent.slice(before).some(({ body }) => body.case === 'patchInterval' || body.case === 'interaction')).toBe(false);
    expect(session.hand.holds).toBe(false);
  });

  test('tells of a cancellation that somebody asked for, and not of work that a newer edit overtook', () => {
    const { session, says } = harness();
    says(welcome('s', interval(1, 0, 1)));
    const told = () => session.notices.list.some(({ text }) => text.startsWith('Cancelled'));
    for (const operation of [3n, 4n, 5n, 6n]) says({ case: 'progress', value: { operation, purpose: 1 } });
    says({ case: 'done', value: { operation: 3n, cancelled: true, superseded: true } });
    expect(told()).toBe(false);
    session.edits.openDataset('big');
    says({ case: 'done', value: { operation: 4n, cancelled: true, superseded: true } });
    expect(session.scene.view.dataset).toBe('big');
    says({ case: 'done', value: { operation: 5n, cancelled: true } }); // by another participant
    expect(told()).toBe(true);
    session.notices.dismiss(session.notices.list[0]?.id ?? 0);
    session.work.cancel(6n);
    says({ case: 'done', value: { operation: 6n, cancelled: true, superseded: true } });
    expect(told()).toBe(true);
  });

  test('refuses a server of another major version in words', () => {
    const { session, says } = harness();
    says({ case: 'welcome', value: { protocolMajor: 2 } });
    expect(session.status.kind).toBe('refused');
  });
});
