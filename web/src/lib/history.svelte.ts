// Undo and redo. A step has the fields that the person changed, with their values before and after. To undo it is to bring back the ones before, but only
// where the fields still are as the step left them: what somebody else has changed since stays. A drag is one step; the camera is none. Another dataset is
// one step as well: to undo it is to open the one before, as it was left; the steps beneath are that one's.
import { changesBetween, doesNothing, isNothing, isStream, joined, planOf, renamed, wordsOf, type Changes, type Plan, type Side } from './changes';
import type { Interval, SceneState } from './model';
import { parseSteps, stepsText } from './saved-steps';

interface Step {
  changes: Changes;
  kind: string;
  grip: number; // of the hand that made it; 0: none held anything
  atMs: number;
  /** To another dataset: how the one before was left, and, once that has been undone, the other one. */
  turn: { before: SceneState; after: SceneState | null; to: string } | null;
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
  /** Of a dataset, by its id. */
  name(dataset: string): string;
  /** What is shown, with its camera; opens another dataset as it was left, and calls `arrived` or `stayed`. */
  leave(): SceneState;
  visit(state: SceneState): void;
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
  /** A dataset that this page has asked for: by a person, or to undo or redo that. */
  #asked: { to: string; from: SceneState; by: 'person' | Side } | null = null;
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
    return step ? (step.open ? 'the last step' : this.#said(step)) : null;
  }
  #said({ changes, turn }: Step): string {
    return turn ? `opening ${this.doors.name(turn.to)}` : wordsOf(changes, this.doors.scene().view);
  }
  /** Whether anything has been done to the dataset that is shown. */
  get touched(): boolean {
    const last = this.#undo.at(-1);
    return !!last && !last.turn;
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
    const step: Step = { changes, kind, grip: this.doors.grip(), atMs: this.doors.now(), turn: null, open: waits ? { before, seq: Number(seq) || 0 } : null };
    const last = this.#undo.at(-1);
    if (last && this.#joins(last, step)) this.#undo = [...this.#undo.slice(0, -1), { ...step, changes: joined(last.changes, changes) }];
    else this.#undo = [...this.#undo.slice(1 - most), step];
    this.#redo = [];
    this.#sealed = false;
    if (!this.#turn) queueMicrotask(() => (this.#turn = false));
    this.#turn = true;
  }
  #joins(last: Step, step: Step): boolean {
    if (this.#sealed || last.open || last.turn || step.open) return false;
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
    if (this.#returning || this.#asked || this.#undo.at(-1)?.open) return void this.#waiting.push(() => this.#go(to));
    this.#sealed = true;
    for (;;) {
      const step = (to === 'before' ? this.#undo : this.#redo).at(-1);
      if (!step) return;
      const { view } = this.doors.scene();
      const words = this.#said(step);
      if (step.turn) return this.#turnBack(step.turn, to, words);
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
  #turnBack(turn: NonNullable<Step['turn']>, by: Side, words: string): void {
    const state = turn[by];
    if (!state) return;
    this.#asked = { to: state.dataset, from: this.doors.leave(), by };
    this.doors.visit(state);
    this.#speak(`${by === 'before' ? 'Undone' : 'Redone'}: ${words}.`);
  }
  /** The person opens another dataset. */
  opens(to: string): void {
    const from = this.doors.leave();
    if (from.dataset && from.dataset !== to) this.#asked = { to, from, by: 'person' };
  }
  /** The server shows another dataset: the one that was asked for, or one that somebody else has opened, where nothing of before can be brought back. */
  turned(to: string): void {
    const asked = this.#asked;
    if (!asked || asked.to !== to) return this.clear();
    const { from, by } = asked;
    this.#sealed = true;
    const [undo, redo] = [this.#undo, this.#redo];
    if (by === 'person') {
      const step: Step = { changes: changesBetween(from, from), kind: 'dataset', grip: 0, atMs: 0, turn: { before: from, after: null, to }, open: null };
      [this.#undo, this.#redo, this.#asked] = [[...undo.slice(1 - most), step], [], null];
      return;
    }
    const moved = (step: Step): Step => ({ ...step, turn: step.turn && { ...step.turn, [by === 'before' ? 'after' : 'before']: from } });
    if (by === 'before') [this.#undo, this.#redo] = [undo.slice(0, -1), [...redo, ...undo.slice(-1).map(moved)]];
    else [this.#undo, this.#redo] = [[...undo, ...redo.slice(-1).map(moved)], redo.slice(0, -1)];
  }
  /** What was left is on its way back, by the message `seq`: its layers get new ids. */
  arrived(seq: number, { intervals }: SceneState): void {
    if (!this.#asked) return;
    this.#asked = null;
    this.#returning = { layers: intervals, before: [], seq };
  }
  /** The dataset that was asked for cannot be opened, or does not have what was shown of it. */
  stayed(): void {
    this.#asked = null;
    this.#goOn();
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
    this.#goOn();
  }
  #goOn(): void {
    const waiting = this.#waiting;
    this.#waiting = [];
    for (const go of waiting) go();
  }
  /** In the steps of the dataset that is shown: in another one's the same id is another layer. */
  #rename(from: number, to: number): void {
    const rename = (steps: readonly Step[]) => {
      const others = steps.map(({ turn }) => turn !== null).lastIndexOf(true) + 1;
      return steps.map((step, i) => (i < others ? step : { ...step, changes: renamed(step.changes, from, to) }));
    };
    [this.#undo, this.#redo] = [rename(this.#undo), rename(this.#redo)];
  }

  /** Messages are counted anew: what waits for an answer takes the next State for it. */
  lost(): void {
    this.#undo = this.#undo.map((step) => (step.open ? { ...step, open: { ...step.open, seq: 0 } } : step));
    if (this.#returning) this.#returning.seq = 0;
  }
  /** For another page in the same session, which takes it by `restore`. What the server has not judged is none of it. */
  text(): string {
    const plain = (steps: readonly Step[]) => steps.filter(({ open }) => !open).map(({ changes, kind, turn }) => ({ changes, kind, ...(turn ? { turn } : {}) }));
    return stepsText({ undo: plain(this.#undo), redo: plain(this.#redo) });
  }
  restore(text: string | null): void {
    const saved = this.#undo.length + this.#redo.length === 0 ? parseSteps(text) : null;
    if (!saved) return;
    const whole = (steps: readonly unknown[]) => (steps as Pick<Step, 'changes' | 'kind'>[]).map((step): Step => ({ turn: null, ...step, grip: 0, atMs: -Infinity, open: null }));
    [this.#undo, this.#redo] = [whole(saved.undo), whole(saved.redo)];
    this.#sealed = true;
  }
  /** Another session, or a dataset that somebody else has opened: nothing of it can be brought back there. */
  clear(): void {
    this.#undo = this.#redo = [];
    this.#returning = null;
    this.#asked = null;
    this.#waiting = [];
    this.#sealed = true;
    this.spoken = '';
  }
}
