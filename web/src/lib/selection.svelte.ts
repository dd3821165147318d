// Which layer keys and new edits go to, and which point of its transfer function.
import type { Interval } from './model';

type Layers = readonly Pick<Interval, 'id'>[];

export class Selection {
  layer = $state.raw<number | null>(null);
  /** Of the layer's transfer function, if it has one: the point that the swatch and the fields go to. */
  point = $state.raw(0);
  #adding = false;

  /** The person adds a layer, whose id the server will choose. */
  expectNew(): void {
    this.#adding = true;
  }
  /** The server has these layers now, in place of those. */
  told(before: Layers, now: Layers): void {
    const has = (layers: Layers, id: number) => layers.some((layer) => layer.id === id);
    const added = this.#adding && now.find(({ id }) => !has(before, id));
    if (added) {
      this.layer = added.id;
      this.#adding = false;
    }
    if (this.layer !== null && !has(now, this.layer)) this.layer = null;
  }
}
