// One layer in numbers: asked for by a button, and kept until it is asked for again. What it was of is kept beside it.
import { asInFile } from './axes';
import { command, type Command } from './commands';
import { diagonal } from './camera';
import { row } from './curve-shape';
import type { Interval, SceneState, Vec3 } from './model';
import type { DatasetInfo, LayerStatistics } from './told';

export interface Measured {
  /** In the array that was asked for; why it is not known; null: nobody has answered yet. */
  answer: LayerStatistics | string | null;
  array: string; // that was asked for; empty: the layers'
  key: string; // of what it was measured of
}

/** What a layer's numbers depend on. */
export function measureKey(scene: SceneState, interval: Interval, array: string, reloads = 0): string {
  return JSON.stringify([
    scene.dataset, reloads, scene.array, scene.values, scene.step, scene.time, scene.timeMode, scene.terms, interval.id, String(interval.lower), String(interval.upper), array || scene.array,
  ]);
}

export class Measures {
  /** By the layers' ids. */
  list = $state.raw<ReadonlyMap<number, Measured>>(new Map());
  readonly #asked = new Map<number, number>(); // the layer that a message has asked of
  /** Layers to be asked of. The server answers one question of a connection: a newer one ends the one before. */
  #waiting: { layer: number; array: string }[] = [];

  /** changed: numbers of another layer or array are open now, or fewer. */
  constructor(
    private readonly sendInOrder: (body: Command) => number,
    private readonly changed: () => void = () => {},
  ) {}

  get open(): [id: number, array: string][] {
    return [...this.list].map(([id, { array }]) => [id, array]);
  }

  /** reloads: how often the data have been read anew. */
  ask(scene: SceneState, interval: Interval, array: string, reloads = 0): void {
    this.#set(interval.id, { answer: null, array, key: measureKey(scene, interval, array, reloads) });
    this.#forget(interval.id);
    this.#waiting.push({ layer: interval.id, array });
    this.#goOn();
    this.changed();
  }
  /** As they were open before: what has no answer is asked for, again if the connection took it. */
  restore(scene: SceneState, open: readonly [id: number, array: string][], reloads = 0): void {
    for (const [id, array] of open) {
      const interval = scene.intervals.find((of) => of.id === id);
      if (interval && !this.list.get(id)?.answer) this.ask(scene, interval, array, reloads);
    }
  }
  close(interval: number): void {
    this.#forget(interval);
    this.#set(interval, null);
    this.changed();
  }
  /** Whether the message has asked for a layer's numbers. */
  answered(seq: number, answer: LayerStatistics | string): boolean {
    const interval = this.#asked.get(seq);
    if (interval === undefined) return false;
    this.#asked.delete(seq);
    const of = this.list.get(interval);
    // Another question of the same layer may be on its way.
    if (of && ![...this.#asked.values(), ...this.#waiting.map(({ layer }) => layer)].includes(interval)) this.#set(interval, { ...of, answer });
    this.#goOn();
    return true;
  }
  lost(): void {
    this.#asked.clear();
    this.#waiting = [];
  }
  /** Another session, another dataset: other layers. */
  clear(): void {
    this.lost();
    this.list = new Map();
  }

  #forget(interval: number): void {
    this.#waiting = this.#waiting.filter(({ layer }) => layer !== interval);
  }
  /** The next question, unless another layer's has no answer yet. */
  #goOn(): void {
    const next = this.#waiting.find(({ layer }) => [...this.#asked.values()].every((asked) => asked === layer));
    if (!next) return;
    this.#forget(next.layer);
    const seq = this.sendInOrder(command.requestLayerStatistics(next.layer, next.array));
    if (seq) this.#asked.set(seq, next.layer);
    else this.#set(next.layer, { ...this.list.get(next.layer)!, answer: 'There is no connection.' });
  }
  #set(interval: number, of: Measured | null): void {
    const list = new Map(this.list);
    if (of) list.set(interval, of);
    else list.delete(interval);
    this.list = list;
  }
}

type Space = Pick<DatasetInfo, 'bounds' | 'axes'>;

/** As the file counts, without what rounding leaves of a 0 in data of this extent. */
export function centroidOf({ centroid }: LayerStatistics, info?: Space | null): Vec3 {
  const least = info?.bounds ? 1e-12 * diagonal(info.bounds) : 0;
  return centroid.map((at, axis) => (Math.abs(at) < least ? 0 : asInFile(info?.axes, axis, at))) as unknown as Vec3;
}

/** Lines of a name, a tab, and values in all their digits: what a table takes. */
export function statisticsText(of: LayerStatistics, layer: string, info?: Space | null): string {
  const size = of.flat ? 'area' : 'volume';
  const lines: [string, ...(string | number)[]][] = [
    ['layer', layer],
    [size, of.volume],
    ['centroid', ...centroidOf(of, info)],
    ['pieces', of.pieces],
    [`${size} of the largest piece`, of.largest],
    ['array', of.array],
  ];
  if (of.valued > 0) lines.push(['mean', of.mean], ['standard deviation', of.standardDeviation], ['least', of.lower], ['greatest', of.upper]);
  if (of.valued < of.volume * (1 - 1e-9)) lines.push([`${size} with values`, of.valued]);
  return lines.map((line) => line.join('\t')).join('\n');
}

const columns = ['layer', 'lower end', 'upper end', 'array', 'mean', 'standard deviation', 'least', 'greatest', 'volume or area', 'with values', 'centroid x', 'centroid y', 'centroid z', 'pieces', 'largest piece'];

/** The same of several layers as a table with commas, a row for each. */
export function statisticsTable(layers: readonly { name: string; lower: number; upper: number; of: LayerStatistics }[], info?: Space | null): string {
  const rows = layers.map(({ name, lower, upper, of }) => {
    const moments = of.valued > 0 ? [of.mean, of.standardDeviation, of.lower, of.upper] : ['', '', '', ''];
    const centroid = of.pieces > 0 ? centroidOf(of, info) : ['', '', ''];
    return row([name, lower, upper, of.array, ...moments, of.volume, of.valued, ...centroid, of.pieces, of.largest]);
  });
  return [row(columns), ...rows, ''].join('\r\n');
}
