// What datasets looked like when the person left them, in this tab.
import { sameCamera } from './camera';
import { changesBetween, isNothing } from './changes';
import type { SceneState } from './model';
import type { SavedTab } from './saved';

export class Visits {
  /** How the open dataset was shown when it was opened; null: that was before this page was loaded. */
  #first: SceneState | null = null;

  constructor(private readonly saved: Pick<SavedTab, 'left' | 'leave'>) {}

  arrived(first: SceneState | null): void {
    this.#first = first;
  }
  /** At another dataset now. did: whether the person has done anything there but look round. */
  left(last: SceneState, did: boolean): void {
    const first = this.#first;
    const looked = !!first && !sameCamera(first.camera, last.camera);
    const changed = !first || looked || (did && !isNothing(changesBetween(first, last)));
    if (last.dataset) this.saved.leave(last.dataset, changed ? last : null);
  }
  of(dataset: string): SceneState | null {
    const state = this.saved.left(dataset);
    return state?.dataset === dataset ? state : null;
  }
}
