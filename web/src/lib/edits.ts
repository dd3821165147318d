// What the person does to the scene: shown at once, laid over the server's State, and sent. What comes in streams goes through a slot of its own.
import type { Plan } from './changes';
import { command, type Command } from './commands';
import type { History } from './history.svelte';
import { fitted, priorityOrder } from './intervals';
import type { Camera, ColorRange, FieldValues, Interval, IntervalPatch, Range, SceneState, Vec3 } from './model';
import type { Notices, Place } from './notices.svelte';
import type { Overlay } from './optimistic';
import type { Outgoing } from './outgoing';
import type { People } from './people.svelte';
import type { SceneView } from './scene-view.svelte';
import type { Selection } from './selection.svelte';
import { withEnds } from './transfer';

export interface EditsDoors {
  /** Whether the person has asked for little motion: then no cycle begins by itself. */
  calm(): boolean;
  /** Layers that the server takes. */
  most(): number;
}

export class Edits {
  constructor(
    private readonly scene: SceneView,
    private readonly out: Pick<Outgoing, 'sendInOrder' | 'slots'>,
    private readonly notices: Notices,
    private readonly selection: Selection,
    private readonly people: Pick<People, 'viewOnly'>,
    private readonly history: Pick<History, 'note'>,
    private readonly doors: EditsDoors,
  ) {}

