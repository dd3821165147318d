// Whether a hand is at something. Interactions overlap: a key is held while a pointer drags.
import { command } from './commands';
import type { Outgoing } from './outgoing';

export class Hand {
  /** What a hand holds is not taken away from under it, whatever the connection does. */
  holds = $state.raw(false);
  #count = 0;
  #grips = 0;

  constructor(private readonly out: Pick<Outgoing, 'send' | 'slots'>) {}

  /** Which of all its grips this is; 0: it holds nothing. */
  get grip(): number {
    return this.#count > 0 ? this.#grips : 0;
  }
  begin(): void {
    this.#set(this.#count + 1);
    if (this.#count !== 1) return;
    this.#grips += 1;
    this.#tell();
  }
  end(): void {
    if (this.#count === 0) return;
    this.#set(this.#count - 1);
    this.out.slots.flush();
    if (this.#count === 0) this.#tell();
  }
  /** What it held is gone: nothing ends any more. */
  empty(): void {
    this.#set(0);
  }
  /** Tells a new connection that a drag goes on under the hand that has not let go. */
  goesOn(): void {
    if (this.holds) this.#tell();
  }

  #set(count: number): void {
    this.#count = count;
    this.holds = count > 0;
  }
  #tell(): void {
    this.out.send(command.interaction(this.holds));
  }
}
