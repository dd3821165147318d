// The scene as the person sees it: the server's newest State under their own newest edits.
import { emptyState, type SceneState } from './model';
import { OptimisticState, type Overlay } from './optimistic';

export class SceneView {
  view = $state.raw<SceneState>(emptyState);
  /** Whether the server has not yet said what the person's newest edits have become. */
  waits = $state.raw(false);
  /** The newest State. */
  server: SceneState = emptyState;
  /** The server opens the session's dataset again and answers nothing before: edits wait for it, however long. */
  waking = false;
  readonly #mine = new OptimisticState();

  constructor(private readonly now: () => number) {}

  /** Changes what is laid over the State. */
  edit(change: (mine: OptimisticState, nowMs: number) => void): void {
    change(this.#mine, this.now());
    this.view = this.#mine.view(this.server);
    this.waits = this.#mine.waits;
  }
  /** The server is asked to choose this itself; until it has, what is shown stays. */
  forget(key: keyof Overlay): void {
    this.#mine.forget(key);
  }

  /** The server says something new. */
  told(state: SceneState): void {
    this.server = state;
    this.settle();
  }
  /** Lets go of the edits that the State contains, and of those that have waited too long. */
  settle(): void {
    this.edit((mine, nowMs) => {
      if (this.waking) mine.renew(nowMs);
      mine.settle(this.server, nowMs);
    });
  }
}
