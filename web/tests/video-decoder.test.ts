import { expect, test } from 'vitest';
import type { Frame } from '../src/lib/told';
import { StreamDecoder, StreamLost } from '../src/lib/video-decoder';

const frame = (id: number, streamId: number, key = false, width = 64) =>
  ({ frameId: BigInt(id), streamId, key, decoder: key ? 'vp09' : '', width, height: 48, payload: new Uint8Array() }) as unknown as Frame;

interface Fake {
  init: VideoDecoderInit;
  log: string[];
  state: string;
}

function harness() {
  const decoders: Fake[] = [];
  const closed: number[] = [];
  const stream = new StreamDecoder({
    create: (init) => {
      const fake: Fake = { init, log: [], state: 'configured' };
      decoders.push(fake);
      return {
        get state() {
          return fake.state;
        },
        configure: (config: VideoDecoderConfig) => fake.log.push(`configure ${config.codec} ${config.codedWidth}`),
        decode: (chunk: EncodedVideoChunk) => fake.log.push(`${chunk.type} ${chunk.timestamp}`),
        close: () => {
          fake.state = 'closed';
          fake.log.push('close');
        },
      } as unknown as VideoDecoder;
    },
    chunk: (init) => init as unknown as EncodedVideoChunk,
  });
  const emit = (decoder: number, timestamp: number) =>
    decoders[decoder]?.init.output({ timestamp, close: () => closed.push(timestamp) } as unknown as VideoFrame);
  const fail = (decoder: number, name: string) => decoders[decoder]?.init.error(new DOMException('no', name));
  return { stream, decoders, emit, fail, closed };
}
const outcome = (promise: Promise<VideoFrame>) =>
  promise.then(
    (picture) => picture.timestamp,
    (problem: Error) => problem,
  );

test('one frame in is one picture out, by its id, and the decoder is told once what comes', async () => {
  const { stream, decoders, emit } = harness();
  const first = outcome(stream.decode(frame(3, 1, true)));
  const second = outcome(stream.decode(frame(5, 1)));
  emit(0, 3);
  emit(0, 5);
  expect([await first, await second]).toEqual([3, 5]);
  void stream.decode(frame(6, 1, true));
  expect(decoders[0]?.log).toEqual(['configure vp09 64', 'key 3', 'delta 5', 'key 6']);
});

test('another size is told to the same decoder, another stream has another one', () => {
  const { stream, decoders } = harness();
  void stream.decode(frame(1, 1, true)).catch(() => {});
  void stream.decode(frame(2, 1, true, 32)).catch(() => {});
  void stream.decode(frame(3, 2, true)).catch(() => {});
  expect(decoders.map(({ log }) => log)).toEqual([['configure vp09 64', 'key 1', 'configure vp09 32', 'key 2', 'close'], ['configure vp09 64', 'key 3']]);
});

test('a picture of a stream that has ended is thrown away', () => {
  const { stream, emit, closed } = harness();
  void stream.decode(frame(1, 1, true)).catch(() => {});
  void stream.decode(frame(2, 2, true)).catch(() => {});
  emit(0, 1);
  expect(closed).toEqual([1]);
});

test('a frame without a picture gives its credit back when the next has come', async () => {
  const { stream, emit } = harness();
  const first = outcome(stream.decode(frame(1, 1, true)));
  const second = outcome(stream.decode(frame(2, 1)));
  emit(0, 2);
  expect(await first).toBeInstanceOf(Error);
  expect(await second).toBe(2);
});

test('a failed decoder is told of once, and what comes of its stream later only gives its credit back', async () => {
  const { stream, fail, decoders } = harness();
  const outcomes = [frame(1, 7, true), frame(2, 7), frame(3, 7)].map((f) => outcome(stream.decode(f)));
  fail(0, 'EncodingError');
  outcomes.push(outcome(stream.decode(frame(4, 7))));
  const [first, ...rest] = await Promise.all(outcomes);
  expect(first).toMatchObject({ streamId: 7, again: false, message: 'EncodingError: no' });
  for (const problem of rest) {
    expect(problem).toBeInstanceOf(Error);
    expect(problem).not.toBeInstanceOf(StreamLost);
  }
  expect(decoders[0]?.state).toBe('closed');
  void stream.decode(frame(5, 8, true));
  expect(decoders).toHaveLength(2);
});

test('a decoder that the browser takes away asks for the same again', async () => {
  const { stream, fail } = harness();
  const first = outcome(stream.decode(frame(1, 7, true)));
  fail(0, 'QuotaExceededError');
  expect(await first).toMatchObject({ streamId: 7, again: true });
});

test('a decoder that is lost while nothing waits is told of with the next frame, once', async () => {
  const { stream, fail, emit } = harness();
  const first = outcome(stream.decode(frame(1, 7, true)));
  emit(0, 1);
  expect(await first).toBe(1);
  fail(0, 'QuotaExceededError');
  expect(await outcome(stream.decode(frame(2, 7)))).toBeInstanceOf(StreamLost);
  expect(await outcome(stream.decode(frame(3, 7)))).not.toBeInstanceOf(StreamLost);
});

test('a stream that does not begin with a key frame is lost', async () => {
  const { stream } = harness();
  expect(await outcome(stream.decode(frame(4, 3)))).toMatchObject({ streamId: 3, again: false });
});

test('after a new connection stream numbers begin again', async () => {
  const { stream, decoders, fail } = harness();
  const old = outcome(stream.decode(frame(1, 1, true)));
  fail(0, 'EncodingError');
  await old;
  stream.reset();
  void stream.decode(frame(1, 1, true));
  expect(decoders[1]?.log).toEqual(['configure vp09 64', 'key 1']);
});
