import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import { describe, expect, test } from 'vitest';
import { ClientMessageSchema, ServerMessageSchema } from '../src/gen/isostrata/v1/isostrata_pb';
import { Connection, retryDelayMs, type ConnectionStatus, type NotOpened, type Socket } from '../src/lib/connection';
import type { ServerEvent } from '../src/lib/told';
import { command } from '../src/lib/commands';

class FakeSocket {
  binaryType: BinaryType = 'blob';
  readyState = 0;
  sent: Uint8Array[] = [];
  closed = false;
  onopen: ((event: Event) => void) | null = null;
  onmessage: ((event: MessageEvent) => void) | null = null;
  onclose: ((event: CloseEvent) => void) | null = null;
  send(data: unknown) {
    this.sent.push(data as Uint8Array);
  }
  close() {
    this.closed = true;
    this.readyState = 3;
  }
  opens() {
    this.readyState = 1;
    this.onopen?.({} as Event);
  }
  says(bytes: Uint8Array) {
    this.onmessage?.({ data: bytes.slice().buffer } as MessageEvent);
  }
  ends(reason = '') {
    this.readyState = 3;
    this.onclose?.({ reason } as CloseEvent);
  }
  get commands() {
    return this.sent.map((bytes) => fromBinary(ClientMessageSchema, bytes));
  }
}

function harness(why: NotOpened = { kind: 'unreachable' }) {
  const sockets: FakeSocket[] = [];
  const statuses: ConnectionStatus[] = [];
  const events: ServerEvent[] = [];
  const clock = { now: 0, timers: new Map<number, { at: number; callback: () => void }>(), next: 1 };
  const connection = new Connection({
    open: () => {
      sockets.push(new FakeSocket());
      return sockets[sockets.length - 1] as unknown as Socket;
    },
    hello: () => command.hello({ width: 800, height: 600, hidden: false }, 'resume-me'),
    onStatus: (status) => statuses.push(status),
    onEvent: (event) => events.push(event),
    askWhy: async () => why,
    now: () => clock.now,
    setTimeout: (callback, ms) => {
      clock.timers.set(clock.next, { at: clock.now + ms, callback });
      return clock.next++;
    },
    clearTimeout: (id) => void clock.timers.delete(id),
    random: () => 0.5,
  });
  const advance = (ms: number) => {
    clock.now += ms;
    for (const [id, timer] of clock.timers)
      if (timer.at <= clock.now) {
        clock.timers.delete(id);
        timer.callback();
      }
  };
  const last = <T>(list: T[]) => list[list.length - 1] as T;
  return { connection, sockets, statuses, events, advance, socket: () => last(sockets), status: () => last(statuses) };
}

const welcome = toBinary(
  ServerMessageSchema,
  create(ServerMessageSchema, { seq: 1n, body: { case: 'welcome', value: { protocolMajor: 1, session: 's' } } }),
);

describe('the connection', () => {
  test('says hello first, with its resume token, and numbers its messages from one', () => {
    const { connection, socket } = harness();
    connection.start();
    expect(connection.send(command.ping(1))).toBe(0);
    socket().opens();
    expect(connection.send(command.ping(1))).toBe(2);
    const [first, second] = socket().commands;
    expect(first?.body.case === 'hello' && first.body.value.resumeToken).toBe('resume-me');
    expect([first?.seq, second?.seq]).toEqual([1n, 2n]);
  });

  test('is connected when welcomed, not when the socket opens', () => {
    const { connection, socket, status, events } = harness();
    connection.start();
    socket().opens();
    expect(status().kind).toBe('connecting');
    socket().says(welcome);
    expect(status().kind).toBe('connected');
    expect(events.map((event) => event.kind)).toEqual(['welcome']);
  });

  test('comes back after a loss, and its seq starts again', () => {
    const { connection, socket, sockets, status, advance } = harness();
    connection.start();
    socket().opens();
    socket().says(welcome);
    socket().ends('bye');
    expect(status()).toMatchObject({ kind: 'waiting', reason: 'bye', retryAtMs: 500 });
    advance(500);
    expect(sockets).toHaveLength(2);
    socket().opens();
    expect(socket().commands[0]?.seq).toBe(1n);
  });

  test('waits longer each time, and never longer than twelve seconds', () => {
    const delays = Array.from({ length: 20 }, (_, attempt) => retryDelayMs(attempt, 0.5));
    expect(delays[0]).toBe(500);
    for (let i = 1; i < delays.length; i++) expect(delays[i]).toBeGreaterThanOrEqual(delays[i - 1] as number);
    expect(retryDelayMs(50, 0.999)).toBeLessThanOrEqual(12_000);
  });

  test('says that it was refused and does not hammer the server', async () => {
    const { connection, socket, sockets, status, advance } = harness({ kind: 'refused', reason: 'no such token' });
    connection.start();
    socket().ends();
    await Promise.resolve();
    await Promise.resolve();
    expect(status()).toEqual({ kind: 'refused', reason: 'no such token' });
    advance(60_000);
    expect(sockets).toHaveLength(1);
    connection.retryNow();
    expect(sockets).toHaveLength(2);
  });

  test('tries again where the server cannot be reached', async () => {
    const { connection, socket, sockets, status, advance } = harness();
    connection.start();
    socket().ends();
    await Promise.resolve();
    await Promise.resolve();
    expect(status()).toMatchObject({ kind: 'waiting', reason: 'The server cannot be reached.' });
    advance(10_000);
    expect(sockets).toHaveLength(2);
  });

  test('gives up on a server that has gone silent', () => {
    const { connection, socket, status, advance } = harness();
    connection.start();
    socket().opens();
    socket().says(welcome);
    advance(11_000);
    connection.checkAlive();
    expect(status().kind).toBe('connected');
    advance(2000);
    connection.checkAlive();
    expect(status().kind).toBe('waiting');
    expect(socket().closed).toBe(true);
  });

  test('survives bytes that are no message', () => {
    const { connection, socket, status } = harness();
    connection.start();
    socket().opens();
    socket().says(new Uint8Array([0xff, 0xff, 0xff, 0xff]));
    expect(status().kind).toBe('waiting');
  });

  test('keeps what the server said when it refused us', () => {
    const { connection, socket, status } = harness();
    connection.start();
    socket().opens();
    connection.refuse('version 2 was expected');
    socket().ends();
    expect(status()).toEqual({ kind: 'refused', reason: 'version 2 was expected' });
  });

  test('stops when told to', () => {
    const { connection, socket, sockets, advance } = harness();
    connection.start();
    const first = socket();
    connection.stop();
    first.ends();
    advance(60_000);
    expect(sockets).toHaveLength(1);
  });
});
