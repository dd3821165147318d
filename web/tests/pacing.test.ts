import { expect, test } from 'vitest';
import type { Camera, IntervalPatch } from '../src/lib/model';
import { CameraCredits, Outbox } from '../src/lib/pacing';

const camera = (x: number): Camera => ({ eye: [x, 0, 5], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 30 });

function harness() {
  const sent: string[] = [];
  let scheduled: (() => void)[] = [];
  const gate = { open: true };
  const outbox = new Outbox({
    sendCamera: (c) => sent.push(`camera ${c.eye[0]}`),
    sendPatch: (id, patch: IntervalPatch) => sent.push(`patch ${id} ${JSON.stringify(patch)}`),
    sendOther: (key, value) => sent.push(`${key} ${String(value)}`),
    cameraMayGo: () => gate.open,
    schedule: (callback) => scheduled.push(callback),
  });
  const frame = () => {
    const due = scheduled;
    scheduled = [];
    for (const callback of due) callback();
    return due.length;
  };
  return { sent, outbox, gate, frame };
}

test('of many cameras within one animation frame only the newest is sent', () => {
  const { sent, outbox, frame } = harness();
  for (let i = 0; i < 100; i++) outbox.putCamera(camera(i));
  expect(sent).toEqual([]);
  expect(frame()).toBe(1);
  expect(sent).toEqual(['camera 99']);
  expect(frame()).toBe(0);
});

test('patches of one interval merge, those of two do not', () => {
  const { sent, outbox, frame } = harness();
  outbox.putPatch(1, { lower: 1 });
  outbox.putPatch(2, { upper: 9 });
  outbox.putPatch(1, { lower: 2, opacity: 0.5 });
  frame();
  expect(sent).toEqual(['patch 1 {"lower":2,"opacity":0.5}', 'patch 2 {"upper":9}']);
});

test('a camera without credit waits, stays the newest, and holds nothing else up', () => {
  const { sent, outbox, gate, frame } = harness();
  gate.open = false;
  outbox.putCamera(camera(1));
  outbox.put('step', 3);
  frame();
  expect(sent).toEqual(['step 3']);
  outbox.putCamera(camera(2));
  frame();
  gate.open = true;
  frame();
  expect(sent).toEqual(['step 3', 'camera 2']);
});

test('of what waits under several keys the last put goes last', () => {
  const { sent, outbox, frame } = harness();
  outbox.put('time', 0.5);
  outbox.put('step', 3);
  outbox.put('time', 0.7);
  frame();
  expect(sent).toEqual(['step 3', 'time 0.7']);
});

test('flush sends everything at once, whatever the credits', () => {
  const { sent, outbox, gate, frame } = harness();
  gate.open = false;
  outbox.putCamera(camera(7));
  outbox.putPatch(1, { lower: 2 });
  outbox.flush();
  expect(sent).toEqual(['patch 1 {"lower":2}', 'camera 7']);
  frame();
  expect(sent).toHaveLength(2);
});

test('what waited about a removed interval is forgotten', () => {
  const { sent, outbox, frame } = harness();
  outbox.putPatch(1, { lower: 2 });
  outbox.putPatch(2, { lower: 3 });
  outbox.drop(1);
  frame();
  expect(sent).toEqual(['patch 2 {"lower":3}']);
});

test('credits come back with the frames that contain the cameras, or with patience', () => {
  const credits = new CameraCredits(2, 250);
  credits.sent(10, 0);
  expect(credits.open(1)).toBe(true);
  credits.sent(11, 5);
  expect(credits.open(6)).toBe(false);
  credits.answered(9);
  expect(credits.open(7)).toBe(false);
  credits.answered(10);
  expect(credits.open(8)).toBe(true);
  credits.sent(12, 10);
  expect(credits.open(100)).toBe(false);
  expect(credits.open(260)).toBe(true);
  credits.reset();
  expect(credits.open(11)).toBe(true);
});
