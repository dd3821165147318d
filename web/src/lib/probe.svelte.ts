// What lies at a place of the picture: asked for with a click, shown until it is closed or the camera moves, and asked for again when the layers change.
import { command, type Command } from './commands';
import type { Camera } from './model';
import type { ProbeResult } from './told';

export interface Probed {
  /** In [0, 1], from the picture's upper left corner. */
  x: number;
  y: number;
  /** What is there; or why that is not known; null: nobody has answered yet. */
  answer: ProbeResult | string | null;
}

const numbersOf = ({ eye, at, up, fovDeg, orthographic }: Camera) => [...eye, ...at, ...up, fovDeg, orthographic ? 1 : 0];
const same = (a: Camera, b: Camera) => numbersOf(a).every((value, i) => value === numbersOf(b)[i]);

export class Probe {
  shown = $state.raw<Probed | null>(null);
  #camera: Camera | null = null; // that it was seen from
  #asked = new Set<number>(); // messages that have no answer yet
  #newest = 0;

  constructor(private readonly sendInOrder: (body: Command) => number) {}

  /** camera: as the person sees the picture now. */
  ask(x: number, y: number, camera: Camera | null): void {
    this.#camera = camera;
    this.shown = { x, y, answer: null };
    this.#send(x, y);
  }
  close(): void {
    this.shown = null;
    this.#newest = 0;
  }
  /** The picture is seen from there. A place in another picture is another place. */
  seenFrom(camera: Camera | null): void {
    if (this.shown && this.#camera && camera && !same(camera, this.#camera)) this.close();
  }
  /** The state has this revision now: what was said of an older one may be wrong. */
  stateTold(revision: number): void {
    const { shown } = this;
    if (shown?.answer && (typeof shown.answer === 'string' || shown.answer.revision < revision)) this.#send(shown.x, shown.y);
  }
  /** Whether the message has asked for a place. An answer that came late is not shown. */
  answer(seq: number, answer: ProbeResult | string): boolean {
    if (!this.#asked.delete(seq)) return false;
    if (this.shown && seq === this.#newest) this.shown = { ...this.shown, answer };
    return true;
  }
  lost(): void {
    this.#asked.clear();
    this.close();
  }

  #send(x: number, y: number): void {
    const seq = this.sendInOrder(command.probePoint(x, y));
    this.#newest = seq;
    if (seq) this.#asked.add(seq);
    else if (this.shown) this.shown = { ...this.shown, answer: 'There is no connection.' };
  }
}
