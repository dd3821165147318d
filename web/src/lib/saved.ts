// What a tab remembers over a reload: which session it had, and what the picture was made of.
import type { SceneState } from './model';
import { parseSavedState, savedStateText } from './restore';

export interface SavedSession {
  id: string;
  resumeToken: string;
}

type Store = Pick<Storage, 'getItem' | 'setItem'>;

/** Storage can be forbidden or full; then the tab remembers nothing and works all the same. */
export class SavedTab {
  readonly #prefix: string;

  /** path: of the page, since several servers can share one origin below a proxy. */
  constructor(
    private readonly store: Store,
    path: string,
  ) {
    this.#prefix = `isostrata.${path}.`;
  }

  get session(): SavedSession {
    return { id: this.#read('session') ?? '', resumeToken: this.#read('resume') ?? '' };
  }
  set session(session: SavedSession) {
    this.#write('session', session.id);
    this.#write('resume', session.resumeToken);
  }
  get state(): SceneState | null {
    return parseSavedState(this.#read('state'));
  }
  set state(state: SceneState | null) {
    this.#write('state', state ? savedStateText(state) : '');
  }

  /** What can be undone in the session; empty: nothing. */
  get steps(): string {
    return this.#read('steps') ?? '';
  }
  set steps(text: string) {
    this.#write('steps', text);
  }

  /** Which plots are open in the session; empty: none. */
  get plots(): string {
    return this.#read('plots') ?? '';
  }
  set plots(text: string) {
    this.#write('plots', text);
  }

  /** How a dataset looked when it was left. */
  left(dataset: string): SceneState | null {
    return parseSavedState(this.#read(`left.${dataset}`));
  }
  leave(dataset: string, state: SceneState | null): void {
    this.#write(`left.${dataset}`, state ? savedStateText(state) : '');
  }

  #read(key: string): string | null {
    try {
      return this.store.getItem(this.#prefix + key);
    } catch {
      return null;
    }
  }
  #write(key: string, value: string): void {
    try {
      this.store.setItem(this.#prefix + key, value);
    } catch {
      // See above.
    }
  }
}
