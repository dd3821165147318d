// What can be opened: the list that the server tells and keeps up to date, and the part of it that is looked at.
import { command, type Command } from './commands';
import type { DatasetEntry, DatasetList } from './told';

/** Folders and datasets of one look at the list: what the page has elements for. */
export const listedRows = 100;
const mostKept = 1000;
const restMs = 100; // after news of files, until the part that is looked at is asked for again: news come in swarms

export interface FileListDoors {
  send(body: Command): void;
  after(ms: number, callback: () => void): void;
}

export class FileList {
  /** The first of what can be opened, as far as the server has told; `listing` tells the others. */
  datasets = $state.raw<DatasetEntry[]>([]);
  /** The part of the list that is looked at; null: none is. */
  listing = $state.raw<DatasetList | null>(null);
  #browsing: { folder: string; search: string; first: number } | null = null;
  #asksAgain = false;

  constructor(private readonly doors: FileListDoors) {}

  /** Looks at a part of the list from now on, also when it changes; null: no more. */
  browse(what: { folder: string; search: string; first: number } | null): void {
    this.#browsing = what;
    if (!what) this.listing = null;
    this.askAgain();
  }
  /** As a person reads it, of a dataset or a part of one. */
  nameOf(id: string): string {
    return this.datasets.find((of) => of.id === id.split('@')[0])?.name ?? id;
  }
  /** Those that are there and whole. */
  get whole(): DatasetEntry[] {
    return this.datasets.filter((entry) => entry.news !== 'gone' && !entry.writing);
  }

  welcomed(datasets: DatasetEntry[]): void {
    this.datasets = datasets;
  }
  /** Asks for the part that is looked at, of a server that has not told it yet. */
  askAgain(): void {
    const browsing = this.#browsing;
    if (browsing) this.doors.send(command.listDatasets(browsing.folder, browsing.search, browsing.first, listedRows));
  }
  told(list: DatasetList): void {
    if (this.#browsing) this.listing = list;
  }
  /** These have other news than before. */
  changed(entries: DatasetEntry[]): void {
    const told = new Map(entries.map((entry) => [entry.id, entry]));
    const kept = this.datasets.map((old) => told.get(old.id) ?? old);
    const added = entries.filter((entry) => !this.datasets.some((old) => old.id === entry.id));
    this.datasets = [...kept, ...added].slice(0, mostKept);
    if (!this.#browsing || this.#asksAgain) return;
    this.#asksAgain = true;
    this.doors.after(restMs, () => {
      this.#asksAgain = false;
      this.askAgain();
    });
  }
}
