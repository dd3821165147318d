// Pictures for keeping: each goes to whoever asked for it, and is not shown.
import { command, type Command } from './commands';
import type { Annotations } from './model';
import type { Frame } from './told';

export class Stills {
  readonly #asked = new Map<number, (answer: Frame | string) => void>(); // by the message that asked

  constructor(private readonly sendInOrder: (body: Command) => number) {}

  /** A lossless picture of this size and with these annotations, with the background or without; or why there is none. */
  ask(width: number, height: number, annotations: Annotations, transparent = false): Promise<Frame | string> {
    return new Promise((resolve) => {
      const seq = this.sendInOrder(command.requestStill(width, height, annotations, transparent));
      if (seq) this.#asked.set(seq, resolve);
      else resolve('There is no connection.');
    });
  }
  /** Whether the message asked for a picture, which then has its answer. */
  answer(seq: number, answer: Frame | string): boolean {
    this.#asked.get(seq)?.(answer);
    return this.#asked.delete(seq);
  }
  lost(): void {
    for (const resolve of this.#asked.values()) resolve('The connection was lost before the picture came.');
    this.#asked.clear();
  }
}
