// One layer in numbers: asked for by a button, and kept until it is asked for again. What it was of is kept beside it.
import { command, type Command } from './commands';
import type { Interval, SceneState } from './model';
import type { LayerStatistics } from './told';

export interface Measured {
  /** In the array that was asked for; why it is not known; null: nobody has answered yet. */
  answer: LayerStatistics | string | null;
  array: string; // that was asked for; empty: the layers'
  key: string; // of what it was measured of
}

/** What a layer's numbers depend on. */
export function measureKey(scene: SceneState, interval: Interval, array: string): string {
  return JSON.stringify([
    scene.dataset, scene.array, scene.values, scene.step, scene.time, scene.timeMode, scene.terms, interval.id, String(interval.lower), String(interval.upper), array || scene.array,
  ]);
}

export class Measures {
  /** By the layers' ids. */
  list = $state.raw<ReadonlyMap<number, Measured>>(new Map());
  readonly #asked = new Map<number, number>(); // the layer that a message has asked of

  constructor(private readonly sendInOrder: (body: Command) => number) {}

  ask(scene: SceneState, interval: Interval, array: string): void {
    const seq = this.sendInOrder(command.requestLayerStatistics(interval.id, array));
    if (seq) this.#asked.set(seq, interval.id);
    this.#set(interval.id, { answer: seq ? null : 'There is no connection.', array, key: measureKey(scene, interval, array) });
  }
  close(interval: number): void {
    this.#set(interval, null);
  }
  /** Whether the message has asked for a layer's numbers. */
  answered(seq: number, answer: LayerStatistics | string): boolean {
    const interval = this.#asked.get(seq);
    if (interval === undefined) return false;
    this.#asked.delete(seq);
    const of = this.list.get(interval);
    // Another question of the same layer may be on its way.
    if (of && ![...this.#asked.values()].includes(interval)) this.#set(interval, { ...of, answer });
    return true;
  }
  lost(): void {
    this.#asked.clear();
    for (const [interval, of] of this.list) if (!of.answer) this.#set(interval, { ...of, answer: 'The connection was lost before the numbers came.' });
  }

  #set(interval: number, of: Measured | null): void {
    const list = new Map(this.list);
    if (of) list.set(interval, of);
    else list.delete(interval);
    this.list = list;
  }
}

/** Lines of a name, a tab, and values in all their digits: what a table takes. */
export function statisticsText(of: LayerStatistics, layer: string): string {
  const size = of.flat ? 'area' : 'volume';
  const lines: [string, ...(string | number)[]][] = [
    ['layer', layer],
    [size, of.volume],
    ['centroid', ...of.centroid],
    ['pieces', of.pieces],
    [`${size} of the largest piece`, of.largest],
    ['array', of.array],
  ];
  if (of.valued > 0) lines.push(['mean', of.mean], ['standard deviation', of.standardDeviation], ['least', of.lower], ['greatest', of.upper]);
  if (of.valued < of.volume * (1 - 1e-9)) lines.push([`${size} with values`, of.valued]);
  return lines.map((line) => line.join('\t')).join('\n');
}
