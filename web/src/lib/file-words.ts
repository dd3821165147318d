// What the list of files says: sizes, times and marks in words.
import type { DatasetEntry } from './told';

const units = ['B', 'KB', 'MB', 'GB', 'TB', 'PB'];

/** In powers of 1000, as files are sold: "4.2 MB". */
export function sizeWords(bytes: number): string {
  let value = bytes;
  let unit = 0;
  while (value >= 999.5 && unit + 1 < units.length) {
    value /= 1000;
    unit += 1;
  }
  return `${unit === 0 || value >= 99.5 ? Math.round(value) : value.toPrecision(2).replace(/\.0$/, '')} ${units[unit]}`;
}

/** How long ago, by the same clock. */
export function agoWords(ms: number, nowMs: number): string {
  const minutes = Math.floor((nowMs - ms) / 60_000);
  if (ms <= 0) return '';
  if (minutes < 1) return 'just now';
  if (minutes < 60) return `${minutes} min ago`;
  if (minutes < 24 * 60) return `${Math.floor(minutes / 60)} h ago`;
  if (minutes < 30 * 24 * 60) return `${Math.floor(minutes / (24 * 60))} d ago`;
  return new Date(ms).toISOString().slice(0, 10);
}

const freshMs = 15 * 60_000; // that news are news

/** One word for what happened to a dataset's files lately; empty: nothing. */
export function markOf(entry: DatasetEntry, nowMs: number): string {
  if (entry.news === 'gone') return 'gone';
  if (entry.writing) return 'being written';
  if (entry.news === 'none' || nowMs - entry.noticedMs > freshMs) return '';
  return { appeared: 'new', grown: 'grown', changed: 'changed' }[entry.news];
}

/** "XML VTK · 12 steps · 4.2 MB · 3 min ago", as far as it is known. */
export function factsOf(entry: DatasetEntry, nowMs: number): string {
  const count = entry.steps > 1 ? `${entry.steps.toLocaleString('en')} steps` : entry.files > 1 ? `${entry.files.toLocaleString('en')} slices` : '';
  return [entry.kind, count, entry.bytes > 0 ? sizeWords(entry.bytes) : '', agoWords(entry.changedMs, nowMs)].filter((part) => part !== '').join(' · ');
}

/** Notes of a dataset: what several of its files say is said once, with how often. */
export function timesSaid(notes: readonly string[]): string[] {
  return [...new Set(notes)].map((note) => {
    const times = notes.filter((other) => other === note).length;
    return times > 1 ? `${note} (× ${times})` : note;
  });
}
