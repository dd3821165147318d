// Commands that the server may not have, each with a number of this page's own, so that after a loss what is missing is sent again and what the
// session has done already is not done twice: Welcome.last_command tells which of the two a command is. What happens while there is no
// connection waits here too.
import type { Command } from './commands';

export interface LoggedCommand {
  number: number;
  body: Command;
  /** Of a patch: the number of the command that each field was last said by. */
  fields: Record<string, number>;
  /** When it was last given to a connection; null: never. */
  sentMs: number | null;
}

/** What changes the session. Everything else concerns one connection, or is asked anew by itself. */
const kept = new Set<Command['case']>([
  'openDataset',
  'selectArrays',
  'setTimeStep',
  'setTime',
  'setIntervals',
  'patchInterval',
  'removeInterval',
  'reorderPriorities',
  'setCamera',
  'setView',
  'setAppearance',
  'setCombination',
  'setCycle',
  'setSmear',
  'setTransferFunction',
  'setClipPlanes',
  'setAnnotations',
]);

/** Of which only the newest counts, since they come in streams and each says the whole of what it is about. */
function slotOf({ case: name, value }: Command): string {
  switch (name) {
    case 'setCamera':
      return name;
    case 'patchInterval':
      return `${name} ${value.id}`;
    case 'setTimeStep':
    case 'setTime':
    case 'setCycle':
    case 'setSmear':
    case 'setClipPlanes':
    case 'setCombination':
    case 'setAppearance':
      return `${name} ${Object.keys(value).sort().join()}`;
    default:
      return '';
  }
}

const fieldsOf = (body: Command): string[] =>
  body.case === 'patchInterval' ? Object.keys(body.value).filter((field) => field !== 'id') : [];
const onlyFields = (body: Command, wanted: (field: string) => boolean): Command =>
  body.case === 'patchInterval'
    ? { case: body.case, value: Object.fromEntries(Object.entries(body.value).filter(([field]) => field === 'id' || wanted(field))) }
    : body;

/** One patch that does what both do, one after the other. */
function merged(older: Command, newer: Command): Command {
  if (older.case !== 'patchInterval' || newer.case !== 'patchInterval') return newer;
  const value = { ...older.value, ...newer.value };
  if ('opacityUpper' in newer.value) delete value.clearOpacityUpper;
  if (newer.value.clearOpacityUpper) delete value.opacityUpper;
  return { case: 'patchInterval', value } as Command;
}

export class CommandLog {
  #list: LoggedCommand[] = []; // their numbers grow
  #last = 0;

  /**
   * most: commands that are kept; the oldest goes first. keepMs: that one is kept although the server has it, since a server that is killed may
   * not have written it down yet.
   */
  constructor(
    private readonly most = 200,
    private readonly keepMs = 5000,
  ) {}

  static keeps(body: Command): boolean {
    return kept.has(body.case);
  }

  /** Gives the command its number. What is kept may be more than `body`, which alone is what a connection that stands needs. */
  add(body: Command): LoggedCommand {
    const slot = slotOf(body);
    const number = ++this.#last;
    const logged: LoggedCommand = { number, body, fields: {}, sentMs: null };
    // A command of another kind in between may depend on the older one, which then stays before it.
    for (let i = this.#list.length - 1; slot && i >= 0; i--) {
      const older = this.#list[i] as LoggedCommand;
      const its = slotOf(older.body);
      if (!its) break;
      if (its !== slot) continue;
      logged.body = merged(older.body, body);
      logged.fields = older.fields;
      this.#list.splice(i, 1);
      break;
    }
    for (const field of fieldsOf(body)) logged.fields[field] = number;
    this.#list.push(logged);
    if (this.#list.length > this.most) this.#list.shift();
    return logged;
  }

  /** The session goes on and has judged everything up to this number: what is left to send, in order. */
  missing(lastCommand: number): LoggedCommand[] {
    this.#list = this.#list.filter((logged) => logged.number > lastCommand);
    // Somebody else may have changed since what has arrived.
    for (const logged of this.#list) logged.body = onlyFields(logged.body, (field) => (logged.fields[field] ?? 0) > lastCommand);
    return [...this.#list];
  }

  /** The server has answered a message of that time, so it has everything that was sent before. `unsettled`: what it may still be about. */
  heard(sentMs: number, unsettled: (body: Command) => boolean): void {
    const open = this.#list.findIndex((logged) => unsettled(logged.body));
    this.#list = this.#list.filter(
      (logged, i) => (open >= 0 && i >= open) || logged.sentMs === null || logged.sentMs + this.keepMs > sentMs,
    );
  }
  /** It will never be done. */
  refused(number: number): void {
    this.#list = this.#list.filter((logged) => logged.number !== number);
  }
  clear(): void {
    this.#list = [];
  }
  get length(): number {
    return this.#list.length;
  }
}

/** A name of this page among all that ever come to the session. Not kept over a reload: two tabs may be copies of one. */
export function randomClientId(): string {
  // Not randomUUID, which only secure contexts have.
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, '0')).join('');
}
