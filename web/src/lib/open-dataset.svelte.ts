// What the server says of the dataset that is open: its description, and the histogram of the array that is shown.
import { command, type Command } from './commands';
import type { Range, SceneState } from './model';
import type { ArrayInfo, DatasetInfo, Histogram } from './told';

const histogramBins = 256;

/** Of whole numbers each bin holds as many: with other bins every so often one would be empty. */
function binsOf(array: ArrayInfo, whole: boolean): number {
  const { lower, upper } = (whole && array.cells) || array;
  const numbers = upper - lower + 1;
  const averaged = array.association !== 'point' && !whole;
  if (averaged || !/^u?int/.test(array.type) || !(numbers >= 2)) return histogramBins;
  return Math.ceil(numbers / Math.ceil(numbers / histogramBins));
}

export class OpenDataset {
  info = $state.raw<DatasetInfo | null>(null);
  histogram = $state.raw<Histogram | null>(null);
  /** Why the histogram of what is shown does not come; empty: it is there, or on its way. */
  uncounted = $state('');
  /** How often its files have been read anew. */
  reloads = $state(0);
  #before: DatasetInfo | null = null; // as it was until its files were read anew
  #asked = ''; // which histogram
  #message = 0; // that asked for it

  /** info: null of a server that describes the dataset only once it has opened it again. In a session that goes on that is the same one. */
  welcomed(info: DatasetInfo | null, dataset: string, resumed: boolean): void {
    this.#asked = '';
    if (!resumed) this.histogram = null;
    this.info = info ?? (resumed && this.info?.id === dataset ? this.info : null);
  }
  /** To be written after a value of the array: " K", or nothing. */
  unit(array: string): string {
    const unit = this.info?.arrays.find((of) => of.name === array)?.unit;
    return unit ? ` ${unit}` : '';
  }
  /** How many time steps have come since it was described last. */
  told(info: DatasetInfo): number {
    const before = this.info;
    this.info = info;
    const changed = before?.id === info.id && before.onDisk === 'changed';
    if (changed && info.onDisk !== 'changed') {
      this.reloads++;
      this.#before = before.missingRangeSteps ? null : before;
    }
    return before && before.id === info.id && !changed ? Math.max(info.times.length - before.times.length, 0) : 0;
  }
  /** Once after its files have been read anew: the range that the array's values had, if they have another one now. */
  rangeBefore(array: string): Range | null {
    const { info } = this;
    const before = this.#before;
    if (!before || info?.missingRangeSteps) return null; // until all steps are read
    this.#before = null;
    const [was, is] = [before, info].map((of) => of?.arrays.find(({ name }) => name === array));
    return before.id === info?.id && was && is && (was.lower !== is.lower || was.upper !== is.upper) ? was : null;
  }
  toldHistogram(histogram: Histogram): void {
    this.histogram = histogram;
  }
  /** The session has turned to this dataset. */
  turnedTo(dataset: string): void {
    if (this.info?.id !== dataset) this.info = null;
    this.#message = 0;
    this.uncounted = '';
  }

  /** Asks for the histogram of what is shown, unless that has been asked for already. */
  wants({ dataset, step, array, values }: SceneState, again = false): Command | null {
    if (!dataset || !array || this.info?.id !== dataset) return null;
    // Its bins span the array's range, which grows while the steps of a series are read.
    const range = this.info.arrays.find((of) => of.name === array);
    const wanted = JSON.stringify([dataset, step, array, range?.lower, range?.upper, values, this.reloads]);
    if (wanted === this.#asked && !again) return null;
    this.#asked = wanted;
    this.uncounted = '';
    return command.requestHistogram(array, range ? binsOf(range, values === 'whole') : histogramBins);
  }
  sent(message: number): void {
    this.#message = message;
  }
  /** A message that asked for a histogram is refused. If that was of what is shown now, the next State asks again, unless somebody has cancelled it. */
  refused(message: number, why: string, cancelled: boolean): void {
    if (message !== this.#message) return;
    if (!cancelled) this.#asked = '';
    this.uncounted = why;
  }
}
