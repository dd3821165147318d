// One WebSocket that comes back: connect, Hello, messages in and out, and after a loss a retry with backoff.
import { encodeCommand, type Command } from './commands';
import { decodeEvent } from './events';
import type { ServerEvent } from './told';
import { subprotocol } from './protocol';

export type ConnectionStatus =
  | { kind: 'connecting'; attempt: number }
  | { kind: 'connected' }
  | { kind: 'waiting'; attempt: number; retryAtMs: number; reason: string }
  | { kind: 'refused'; reason: string }; // trying again by itself would not help

/** Why a socket did not open; a refusal with its reason in words. */
export type NotOpened = { kind: 'refused'; reason: string } | { kind: 'unreachable' } | { kind: 'unknown' };

/** What a browser's WebSocket offers and this needs. */
export type Socket = Pick<WebSocket, 'binaryType' | 'readyState' | 'send' | 'close'> & {
  onopen: ((event: Event) => void) | null;
  onmessage: ((event: MessageEvent) => void) | null;
  onclose: ((event: CloseEvent) => void) | null;
};

export interface ConnectionDoors {
  open(subprotocol: string): Socket;
  hello(): Command;
  onStatus(status: ConnectionStatus): void;
  onEvent(event: ServerEvent): void;
  /** Asks over HTTP why the socket did not open: a browser hides the status of a refused handshake. */
  askWhy(): Promise<NotOpened>;
  now(): number;
  setTimeout(callback: () => void, ms: number): number;
  clearTimeout(id: number): void;
  random(): number;
}

const firstRetryMs = 500;
const longestRetryMs = 10_000;
const silenceMs = 12_000; // pings go out every 2 s: a server silent for this long is gone, whatever TCP says

/** 0.5 s, 0.9 s, 1.6 s, ... 10 s, each a fifth more or less so that pages do not come back all at once. */
export function retryDelayMs(attempt: number, random: number): number {
  return Math.min(firstRetryMs * 1.8 ** attempt, longestRetryMs) * (0.8 + 0.4 * random);
}

export class Connection {
  #socket: Socket | null = null;
  #seq = 0;
  #attempt = 0;
  #timer: number | null = null;
  #lastHeardMs = 0;
  #stopped = false;
  #refusal = '';

  constructor(private readonly doors: ConnectionDoors) {}

  start(): void {
    this.#stopped = false;
    this.#connect();
  }
  stop(): void {
    this.#stopped = true;
    this.#cancelTimer();
    this.#drop();
  }
  /** Now rather than when the countdown ends; also the way out of `refused`. */
  retryNow(): void {
    if (this.#socket || this.#stopped) return;
    this.#attempt = 0;
    this.#connect();
  }
  /** The server has said why it will not have us; the close that follows is final. */
  refuse(reason: string): void {
    this.#refusal = reason;
  }

  /** The message's seq, or 0 if there is nobody to send it to. number: of a command that may be sent again. */
  send(body: Command, number = 0): number {
    if (!this.#socket || this.#socket.readyState !== 1) return 0;
    this.#seq += 1;
    this.#socket.send(encodeCommand(this.#seq, body, number));
    return this.#seq;
  }

  /** To be called now and then: finds a server that has gone without saying so. */
  checkAlive(): void {
    if (!this.#socket || this.#socket.readyState !== 1) return;
    if (this.doors.now() - this.#lastHeardMs > silenceMs) this.#lost('The server has stopped answering.');
  }

  #connect(): void {
    this.#cancelTimer();
    this.#refusal = '';
    this.doors.onStatus({ kind: 'connecting', attempt: this.#attempt });
    let opened = false;
    const socket = this.doors.open(subprotocol);
    this.#socket = socket;
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      opened = true;
      this.#seq = 0;
      this.#lastHeardMs = this.doors.now();
      this.send(this.doors.hello());
    };
    socket.onmessage = (message) => {
      this.#lastHeardMs = this.doors.now();
      if (!(message.data instanceof ArrayBuffer)) return;
      let event: ServerEvent;
      try {
        event = decodeEvent(new Uint8Array(message.data));
      } catch (problem) {
        this.#lost(`The server sent something that is not a message of this protocol (${String(problem)}).`);
        return;
      }
      if (event.kind === 'welcome') {
        this.#attempt = 0;
        this.doors.onStatus({ kind: 'connected' });
      }
      this.doors.onEvent(event);
    };
    socket.onclose = (close) => {
      if (socket !== this.#socket) return;
      this.#socket = null;
      if (this.#stopped) return;
      if (this.#refusal) this.doors.onStatus({ kind: 'refused', reason: this.#refusal });
      else if (opened) this.#wait(close.reason || 'The connection was lost.');
      else void this.#explain();
    };
  }

  async #explain(): Promise<void> {
    const why = await this.doors.askWhy();
    if (this.#socket || this.#stopped || this.#timer !== null) return;
    if (why.kind === 'refused') this.doors.onStatus(why);
    else this.#wait(why.kind === 'unreachable' ? 'The server cannot be reached.' : 'The server did not open the connection.');
  }

  #wait(reason: string): void {
    this.#cancelTimer();
    const delay = retryDelayMs(this.#attempt, this.doors.random());
    this.#attempt += 1;
    this.doors.onStatus({ kind: 'waiting', attempt: this.#attempt, retryAtMs: this.doors.now() + delay, reason });
    this.#timer = this.doors.setTimeout(() => {
      this.#timer = null;
      this.#connect();
    }, delay);
  }

  #lost(reason: string): void {
    this.#drop();
    this.#wait(reason);
  }
  #drop(): void {
    const socket = this.#socket;
    this.#socket = null;
    socket?.close();
  }
  #cancelTimer(): void {
    if (this.#timer !== null) this.doors.clearTimeout(this.#timer);
    this.#timer = null;
  }
}
