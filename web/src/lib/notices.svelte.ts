// What the person is to be told, and where on the page it belongs.
import type { Command } from './commands';

export type Place = 'page' | 'dataset' | 'arrays' | 'step' | 'histogram' | 'layers' | 'appearance';

export interface Notice {
  id: number;
  text: string;
  place: Place;
  interval: number | null; // the layer that it is about
  field: string; // as the server names it; empty: none in particular
  tone: 'error' | 'note';
  action?: { label: string; run(): void }; // what can be done about it
}

const places: Partial<Record<NonNullable<Command['case']>, Place>> = {
  openDataset: 'dataset',
  reloadDataset: 'dataset',
  listDatasets: 'dataset',
  selectArrays: 'arrays',
  setTimeStep: 'step',
  setTime: 'step',
  requestHistogram: 'histogram',
  patchInterval: 'layers',
  removeInterval: 'layers',
  setIntervals: 'layers',
  setCombination: 'layers',
  setCycle: 'layers',
  setSmear: 'layers',
  reorderPriorities: 'layers',
  setAppearance: 'appearance',
};

/** Where a refused command's message is shown: beside what the person touched. */
export function placeOf(body: Command): { place: Place; interval: number | null } {
  const interval = body.case === 'patchInterval' || body.case === 'removeInterval' ? (body.value.id ?? null) : null;
  return { place: (body.case && places[body.case]) ?? 'page', interval };
}

export class Notices {
  list = $state.raw<Notice[]>([]);
  #next = 1;

  /** The same words about the same thing replace each other: a drag can be refused sixty times a second. */
  add(notice: Omit<Notice, 'id'>): void {
    const others = this.list.filter((n) => n.text !== notice.text && !(n.interval !== null && n.interval === notice.interval));
    this.list = [...others.slice(-4), { ...notice, id: this.#next++ }];
  }
  say(text: string, tone: Notice['tone'] = 'error', place: Place = 'page', action?: Notice['action']): void {
    this.add({ text, place, interval: null, field: '', tone, ...(action ? { action } : {}) });
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
