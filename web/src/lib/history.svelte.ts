// Undo and redo. A step has the fields that the person changed, with their values before and after. To undo it is to bring back the ones before, but only
// where the fields still are as the step left them: what somebody else has changed since stays. A drag is one step; the camera is none.
import { changesBetween, doesNothing, isNothing, isStream, joined, planOf, renamed, wordsOf, type Changes, type Plan, type Side } from './changes';
import type { Interval, SceneState } from './model';
import { parseSteps, stepsText } from './saved-steps';

interface Step {
  changes: Changes;
  kind: string;
  grip: number; // of the hand that made it; 0: none held anything
  atMs: number;
  /** Layers' ids and what follows from a choice are known when the server has judged the message. */
  open: { before: SceneState; seq: number } | null;
}

export interface HistoryDoors {
  scene(): { view: SceneState; server: SceneState };
  /** Which of all the grips of the hand this is; 0: it holds nothing. */
  grip(): number;
  now(): number;
  /** Sends what it takes. The newest message's seq. */
  bring(plan: Plan): number;
  say(text: string): void;
}

const most = 100; // steps
const pauseMs = 700; // that ends a stream of values without a hand: keys, or a colour that is being chosen

export class History {
  #undo = $state.raw<readonly Step[]>([]);
  #redo = $state.raw<readonly Step[]>([]);
  /** What was done last, for who cannot see it. */
  spoken = $state.raw('');
  #quiet = false;
  #turn = false; // what one event did is one step
  #sealed = true; // nothing joins the newest step any more
  /** Layers that were brought back and have no new id yet. */
  #returning: { layers: Interval[]; before: number[]; seq: number } | null = null;
  #waiting: (() => void)[] = [];

  constructor(private readonly doors: HistoryDoors) {}

