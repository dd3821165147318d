import { expect, test } from 'vitest';
import { FramePlayer } from '../src/lib/frames';
import type { Frame } from '../src/lib/told';

const band = (id: number, index: number, count: number) => ({ ...frame(id), band: { firstRow: 10 * index, rows: 10, index, count } });
const frame = (id: number) => ({ frameId: BigInt(id), format: 'jpeg', payload: new Uint8Array() }) as unknown as Frame;

function harness() {
  const decoding = new Map<bigint, { done: () => void; fail: () => void }>();
  const drawn: number[] = [];
  const completed: number[] = [];
  const acks: number[] = [];
  const failures: number[] = [];
  let closed = 0;
  const player = new FramePlayer({
    decode: (f) =>
      new Promise((resolve, reject) =>
        decoding.set(f.frameId, {
          done: () => resolve({ close: () => closed++ } as unknown as ImageBitmap),
          fail: () => reject(new Error('bad bytes')),
        }),
      ),
    draw: (_bitmap, f, complete) => {
      drawn.push(Number(f.frameId));
      if (complete) completed.push(Number(f.frameId));
    },
    ack: (id) => acks.push(Number(id)),
    failed: (f) => failures.push(Number(f.frameId)),
    now: () => 0,
  });
  const finish = async (id: number, well = true) => {
    const entry = decoding.get(BigInt(id));
    if (well) entry?.done();
    else entry?.fail();
    await new Promise((resolve) => setTimeout(resolve));
  };
  return { player, finish, drawn, completed, acks, failures, closed: () => closed };
}

test('every decoded frame is acknowledged, but an older one is not drawn over a newer', async () => {
  const { player, finish, drawn, acks, closed } = harness();
  void player.show(frame(1));
  void player.show(frame(2));
  await finish(2);
  await finish(1);
  expect(drawn).toEqual([2]);
  expect(acks).toEqual([2, 1]);
  expect(closed()).toBe(2);
});

test('a frame that cannot be decoded gives its credit back and is reported', async () => {
  const { player, finish, drawn, acks, failures } = harness();
  void player.show(frame(1));
  await finish(1, false);
  expect(drawn).toEqual([]);
  expect(acks).toEqual([1]);
  expect(failures).toEqual([1]);
});

test('a frame of the connection before is neither drawn nor acknowledged on the next', async () => {
  const { player, finish, drawn, acks, closed } = harness();
  void player.show(frame(5));
  player.reset();
  void player.show(frame(1));
  await finish(5);
  await finish(1);
  expect(drawn).toEqual([1]);
  expect(acks).toEqual([1]);
  expect(closed()).toBe(2);
});

test('bands of one picture are drawn in whatever order they are decoded, and complete it together', async () => {
  const { player, finish, drawn, completed, acks } = harness();
  void player.show(frame(4));
  await finish(4);
  for (const index of [0, 1, 2]) void player.show(band(5 + index, index, 3));
  for (const id of [7, 5, 6]) await finish(id);
  expect(drawn).toEqual([4, 7, 5, 6]);
  expect(completed).toEqual([4, 6]);
  expect(acks).toEqual([4, 7, 5, 6]);
});

test('bands that something newer has overtaken are not drawn over it', async () => {
  const { player, finish, drawn, completed, acks } = harness();
  void player.show(band(5, 0, 3));
  void player.show(band(6, 1, 3));
  void player.show(frame(7));
  await finish(5);
  await finish(7);
  await finish(6);
  expect(drawn).toEqual([5, 7]);
  expect(completed).toEqual([7]);
  expect(acks).toEqual([5, 7, 6]);
});
