// Whole views that take the place of what is shown: after a loss, out of a file, or a dataset as it was left.
import { datasetHere } from './dataset-here';
import type { Edits } from './edits';
import type { FileList } from './file-list.svelte';
import type { History } from './history.svelte';
import type { Camera, SceneState } from './model';
import type { Notices } from './notices.svelte';
import type { OpenDataset } from './open-dataset.svelte';
import type { Outgoing } from './outgoing';
import type { Recovery } from './recovery';
import type { SceneView } from './scene-view.svelte';
import type { Visits } from './visits';

export interface ViewsDoors {
  scene: SceneView;
  edits: Pick<Edits, 'openDataset' | 'setStep'>;
  history: Pick<History, 'note' | 'touched' | 'opens' | 'arrived' | 'stayed'>;
  notices: Notices;
  dataset: OpenDataset;
  files: FileList;
  out: Outgoing;
  recovery: Recovery;
  visits: Visits;
  camera(): Camera | null;
  /** How many datasets there are, of which the list of files has the first. */
  datasetsAll(): number | undefined;
}

const mostTries = 5; // of datasets that nobody has asked for

export class Views {
  /** Which dataset is opened without anybody's asking; null: somebody has chosen. */
  #tried: number | null = null;
  /** Where to go in the dataset that is on its way. */
  #step: { dataset: string; step: number; steps: number } | null = null;

  constructor(private readonly doors: ViewsDoors) {}

  /** As it was left in this tab, if it was. A step that is asked for, from 0, is gone to if the dataset has as many as `steps`. */
  openDataset(id: string, step = -1, steps = 0): void {
    const { edits, history, visits, recovery, scene } = this.doors;
    this.#tried = null;
    this.#step = step < 0 ? null : { dataset: id, step, steps };
    if (id === scene.server.dataset && this.#step) return this.#goToStep();
    history.opens(id);
    edits.openDataset(id);
    const left = visits.of(id);
    if (left && id !== scene.server.dataset) recovery.bring(left, 'again', true);
    else recovery.giveUp();
  }
  #goToStep(): void {
    const { dataset, edits, recovery, scene } = this.doors;
    const asked = this.#step;
    if (!asked || recovery.active || scene.server.dataset !== asked.dataset || dataset.info?.id !== asked.dataset) return;
    this.#step = null;
    if (dataset.info.times.length === asked.steps) edits.setStep(asked.step);
  }
  /** What is shown, with its camera; not the dataset that is on its way. */
  get shown(): SceneState {
    const { scene, camera } = this.doors;
    return { ...scene.view, dataset: scene.server.dataset, camera: camera() };
  }
  /** Another dataset, as this says. */
  visit(state: SceneState): void {
    const { edits, recovery } = this.doors;
    this.#tried = null;
    edits.openDataset(state.dataset);
    recovery.bring(state, 'undo', true);
  }
  /** Another scene in place of what is shown, out of a file, or why the file has none. */
  openFile(view: SceneState | string, name: string): void {
    const { files, notices, out, recovery, scene } = this.doors;
    if (typeof view === 'string') return notices.say(`“${name}” is not opened: ${view}`);
    this.#tried = null;
    notices.clear('page');
    out.slots.flush();
    const here = datasetHere(view.dataset, files.datasets, scene.server.dataset);
    const part = view.dataset.replace(/^[^@]*/, '');
    if (here && here.id + part !== view.dataset)
      notices.say(`The view was saved of “${view.dataset}”, elsewhere. It is opened over “${here.name}”, whose file has the same name.`, 'note');
    recovery.bring(here ? { ...view, dataset: here.id + part } : view, 'file');
    this.goOn();
  }
  /** A session that has just begun shows something at once. */
  openFirst(): void {
    const { edits, files, recovery, scene } = this.doors;
    const next = files.whole[this.#tried ?? 0];
    if (!next || recovery.active || scene.server.dataset) return;
    this.#tried ??= 0;
    edits.openDataset(next.id);
  }
  /** A dataset cannot be opened. If nobody has asked for it, perhaps the next one can. */
  failed(): void {
    this.#step = null;
    this.doors.recovery.giveUp();
    this.doors.history.stayed();
    if (this.#tried === null || ++this.#tried >= mostTries) this.#tried = null;
    else this.openFirst();
  }

  /** The server turns from the dataset that is shown to another one. */
  turns(from: string, to: SceneState): void {
    const { history, scene, visits } = this.doors;
    visits.left({ ...scene.view, dataset: from }, history.touched);
    visits.arrived(to);
  }
  /** The next step of what is being brought, whenever the server has said something. */
  goOn(): void {
    const { dataset, datasetsAll, files, history, notices, out, recovery, scene, visits } = this.doors;
    const { cause, opened, saved } = recovery;
    const step = recovery.next(scene.server, dataset.info, files.datasets, datasetsAll());
    if (step.kind === 'send') {
      const send = () => Math.max(...step.commands.map((body) => out.send(body)));
      if (cause === 'loss') visits.arrived(null);
      if (!step.done && cause === 'file' && saved) history.opens(saved.dataset);
      // What is shown of another dataset belongs to the choice of it.
      if (cause === 'loss' || opened || !step.done) {
        const seq = send();
        if (cause === 'undo' && step.done && saved) history.arrived(seq, saved);
      } else history.note('view', send, true);
      if (step.done && cause === 'again') this.#sayBack(scene.server);
      if (step.done && cause === 'file') notices.say('The view is opened.', 'note');
    }
    if (step.kind !== 'impossible') return this.#goToStep();
    if (step.reason) notices.say(step.reason);
    history.stayed();
    if (cause === 'loss') this.openFirst();
  }
  /** first: how the dataset is shown at first. */
  #sayBack(first: SceneState): void {
    const { notices, recovery, scene } = this.doors;
    const run = () => {
      if (scene.server.dataset !== first.dataset) return;
      recovery.bring(first, 'anew');
      this.goOn();
    };
    notices.say('Layers, colours and camera are as you left them.', 'note', 'dataset', { label: 'Start anew', run });
  }
}
