// What the server is working on, and which of it the person has cancelled.
import { command, type Command } from './commands';
import type { Done, Progress } from './told';

/** What a cancellation leaves that the person is to be told of: the last finished picture, or the ranges of the steps that were read. */
export type Left = 'picture' | 'ranges' | null;

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
  done({ operation, cancelled, superseded }: Done): Left {
    const background = this.list.some((p) => p.operation === operation && p.background);
    this.list = this.#others(operation);
    const asked = this.#cancelled.delete(operation);
    if (!cancelled) return null;
    if (background) return asked ? 'ranges' : null;
    // What a newer choice has overtaken is nothing to tell: the newer one is being worked on.
    return asked || !superseded ? 'picture' : null;
  }
  lost(): void {
    this.list = [];
    this.#cancelled.clear();
  }

  #others(operation: bigint): Progress[] {
    return this.list.filter((p) => p.operation !== operation);
  }
}
