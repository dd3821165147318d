// What the person does to the scene: shown at once, laid over the server's State, and sent. What comes in streams goes through a slot of its own.
import { command, type Command } from './commands';
import { priorityOrder } from './intervals';
import type { Camera, ColorRange, FieldValues, Interval, IntervalPatch, SceneState, Vec3 } from './model';
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
    // Another array is interpolated, as on the server.
    this.#lay(change.array !== undefined && change.array !== this.scene.view.array ? { values: 'interpolated', ...change } : change, 'arrays');
    this.out.sendInOrder(command.selectArrays(change.array ?? '', change.colorBy ?? '', change.texture ?? '', change.values ?? null));
  }
  setTime(time: number | null, timeMode: SceneState['timeMode']): void {
    this.#stream('time', time === null ? { timeMode } : { time, timeMode }, command.setTime(time, timeMode), 'step');
  }
  setStep(step: number): void {
    this.#stream('step', { step, time: null }, command.setTimeStep(step), 'step');
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
    this.#lay({ annotations });
    this.out.sendInOrder(command.setAnnotations(annotations));
  }
  setMode(mode: SceneState['mode']): void {
    this.#lay({ mode });
    if (mode === 'cycled' && this.doors.calm()) this.setCycle({ playing: false }); // by hand, then
    this.out.sendInOrder(command.setAppearance({ mode }));
  }
  setColorRange(colorRange: ColorRange): void {
    this.#stream('colorRange', { colorRange }, command.setAppearance({ colorRange }), 'appearance');
  }
  /** Each in a slot of its own. */
  setLook(look: { background?: SceneState['background']; unitDistance?: number; occlusion?: number; depthFade?: number; bodyShading?: number; axisScale?: Vec3 }): void {
    this.#lay(look);
    for (const [field, value] of Object.entries(look)) this.out.slots.put(field, command.setAppearance({ [field]: value }));
  }

  patchInterval(id: number, change: IntervalPatch): void {
    const shown = this.scene.view.intervals.find((interval) => interval.id === id);
    if (!shown) return; // somebody has deleted it under the hand
    if (Object.entries(change).every(([field, value]) => shown[field as keyof IntervalPatch] === value)) return; // a hand at a stop
    const patch = withEnds(shown, change);
    this.scene.edit((mine, nowMs) => mine.patch(id, patch, nowMs));
    this.notices.clear('layers', id);
    this.out.slots.putPatch(id, patch);
  }
  addInterval(interval: Omit<Interval, 'id' | 'priority'>): void {
    const { intervals } = this.scene.view;
    const most = this.doors.most();
    if (intervals.length >= most) return this.notices.say(`The server takes at most ${most} layers.`, 'error', 'layers');
    const priority = intervals.reduce((top, other) => Math.max(top, other.priority), 0) + 1;
    this.selection.expectNew();
    this.notices.clear('layers');
    this.out.sendInOrder(command.setIntervals([...intervals, { ...interval, id: 0, priority }]));
  }
  removeInterval(id: number): void {
    this.out.slots.drop(id);
    if (this.selection.layer === id) this.selection.layer = null;
    this.scene.edit((mine, nowMs) => mine.remove(id, nowMs));
    this.notices.clear('layers', id);
    this.out.sendInOrder(command.removeInterval(id));
  }
  reorderPriorities(ids: readonly number[]): void {
    this.scene.edit((mine, nowMs) => mine.reorder(ids, nowMs));
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

  #stream(slot: string, overlay: Overlay, body: Command, place?: Place): void {
    this.#lay(overlay, place);
    this.out.slots.put(slot, body);
  }
  /** Shown from now on; what was said about the last edit of the kind is out of date. */
  #lay(overlay: Overlay, place?: Place): void {
    this.scene.edit((mine, nowMs) => mine.set(overlay, nowMs));
    if (place) this.notices.clear(place);
  }
}
