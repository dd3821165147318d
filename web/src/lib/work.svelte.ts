// What the server is working on, and which of it the person has cancelled.
import { command, type Command } from './commands';
import type { Done, Progress, Purpose } from './told';

export class Work {
  list = $state.raw<Progress[]>([]);
  readonly #cancelled = new Set<bigint>(); // operations, by this page

  constructor(private readonly send: (body: Command) => void) {}

  cancel(operation: bigint): void {
    this.#cancelled.add(operation);
    this.send(command.cancel(operation));
  }

  told(progress: Progress): void {
    this.list = [...this.#others(progress.operation), progress];
  }
  /** What the work was for, if it was cancelled and the person is to be told. */
  done({ operation, cancelled, superseded }: Done): Purpose | null {
    const purpose = this.list.find((p) => p.operation === operation)?.purpose;
    this.list = this.#others(operation);
    const asked = this.#cancelled.delete(operation);
    if (!cancelled || !purpose) return null;
    // What a newer choice has overtaken is nothing to tell: the newer one is being worked on. Nor are ranges that somebody else has cancelled.
    return asked || (!superseded && purpose !== 'ranges') ? purpose : null;
  }
  lost(): void {
    this.list = [];
    this.#cancelled.clear();
  }

  #others(operation: bigint): Progress[] {
    return this.list.filter((p) => p.operation !== operation);
  }
}
