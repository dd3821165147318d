// What a page does after a loss or a reload: it goes back to its session, or brings what it showed into a new one, step by step.
import type { SceneState } from './model';
import type { DatasetEntry, DatasetInfo, Welcome } from './told';
import { restoreStep, type RestoreStep } from './restore';
import type { SavedTab } from './saved';

/** Why something is brought back: the session was lost; a person has opened a file; a dataset is chosen again; it is to be as it is shown at first; the choice of another one is undone or redone. */
export type Cause = 'loss' | 'file' | 'again' | 'anew' | 'undo';

export interface RecoveryDoors {
  saved: SavedTab;
  /** Whether the person has asked for little motion: then nothing comes back playing. */
  calm(): boolean;
  after(ms: number, callback: () => void): void;
}

const restMs = 300; // between two times that the scene is written down

export class Recovery {
  #restoring: { saved: SceneState; opened: boolean; quiet: boolean; cause: Cause } | null = null;
  #welcomedBefore = false;
  #newest: SceneState | null = null;
  #writesSoon = false;

  constructor(private readonly doors: RecoveryDoors) {}

  get resumeToken(): string {
    return this.doors.saved.session.resumeToken;
  }
  /** Something is still being brought back. */
  get active(): boolean {
    return this.#restoring !== null;
  }
  get cause(): Cause | null {
    return this.#restoring?.cause ?? null;
  }
  /** What is being brought. */
  get saved(): SceneState | null {
    return this.#restoring?.saved ?? null;
  }
  /** Whether another dataset has been asked for, for what is brought. */
  get opened(): boolean {
    return this.#restoring?.opened ?? false;
  }
  /** This is to be shown, in the session that there is. opened: its dataset is asked for already. */
  bring(saved: SceneState, cause: Cause, opened = false): void {
    this.#restoring = { saved, opened, quiet: cause === 'again', cause };
  }
  /** Its dataset cannot be opened. */
  giveUp(): void {
    this.#restoring = null;
  }

  /**
   * Whether the page is in the session in which it was. If it is not, what it showed is to be brought back. A guest finds the session as it is and
   * brings nothing. shown: what the page shows now; null: nothing yet.
   */
  welcomed({ session, resumeToken }: Pick<Welcome, 'session' | 'resumeToken'>, shown: SceneState | null): boolean {
    const { saved } = this.doors;
    const resumed = session !== '' && session === saved.session.id;
    let before = (this.#welcomedBefore && shown) || saved.state;
    if (before?.cycle && this.doors.calm()) before = { ...before, cycle: { ...before.cycle, playing: false } };
    saved.session = { id: session, resumeToken };
    if (!resumed) this.#restoring = resumeToken !== '' && before ? { saved: before, opened: false, quiet: !this.#welcomedBefore, cause: 'loss' } : null;
    this.#welcomedBefore = true;
    return resumed;
  }

  /** The next step, now that the server says this. What was only remembered, and not seen in this page, is given up without a word: an empty reason. */
  next(server: SceneState, info: DatasetInfo | null, datasets: readonly DatasetEntry[], all: number | undefined): RestoreStep {
    const restoring = this.#restoring;
    if (!restoring) return { kind: 'wait' };
    const step = restoreStep(restoring.saved, server, info, datasets, restoring.opened, all);
    if (step.kind === 'send') restoring.opened = true;
    if (step.kind === 'impossible' || (step.kind === 'send' && step.done)) this.#restoring = null;
    if (step.kind !== 'impossible') return step;
    const { dataset, array } = restoring.saved;
    const strange = step.lacks === 'dataset' ? `This server does not have the dataset “${dataset}” of this view.` : `The dataset does not have the array “${array}” of this view.`;
    return { ...step, reason: restoring.quiet ? '' : restoring.cause === 'file' ? strange : step.reason };
  }

  /** Writes the scene down soon, the newest that there is then, and what can be undone in it; not while the old one is still being brought back. */
  keep(server: SceneState, steps: () => string): void {
    this.#newest = server;
    if (this.#restoring || this.#writesSoon) return;
    this.#writesSoon = true;
    this.doors.after(restMs, () => {
      this.#writesSoon = false;
      if (this.#restoring || !this.#newest?.dataset) return;
      this.doors.saved.state = this.#newest;
      this.doors.saved.steps = steps();
    });
  }
}
