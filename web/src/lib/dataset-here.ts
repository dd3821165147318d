// Which dataset a view is of that was saved elsewhere.
import type { DatasetEntry } from './told';

/** An id ends in a number made of the file's whole path, which is another one on another machine. */
const stem = (id: string) => id.replace(/@.*$/, '').replace(/-[0-9a-f]{6}(-\d+)?(~\d+)?$/, '');

/** The dataset of a view, among those that can be opened here: itself, else the one that has its file's name, if there is just one. */
export function datasetHere(id: string, datasets: readonly Pick<DatasetEntry, 'id' | 'name'>[], open: string): Pick<DatasetEntry, 'id' | 'name'> | null {
  const same = (entry: { id: string }) => entry.id === id.replace(/@.*$/, '');
  const alike = datasets.filter((entry) => stem(entry.id) === stem(id));
  return datasets.find(same) ?? alike.find((entry) => entry.id === open) ?? (alike.length === 1 ? (alike[0] ?? null) : null);
}