  get undoes(): string | null {
    return this.#words(this.#undo);
  }
  get redoes(): string | null {
    return this.#words(this.#redo);
  }
  #words(steps: readonly Step[]): string | null {
    const step = steps.at(-1);
    return step ? (step.open ? 'the last step' : wordsOf(step.changes, this.doors.scene().view)) : null;
  }

  /** Notes what `act` changes. waits: what that is only the server's State says; `act` then gives the message's seq. */
  note(kind: string, act: () => unknown, waits = false): void {
    if (this.#quiet) return void act();
    const before = this.doors.scene().view;
    this.#quiet = true;
    const seq = act();
    this.#quiet = false;
    const changes = changesBetween(before, this.doors.scene().view);
    if (!waits && isNothing(changes)) return;
    const step: Step = { changes, kind, grip: this.doors.grip(), atMs: this.doors.now(), open: waits ? { before, seq: Number(seq) || 0 } : null };
    const last = this.#undo.at(-1);
    if (last && this.#joins(last, step)) this.#undo = [...this.#undo.slice(0, -1), { ...step, changes: joined(last.changes, changes) }];
    else this.#undo = [...this.#undo.slice(1 - most), step];
    this.#redo = [];
    this.#sealed = false;
    if (!this.#turn) queueMicrotask(() => (this.#turn = false));
    this.#turn = true;
  }
  #joins(last: Step, step: Step): boolean {
    if (this.#sealed || last.open || step.open) return false;
    if (this.#turn || (step.grip !== 0 && step.grip === last.grip)) return true;
    if (step.kind !== last.kind || step.grip || last.grip) return false;
    return step.kind === 'play' || (isStream(step.changes) && step.atMs - last.atMs < pauseMs);
  }

  undo(): void {
    this.#go('before');
  }
  redo(): void {
    this.#go('after');
  }
  #go(to: Side): void {
    if (this.#returning || this.#undo.at(-1)?.open) return void this.#waiting.push(() => this.#go(to));
    this.#sealed = true;
    for (;;) {
      const step = (to === 'before' ? this.#undo : this.#redo).at(-1);
      if (!step) return;
      const { view } = this.doors.scene();
      const words = wordsOf(step.changes, view);
      const plan = planOf(step.changes, view, to);
      if (to === 'before') [this.#undo, this.#redo] = [this.#undo.slice(0, -1), [...this.#redo, step]];
      else [this.#undo, this.#redo] = [[...this.#undo, step], this.#redo.slice(0, -1)];
      const said = to === 'before' ? 'undone' : 'redone';
      if (plan.kept.length > 0) this.doors.say(`Not ${said}, because it has been changed elsewhere since: ${[...new Set(plan.kept)].join(', ')}.`);
      if (doesNothing(plan) && plan.kept.length === 0) continue; // the server has refused it, or somebody has done it already
      if (!doesNothing(plan)) this.#bring(plan);
      this.#speak(doesNothing(plan) ? '' : `${to === 'before' ? 'Undone' : 'Redone'}: ${words}.`);
      return;
    }
  }
  /** The same words are spoken again only if they are other ones. */
  #speak(words: string): void {
    this.spoken = words && words === this.spoken ? `${words}\u00a0` : words;
  }
  #bring(plan: Plan): void {
    const there = this.doors.scene().view.intervals.map(({ id }) => id);
    this.#quiet = true;
    const seq = this.doors.bring(plan);
    this.#quiet = false;
    const layers = (plan.intervals ?? []).filter(({ id }) => !there.includes(id));
    if (layers.length > 0) this.#returning = { layers, before: there, seq };
  }

  /** The server has judged all up to the message `seq`, and this is its State. */
  told(seq: number): void {
    const { server } = this.doors.scene();
    const due = (of: { seq: number } | null) => of !== null && seq >= of.seq;
    if (this.#undo.some((step) => due(step.open)))
      this.#undo = this.#undo
        .map((step) => (step.open && due(step.open) ? { ...step, open: null, changes: changesBetween(step.open.before, server) } : step))
        .filter((step) => step.open || !isNothing(step.changes));
    if (this.#returning && due(this.#returning)) {
      const { layers, before } = this.#returning;
      this.#returning = null;
      for (const layer of layers) {
        const now = server.intervals.find((interval) => !before.includes(interval.id) && interval.number === layer.number);
        if (now) this.#rename(layer.id, now.id);
      }
    }
    const waiting = this.#waiting;
    this.#waiting = [];
    for (const go of waiting) go();
  }
  #rename(from: number, to: number): void {
    const rename = (steps: readonly Step[]) => steps.map((step) => ({ ...step, changes: renamed(step.changes, from, to) }));
    [this.#undo, this.#redo] = [rename(this.#undo), rename(this.#redo)];
  }

  /** Messages are counted anew: what waits for an answer takes the next State for it. */
  lost(): void {
    this.#undo = this.#undo.map((step) => (step.open ? { ...step, open: { ...step.open, seq: 0 } } : step));
    if (this.#returning) this.#returning.seq = 0;
  }
  /** For another page in the same session, which takes it by `restore`. What the server has not judged is none of it. */
  text(): string {
    const plain = (steps: readonly Step[]) => steps.filter(({ open }) => !open).map(({ changes, kind }) => ({ changes, kind }));
    return stepsText({ undo: plain(this.#undo), redo: plain(this.#redo) });
  }
  restore(text: string | null): void {
    const saved = this.#undo.length + this.#redo.length === 0 ? parseSteps(text) : null;
    if (!saved) return;
    const whole = (steps: readonly unknown[]) => (steps as Pick<Step, 'changes' | 'kind'>[]).map((step): Step => ({ ...step, grip: 0, atMs: -Infinity, open: null }));
    [this.#undo, this.#redo] = [whole(saved.undo), whole(saved.redo)];
    this.#sealed = true;
  }
  /** Another dataset, another session: nothing of it can be brought back there. */
  clear(): void {
    this.#undo = this.#redo = [];
    this.#returning = null;
    this.#waiting = [];
    this.#sealed = true;
    this.spoken = '';
  }
}
