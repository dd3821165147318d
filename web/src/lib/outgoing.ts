// What goes out: of what a hand drags the newest value, once for each picture of the screen; of what changes the session everything, until the
// session has judged it. Remembers what each message is about, since the refusal that may come names only its number.
import { CommandLog, type LoggedCommand } from './command-log';
import { command, type Command } from './commands';
import { placeOf, type Place } from './notices.svelte';
import { CameraCredits, Outbox } from './pacing';

export interface OutgoingDoors {
  /** The message's seq, or 0 if there is nobody to send it to. number: of a command that may be sent again. */
  send(body: Command, number: number): number;
  now(): number;
  /** Calls back once before the next picture of the screen. */
  schedule(callback: () => void): void;
}

interface About {
  place: Place;
  interval: number | null;
  command: number; // its number, if it may be sent again
}

const remembered = 1000; // messages: a refusal comes long before so many others have gone out

export class Outgoing {
  /** Welcomed, on a connection that still is. */
  live = false;
  /** Of what comes in streams: the next picture of the screen sends the newest of each slot. */
  readonly slots: Outbox;
  readonly #log = new CommandLog();
  readonly #credits = new CameraCredits();
  readonly #about = new Map<number, About>();
  #openings: number[] = []; // the newest messages that open a dataset

  constructor(private readonly doors: OutgoingDoors) {
    this.slots = new Outbox({
      sendCamera: (camera) => {
        const seq = this.send(command.setCamera(camera));
        if (seq) this.#credits.sent(seq, doors.now());
      },
      sendPatch: (id, patch) => this.send(command.patchInterval(id, patch)),
      sendOther: (_slot, body) => this.send(body as Command),
      cameraMayGo: () => this.#credits.open(doors.now()),
      schedule: doors.schedule,
    });
  }

  /** The message's seq, or 0 if it cannot go out now; what changes the session then goes out when it can. */
  send(body: Command): number {
    if (CommandLog.keeps(body)) return this.#transmit(this.#log.add(body), body);
    return this.live ? this.#note(this.doors.send(body, 0), body, 0) : 0;
  }
  /** After everything that waits in a slot, so that the server sees things in the order in which they were done. */
  sendInOrder(body: Command): number {
    this.slots.flush();
    return this.send(body);
  }

  /** A connection stands. To another session nothing goes that was meant for the old one. */
  welcomed(resumed: boolean): void {
    this.live = true;
    if (resumed) return;
    this.slots.drop();
    this.#log.clear();
  }
  /** The session has judged the commands up to this one; the others go out again. */
  resend(lastCommand: number): void {
    for (const logged of this.#log.missing(lastCommand)) this.#transmit(logged);
  }
  lost(): void {
    this.live = false;
    this.#about.clear();
    this.#openings = [];
    this.#credits.reset();
  }

  /** A frame has come that contains every input up to `seq`. */
  answered(seq: number): void {
    this.#credits.answered(seq);
  }
  /** The server has answered a ping of that time. `dataset`: which it has open. */
  heard(sentMs: number, dataset: string): void {
    this.#log.heard(sentMs, (body) => body.case === 'openDataset' && body.value.id !== dataset);
  }
  /** Whether the message was to open a dataset in whose place another one has been chosen since. */
  overtaken(seq: number): boolean {
    return this.#openings.includes(seq) && seq !== this.#openings.at(-1);
  }
  /** The message is refused: it is not tried again. What it was about. */
  refused(seq: number): Omit<About, 'command'> {
    const { command: number, ...about } = this.#about.get(seq) ?? { place: 'page', interval: null, command: 0 };
    if (number) this.#log.refused(number);
    return about;
  }

  #transmit(logged: LoggedCommand, body = logged.body): number {
    if (!this.live) return 0;
    const seq = this.doors.send(body, logged.number);
    if (seq) logged.sentMs = this.doors.now();
    return this.#note(seq, body, logged.number);
  }
  #note(seq: number, body: Command, number: number): number {
    if (seq) {
      this.#about.set(seq, { ...placeOf(body), command: number });
      if (body.case === 'openDataset') this.#openings = [...this.#openings.slice(-99), seq];
      this.#about.delete(seq - remembered);
    }
    return seq;
  }
}