  openDataset(id: string): void {
    this.#lay({ dataset: id }, 'dataset');
    this.out.sendInOrder(command.openDataset(id));
  }
  /** What is on the disk now, in place of what was read. */
  reloadDataset(): void {
    this.notices.clear('dataset');
    this.out.sendInOrder(command.reloadDataset());
  }
  selectArrays(change: { array?: string; colorBy?: string; texture?: string; values?: FieldValues }): void {
    // The ends of the layers move into the other array's range, and numbers for colours go: the server says how.
    this.history.note(
      'arrays',
      () => {
        // Another array is interpolated, as on the server.
        this.#lay(change.array !== undefined && change.array !== this.scene.view.array ? { values: 'interpolated', ...change } : change, 'arrays');
        return this.out.sendInOrder(command.selectArrays(change.array ?? '', change.colorBy ?? '', change.texture ?? '', change.values ?? null));
      },
      true,
    );
  }
  setTime(time: number | null, timeMode: SceneState['timeMode']): void {
    this.#stream('time', time === null ? { timeMode } : { time, timeMode }, command.setTime(time, timeMode), 'step');
  }
  setStep(step: number): void {
    this.#stream('step', { step, time: null }, command.setTimeStep(step), 'step');
  }
  /** By itself, as a series plays: all that it plays is one step back. */
  playStep(step: number): void {
    this.history.note('play', () => this.setStep(step));
  }
  setCombination(terms: SceneState['terms']): void {
    this.#stream('terms', { terms }, command.setCombination(terms), 'layers');
  }
  setCycle(change: Partial<SceneState['cycle']>): void {
    // Not laid over the view: the server moves the phase on meanwhile, and its word on that is the newer one.
    this.out.slots.put(`cycle ${Object.keys(change).join()}`, command.setCycle(change));
  }
  setSmear(smear: SceneState['smear']): void {
    this.#stream('smear', { smear }, command.setSmear(smear));
  }
  setClipPlanes(clipPlanes: NonNullable<SceneState['clipPlanes']>): void {
    this.#stream('clipPlanes', { clipPlanes }, command.setClipPlanes(clipPlanes), 'appearance');
  }
  setAnnotations(annotations: NonNullable<SceneState['annotations']>): void {
    this.history.note('annotations', () => this.#lay({ annotations }));
    this.out.sendInOrder(command.setAnnotations(annotations));
  }
  setMode(mode: SceneState['mode']): void {
    this.history.note('mode', () => this.#lay({ mode }));
    if (mode === 'cycled' && this.doors.calm()) this.setCycle({ playing: false }); // by hand, then
    this.out.sendInOrder(command.setAppearance({ mode }));
  }
  setColorRange(colorRange: ColorRange): void {
    this.#stream('colorRange', { colorRange }, command.setAppearance({ colorRange }), 'appearance');
  }
  /** Each in a slot of its own. */
  setLook(look: { background?: SceneState['background']; unitDistance?: number; occlusion?: number; depthFade?: number; bodyShading?: number; axisScale?: Vec3 }): void {
    this.history.note(`look ${Object.keys(look).join()}`, () => this.#lay(look));
    for (const [field, value] of Object.entries(look)) this.out.slots.put(field, command.setAppearance({ [field]: value }));
  }

  patchInterval(id: number, change: IntervalPatch): void {
    const shown = this.scene.view.intervals.find((interval) => interval.id === id);
    if (!shown) return; // somebody has deleted it under the hand
    if (Object.entries(change).every(([field, value]) => shown[field as keyof IntervalPatch] === value)) return; // a hand at a stop
    const patch = withEnds(shown, change);
    const act = () => {
      this.scene.edit((mine, nowMs) => mine.patch(id, patch, nowMs));
      this.notices.clear('layers', id);
      this.out.slots.putPatch(id, patch);
    };
    // With a function of its own a layer's colours are of the array that is cut.
    if (!patch.transfer || shown.transfer) this.history.note(`layer ${id} ${Object.keys(change).sort().join()}`, act);
    else
      this.history.note(
        'function',
        () => {
          this.out.slots.flush();
          this.scene.edit((mine, nowMs) => mine.patch(id, patch, nowMs));
          return this.out.sendInOrder(command.patchInterval(id, patch));
        },
        true,
      );
  }
  /** All layers, so that they lie in the one range as they lay in the other. */
  fitLayers(from: Range, to: Range): void {
    this.history.note('fit', () => {
      for (const { id, lower, upper } of this.scene.view.intervals) this.patchInterval(id, fitted({ lower, upper }, from, to));
    });
  }
  addInterval(interval: Omit<Interval, 'id' | 'priority'>): void {
    const { intervals } = this.scene.view;
    const most = this.doors.most();
    if (intervals.length >= most) return this.notices.say(`The server takes at most ${most} layers.`, 'error', 'layers');
    const priority = intervals.reduce((top, other) => Math.max(top, other.priority), 0) + 1;
    this.selection.expectNew();
    this.notices.clear('layers');
    this.history.note('add', () => this.out.sendInOrder(command.setIntervals([...intervals, { ...interval, id: 0, priority }])), true);
  }
  removeInterval(id: number): void {
    this.out.slots.drop(id);
    if (this.selection.layer === id) this.selection.layer = null;
    this.history.note('remove', () => this.scene.edit((mine, nowMs) => mine.remove(id, nowMs)));
    this.notices.clear('layers', id);
    this.out.sendInOrder(command.removeInterval(id));
  }
  reorderPriorities(ids: readonly number[]): void {
    this.history.note('order', () => this.scene.edit((mine, nowMs) => mine.reorder(ids, nowMs)));
    this.out.sendInOrder(command.reorderPriorities(ids));
  }
  get priorities(): number[] {
    return priorityOrder(this.scene.view.intervals);
  }

  moveCamera(camera: Camera): void {
    if (this.people.viewOnly) return;
    this.#lay({ camera });
    this.out.slots.putCamera(camera);
  }
  setView(side: string): void {
    if (this.people.viewOnly) return;
    this.scene.forget('camera');
    this.out.sendInOrder(command.setView(side));
  }

  /** What undoing or redoing a step takes. If it brings layers back: the seq of the message that does. */
  bring({ scene, patches, intervals, removed, order }: Plan): number {
    const { array, values, colorBy, texture, terms, step, time, timeMode, mode, ...looks } = scene as Partial<SceneState>;
    const { clipPlanes, smear, annotations, colorRange, ...look } = looks;
    const arrays = { ...(array ? { array } : {}), ...(colorBy ? { colorBy } : {}), ...(texture ? { texture } : {}), ...(values ? { values } : {}) };
    const chooseArrays = () => Object.keys(arrays).length > 0 && this.selectArrays(arrays);
    // Colours of another array wait until no layer has a function; whole values want no terms and no time between steps.
    for (const [id, { transfer }] of patches) if (transfer === null) this.patchInterval(id, { transfer });
    if (values !== 'whole') chooseArrays();
    if (terms) this.setCombination(terms);
    if (time != null) this.setTime(time, timeMode ?? this.scene.view.timeMode);
    else if (timeMode) this.setTime(null, timeMode);
    if (step !== undefined || time === null) this.setStep(step ?? this.scene.view.step);
    if (values === 'whole') chooseArrays();
    let seq = 0;
    if (intervals) {
      const there = (id: number) => this.scene.view.intervals.some((interval) => interval.id === id);
      seq = this.out.sendInOrder(command.setIntervals(intervals.map((interval) => (there(interval.id) ? interval : { ...interval, id: 0 }))));
    } else for (const id of removed) this.removeInterval(id);
    for (const [id, patch] of patches) this.patchInterval(id, patch);
    if (order && !intervals) this.reorderPriorities(order);
    if (smear) this.setSmear(smear);
    if (clipPlanes) this.setClipPlanes(clipPlanes);
    if (annotations) this.setAnnotations(annotations);
    if (colorRange) this.setColorRange(colorRange);
    if (mode) this.setMode(mode);
    this.setLook(look);
    return seq;
  }

  #stream(slot: string, overlay: Overlay, body: Command, place?: Place): void {
    this.history.note(slot, () => this.#lay(overlay, place));
    this.out.slots.put(slot, body);
  }
  /** Shown from now on; what was said about the last edit of the kind is out of date. */
  #lay(overlay: Overlay, place?: Place): void {
    this.scene.edit((mine, nowMs) => mine.set(overlay, nowMs));
    if (place) this.notices.clear(place);
  }
}
