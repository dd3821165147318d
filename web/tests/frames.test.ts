import { expect, test } from 'vitest';
import { FramePlayer } from '../src/lib/frames';
import type { Frame } from '../src/lib/model';

const frame = (id: number) => ({ frameId: BigInt(id), format: 'jpeg', payload: new Uint8Array() }) as unknown as Frame;

function harness() {
  const decoding = new Map<bigint, { done: () => void; fail: () => void }>();
  const drawn: number[] = [];
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
    draw: (_bitmap, f) => drawn.push(Number(f.frameId)),
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
  return { player, finish, drawn, acks, failures, closed: () => closed };
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
