// What can be undone and redone, as a text that a tab remembers over a reload. JSON has neither maps nor infinities.
import { isState } from './restore';

const mostLetters = 300_000; // of the few millions that a browser gives to a page

export interface SavedSteps {
  undo: readonly unknown[];
  redo: readonly unknown[];
}

function put(_: string, value: unknown): unknown {
  if (value instanceof Map) return { $map: [...value] };
  return typeof value === 'number' && !Number.isFinite(value) ? { $number: String(value) } : value;
}
function take(_: string, value: unknown): unknown {
  if (typeof value !== 'object' || value === null) return value;
  if ('$map' in value) return new Map(value.$map as [unknown, unknown][]);
  return '$number' in value ? Number(value.$number) : value;
}

/** As many of the newest steps as there is room for; none: an empty text. */
export function stepsText({ undo, redo }: SavedSteps): string {
  for (let [first, last] = [0, redo.length]; first < undo.length || last > 0; first = Math.ceil((first + undo.length) / 2), last = Math.floor(last / 2)) {
    // The last of `redo` is the next; what could come behind those that are left out is nothing without them.
    const text = JSON.stringify({ undo: undo.slice(first), redo: redo.slice(redo.length - last) }, put);
    if (text.length <= mostLetters) return text;
  }
  return '';
}

/** Null if it is not such a text: what was stored is not trusted. */
export function parseSteps(text: string | null): SavedSteps | null {
  if (!text) return null;
  const maps = (of: Record<string, unknown>, ...names: string[]) => names.every((name) => of[name] instanceof Map);
  const good = (step: unknown): boolean => {
    const changes = (step as { changes?: Record<string, unknown> } | null)?.changes;
    const turn = (step as { turn?: { before: unknown; after: unknown; to: unknown } } | null)?.turn;
    if (turn && !(isState(turn.before) && (turn.after === null || isState(turn.after)) && typeof turn.to === 'string')) return false;
    return !!changes && maps(changes, 'scene', 'fields', 'layers') && !!changes.listed && !!changes.ranked;
  };
  try {
    const { undo, redo } = JSON.parse(text, take) as SavedSteps;
    return undo.every(good) && redo.every(good) ? { undo, redo } : null;
  } catch {
    return null;
  }
}
