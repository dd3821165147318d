// What the person is to be told, and where on the page it belongs.
import type { Command } from './protocol';

export type Place = 'page' | 'dataset' | 'arrays' | 'step' | 'histogram' | 'layers' | 'appearance';

export interface Notice {
  id: number;
  text: string;
  place: Place;
  interval: number | null; // the layer that it is about
  field: string; // as the server names it; empty: none in particular
  tone: 'error' | 'note';
}

/** Where a refused command's message is shown: beside what the person touched. */
export function placeOf(body: Command): { place: Place; interval: number | null } {
  switch (body.case) {
    case 'openDataset':
    case 'reloadDataset':
    case 'listDatasets':
      return { place: 'dataset', interval: null };
    case 'selectArrays':
      return { place: 'arrays', interval: null };
    case 'setTimeStep':
    case 'setTime':
      return { place: 'step', interval: null };
    case 'requestHistogram':
      return { place: 'histogram', interval: null };
    case 'patchInterval':
    case 'removeInterval':
      return { place: 'layers', interval: body.value.id ?? null };
    case 'setIntervals':
    case 'setCombination':
    case 'setCycle':
    case 'setSmear':
    case 'reorderPriorities':
      return { place: 'layers', interval: null };
    case 'setAppearance':
      return { place: 'appearance', interval: null };
    default:
      return { place: 'page', interval: null };
  }
}

export class Notices {
  list = $state.raw<Notice[]>([]);
  private next = 1;

  /** The same words about the same thing replace each other: a drag can be refused sixty times a second. */
  add(notice: Omit<Notice, 'id'>): void {
    const others = this.list.filter((n) => n.text !== notice.text && !(n.interval !== null && n.interval === notice.interval));
    this.list = [...others.slice(-4), { ...notice, id: this.next++ }];
  }
  dismiss(id: number): void {
    this.list = this.list.filter((notice) => notice.id !== id);
  }
  /** The person is at it again: what was said about it is out of date. */
  clear(place: Place, interval: number | null = null): void {
    if (this.list.some((n) => n.place === place && n.interval === interval))
      this.list = this.list.filter((n) => n.place !== place || n.interval !== interval);
  }
}
