// What the person has just done, laid over what the server last said. The server's State has the last word: a local value goes as soon as
// the State says the same, when the server refuses the command, or when the State still differs a while after it was sent.
import type { Interval, IntervalPatch, SceneState } from './model';

interface Pending<T> {
  value: T;
  sinceMs: number;
}

type Field = keyof IntervalPatch;
/** Everything of the state but its revision and its intervals can be changed at once. */
export type Overlay = Partial<Omit<SceneState, 'revision' | 'intervals'>>;

export class OptimisticState {
  #fields = new Map<number, Map<Field, Pending<unknown>>>();
  #whole = new Map<keyof Overlay, Pending<unknown>>();
  #removed = new Map<number, number>();
  #order: Pending<number[]> | null = null;

  constructor(private readonly patienceMs = 2000) {}

  patch(id: number, patch: IntervalPatch, nowMs: number): void {
    const fields = this.#fields.get(id) ?? new Map<Field, Pending<unknown>>();
    for (const [field, value] of Object.entries(patch)) fields.set(field as Field, { value, sinceMs: nowMs });
    this.#fields.set(id, fields);
  }
  set(overlay: Overlay, nowMs: number): void {
    for (const [key, value] of Object.entries(overlay)) this.#whole.set(key as keyof Overlay, { value, sinceMs: nowMs });
  }
  /** The server is asked to choose this itself. */
  forget(key: keyof Overlay): void {
    this.#whole.delete(key);
  }
  remove(id: number, nowMs: number): void {
    this.#removed.set(id, nowMs);
    this.#fields.delete(id);
  }
  reorder(ids: readonly number[], nowMs: number): void {
    this.#order = { value: [...ids], sinceMs: nowMs };
  }
  /** The server refused a command about this interval, or about the state as a whole. */
  refuse(id?: number): void {
    if (id === undefined) {
      this.#whole.clear();
      this.#order = null;
      return;
    }
    this.#fields.delete(id);
    this.#removed.delete(id);
  }
  clear(): void {
    this.#fields.clear();
    this.#whole.clear();
    this.#removed.clear();
    this.#order = null;
  }

  /** Whether the view differs from the server's last word, or may. */
  get waits(): boolean {
    return this.#fields.size + this.#whole.size + this.#removed.size > 0 || this.#order !== null;
  }

  /** Nobody could answer so far: all of it has its whole patience again. */
  renew(nowMs: number): void {
    for (const fields of this.#fields.values()) for (const pending of fields.values()) pending.sinceMs = nowMs;
    for (const pending of this.#whole.values()) pending.sinceMs = nowMs;
    for (const id of this.#removed.keys()) this.#removed.set(id, nowMs);
    if (this.#order) this.#order.sinceMs = nowMs;
  }

  /** Compares with a new State and forgets what it has caught up with, or what has been waiting too long. */
  settle(state: SceneState, nowMs: number): void {
    const over = (p: Pending<unknown>) => nowMs - p.sinceMs > this.patienceMs;
    for (const [id, fields] of this.#fields) {
      const interval = state.intervals.find((i) => i.id === id);
      if (!interval) {
        this.#fields.delete(id);
        continue;
      }
      for (const [field, pending] of fields)
        if (same(interval[field], pending.value) || over(pending)) fields.delete(field);
      if (fields.size === 0) this.#fields.delete(id);
    }
    // Opening a dataset may take minutes: it ends with a State, a refusal or a cancellation, not with time.
    for (const [key, pending] of this.#whole)
      if (same(state[key], pending.value) || (key !== 'dataset' && over(pending))) this.#whole.delete(key);
    for (const [id, sinceMs] of this.#removed)
      if (!state.intervals.some((i) => i.id === id) || nowMs - sinceMs > this.patienceMs) this.#removed.delete(id);
    if (this.#order && (over(this.#order) || this.#matches(state, this.#order.value))) this.#order = null;
  }

  /** The state as the page shows it. */
  view(state: SceneState): SceneState {
    const whole = Object.fromEntries([...this.#whole].map(([key, pending]) => [key, pending.value]));
    let intervals: Interval[] = state.intervals
      .filter((interval) => !this.#removed.has(interval.id))
      .map((interval) => {
        const fields = this.#fields.get(interval.id);
        if (!fields) return interval;
        return { ...interval, ...Object.fromEntries([...fields].map(([field, pending]) => [field, pending.value])) };
      });
    const order = this.#order?.value;
    if (order)
      intervals = intervals.map((interval) => {
        const place = order.indexOf(interval.id);
        return place < 0 ? interval : { ...interval, priority: order.length - place };
      });
    return { ...state, ...whole, intervals };
  }

  #matches(state: SceneState, order: readonly number[]): boolean {
    const priority = new Map(state.intervals.map((interval) => [interval.id, interval.priority]));
    const values = order.map((id) => priority.get(id));
    return values.every((value, i) => value !== undefined && (i === 0 || (values[i - 1] as number) > value));
  }
}

/** Colours travel as 32-bit floats, so they come back a little different. */
export function same(a: unknown, b: unknown): boolean {
  if (typeof a === 'number' && typeof b === 'number') return a === b || Math.abs(a - b) <= 1e-6 * Math.max(Math.abs(a), Math.abs(b));
  if (Array.isArray(a) && Array.isArray(b)) return a.length === b.length && a.every((x, i) => same(x, b[i]));
  if (a && b && typeof a === 'object' && typeof b === 'object')
    return Object.keys(b).every((key) => same((a as Record<string, unknown>)[key], (b as Record<string, unknown>)[key]));
  return a === b;
}
