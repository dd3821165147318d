// Values along a line between two picked places, and over the steps at one: what is asked, what is shown, which end is being picked.
import { command, type Command } from './commands';
import type { SceneState, Vec3 } from './model';
import type { OpenCurve } from './saved-plots';
import type { ProbedCurve } from './told';

export type CurvePlace = { kind: 'line'; from: Vec3; to: Vec3 } | { kind: 'steps'; at: Vec3 };
export type LineEnd = 'from' | 'to';

/** What of a state a curve depends on. Over the steps it depends on the array alone. */
function dependsOn(state: SceneState, place: CurvePlace, array: string): string {
  const of = [array || state.array, state.dataset, array && array !== state.array ? '' : state.values];
  if (place.kind === 'steps') return JSON.stringify(of);
  const layers = state.intervals.map(({ id, lower, upper, visible }) => [id, String(lower), String(upper), visible]);
  return JSON.stringify([...of, state.step, state.time, state.timeMode, state.array, layers, state.terms]);
}

export class Curves {
  place = $state.raw<CurvePlace | null>(null);
  /** Whose values are shown; empty: of the array that the layers are of. */
  array = $state('');
  /** What came last; why there is nothing; null: nothing yet. */
  answer = $state.raw<ProbedCurve | string | null>(null);
  /** Whether an answer is on its way. */
  waits = $state(false);
  /** The end that the next place in the picture becomes. */
  picking = $state<LineEnd | null>(null);
  /** The first end of a line that has no second one yet. */
  start = $state.raw<Vec3 | null>(null);
  #asked = new Set<number>(); // messages that have no answer yet
  #newest = 0;
  #key = ''; // of what has been asked
  #state: SceneState | null = null;
  #data = { reloads: 0, steps: 0 };

  /** changed: another curve is open now, or none. */
  constructor(
    private readonly sendInOrder: (body: Command) => number,
    private readonly changed: () => void = () => {},
  ) {}

  get open(): OpenCurve | null {
    return this.place && { place: this.place, array: this.array };
  }

  show(place: CurvePlace): void {
    if (this.place?.kind !== place.kind) this.answer = null;
    this.place = place;
    this.start = null;
    this.picking = null;
    this.changed();
    this.#ask(true);
  }
  /** As it was open before; not if something is open. */
  restore({ place, array }: OpenCurve): void {
    if (this.place) return;
    this.array = array;
    this.show(place);
  }
  again(): void {
    this.answer = null;
    this.#ask(true);
  }
  ofArray(array: string): void {
    this.array = array;
    this.changed();
    this.#ask(true);
  }
  /** The next place of a layer that is read in the picture becomes this end. */
  pick(end: LineEnd | null): void {
    this.picking = end;
    if (!end) this.start = null;
  }
  /** A line begins at a place that is known. */
  beginAt(from: Vec3): void {
    this.start = from;
    this.picking = 'to';
  }
  picked(at: Vec3): void {
    const end = this.picking;
    if (!end) return;
    const line = this.place?.kind === 'line' && !this.start ? this.place : null;
    if (line) this.show({ ...line, [end]: at });
    else if (end === 'from' || !this.start) this.beginAt(at);
    else this.show({ kind: 'line', from: this.start, to: at });
  }
  close(): void {
    if (this.waits && this.place?.kind === 'steps') this.sendInOrder(command.probeSteps(null, ''));
    this.place = null;
    this.answer = null;
    this.waits = false;
    this.array = '';
    this.#newest = 0;
    this.pick(null);
    this.changed();
  }
  told(state: SceneState): void {
    const gone = this.#state !== null && this.#state.dataset !== state.dataset;
    this.#state = state;
    if (gone) this.close();
    else this.#ask(false);
  }
  /** How often the files have been read anew, and how many steps they have. */
  dataTold(reloads: number, steps: number): void {
    this.#data = { reloads, steps };
    this.#ask(false);
  }
  /** Whether the message has asked for a curve. */
  answered(seq: number, answer: ProbedCurve | string): boolean {
    if (!this.#asked.delete(seq)) return false;
    if (seq !== this.#newest) return true;
    this.waits = false;
    this.answer = answer;
    this.#ask(false); // what has changed meanwhile
    return true;
  }
  lost(): void {
    this.#asked.clear();
    this.waits = false;
    this.#key = '';
    this.pick(null);
  }

  #ask(anew: boolean): void {
    const { place } = this;
    if (!place || !this.#state || (this.waits && !anew)) return;
    const { reloads, steps } = this.#data;
    const key = `${dependsOn(this.#state, place, this.array)} ${reloads} ${place.kind === 'steps' ? steps : ''}`;
    if (!anew && key === this.#key) return;
    this.#key = key;
    const seq = this.sendInOrder(
      place.kind === 'line' ? command.probeLine(place.from, place.to, this.array) : command.probeSteps(place.at, this.array || this.#state.array),
    );
    this.#newest = seq;
    this.waits = seq !== 0;
    if (seq) this.#asked.add(seq);
    else this.answer = 'There is no connection.';
  }
}
