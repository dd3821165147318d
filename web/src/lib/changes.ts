// What a step of the person's has changed, field by field with the values before and after; and what brings them back.
import { layerNumber, priorityOrder } from './intervals';
import { stepRange, type Interval, type IntervalPatch, type SceneState } from './model';
import { same } from './optimistic';

/** Of the scene as a whole. The camera is where one stands and not what one has done; the cycle runs by itself. */
const sceneFields = ['array', 'values', 'colorBy', 'texture', 'step', 'time', 'timeMode', 'terms', 'mode', 'smear', 'clipPlanes', 'annotations',
  'colorRange', 'background', 'unitDistance', 'occlusion', 'depthFade', 'bodyShading', 'axisScale'] as const;
type SceneField = (typeof sceneFields)[number];
const layerFields = ['lower', 'upper', 'color', 'colorMap', 'opacity', 'visible', 'opacityUpper', 'ownRange', 'surface', 'name', 'transfer'] as const;

export type Side = 'before' | 'after';
type Sides<T> = Record<Side, T>;

export interface Changes {
  scene: Map<SceneField, Sides<unknown>>;
  fields: Map<number, Map<keyof IntervalPatch, Sides<unknown>>>; // of layers that are there before and after
  layers: Map<number, Sides<Interval | null>>; // that came or went
  order: Sides<number[]> | null; // of priorities
  listed: Sides<number[]>; // all layers, as they were added
  ranked: Sides<number[]>; // all layers, as they are painted
}

const usual: Partial<Record<SceneField, unknown>> = {
  values: 'interpolated', clipPlanes: [], annotations: { axes: false, box: false, legend: false }, colorRange: stepRange, occlusion: 0, depthFade: 0, bodyShading: 0, axisScale: [1, 1, 1],
};
/** An empty name of an array stands for another one. */
function fieldOf(state: SceneState, field: SceneField): unknown {
  if (field === 'colorBy') return state.colorBy || state.array;
  if (field === 'texture') return state.texture || state.colorBy || state.array;
  return state[field] ?? usual[field] ?? null;
}
const idsOf = (state: Pick<SceneState, 'intervals'>) => state.intervals.map(({ id }) => id);
const placesOf = (before: SceneState, after: SceneState) => ({
  listed: { before: idsOf(before), after: idsOf(after) },
  ranked: { before: priorityOrder(before.intervals), after: priorityOrder(after.intervals) },
});
const among = (ids: readonly number[], others: readonly number[]) => ids.filter((id) => others.includes(id));
const asLong = (a: unknown, b: unknown) => same(a, b) && same(b, a); // same() looks at what its second argument has

export function changesBetween(before: SceneState, after: SceneState): Changes {
  const changes: Changes = { scene: new Map(), fields: new Map(), layers: new Map(), order: null, ...placesOf(before, after) };
  for (const field of sceneFields) {
    const sides = { before: fieldOf(before, field), after: fieldOf(after, field) };
    if (!asLong(sides.before, sides.after)) changes.scene.set(field, sides);
  }
  for (const id of new Set([...changes.listed.before, ...changes.listed.after])) {
    const [was, is] = [before, after].map((state) => state.intervals.find((interval) => interval.id === id) ?? null) as [Interval | null, Interval | null];
    if (!was || !is) changes.layers.set(id, { before: was, after: is });
    else for (const field of layerFields) if (!asLong(was[field] ?? null, is[field] ?? null)) setField(changes, id, field, { before: was[field] ?? null, after: is[field] ?? null });
  }
  const order = changes.ranked;
  if (among(order.before, order.after).join() !== among(order.after, order.before).join()) changes.order = order;
  return changes;
}
function setField(changes: Changes, id: number, field: keyof IntervalPatch, sides: Sides<unknown>): void {
  const fields = changes.fields.get(id) ?? new Map<keyof IntervalPatch, Sides<unknown>>();
  changes.fields.set(id, fields.set(field, sides));
}

export const isNothing = (c: Changes): boolean => c.scene.size + c.fields.size + c.layers.size === 0 && !c.order;

/** Both as one: from before the first to after the second. */
export function joined(first: Changes, second: Changes): Changes {
  const both = <K>(a: Map<K, Sides<unknown>>, b: Map<K, Sides<unknown>>) => {
    const all = new Map(a);
    for (const [key, sides] of b) all.set(key, { before: (a.get(key) ?? sides).before, after: sides.after });
    for (const [key, { before, after }] of all) if (asLong(before, after)) all.delete(key);
    return all;
  };
  const fields = new Map(first.fields);
  for (const [id, of] of second.fields) fields.set(id, both(fields.get(id) ?? new Map(), of));
  for (const [id, of] of fields) if (of.size === 0) fields.delete(id);
  return {
    scene: both(first.scene, second.scene),
    fields,
    layers: new Map([...first.layers, ...second.layers]),
    order: first.order && second.order ? { before: first.order.before, after: second.order.after } : (first.order ?? second.order),
    listed: { before: first.listed.before, after: second.listed.after },
    ranked: { before: first.ranked.before, after: second.ranked.after },
  };
}
/** A stream of values, as a slider makes them, and not a switch or a list that grows: then what comes soon after belongs to it. */
export function isStream({ scene, fields, layers, order }: Changes): boolean {
  const flows = ({ before, after }: Sides<unknown>) =>
    (typeof before === 'number' && typeof after === 'number') ||
    (Array.isArray(before) ? Array.isArray(after) && before.length === after.length : !!before && !!after && typeof before === 'object');
  return layers.size === 0 && !order && [scene, ...fields.values()].every((of) => [...of.values()].every(flows));
}
/** A layer that was brought back is the one of before, with another id. */
export function renamed(changes: Changes, from: number, to: number): Changes {
  const id = (old: number) => (old === from ? to : old);
  const ids = (sides: Sides<number[]>) => ({ before: sides.before.map(id), after: sides.after.map(id) });
  const keys = <T>(map: Map<number, T>) => new Map([...map].map(([old, value]) => [id(old), value]));
  return { ...changes, fields: keys(changes.fields), layers: keys(changes.layers), order: changes.order && ids(changes.order), listed: ids(changes.listed), ranked: ids(changes.ranked) };
}

/** What to do to a scene. */
export interface Plan {
  scene: Partial<Record<SceneField, unknown>>;
  patches: Map<number, IntervalPatch>;
  intervals: Interval[] | null; // all of them, if one is brought back; its id is that of before
  removed: number[];
  order: number[] | null;
  /** What has become something else since, and is left as it is. */
  kept: string[];
}

/** Takes the scene to the one side of the changes, as far as it still is as the other one says. */
export function planOf(changes: Changes, view: SceneState, to: Side): Plan {
  const from: Side = to === 'before' ? 'after' : 'before';
  const plan: Plan = { scene: {}, patches: new Map(), intervals: null, removed: [], order: null, kept: [] };
  const decide = (now: unknown, sides: Sides<unknown>, what: string): boolean => {
    if (asLong(now, sides[to])) return false;
    if (asLong(now, sides[from])) return true;
    plan.kept.push(what);
    return false;
  };
  for (const [field, sides] of changes.scene) if (decide(fieldOf(view, field), sides, words[field])) plan.scene[field] = sides[to];
  // Where colours follow the array by themselves, they go on following it.
  if (!view.colorBy && plan.scene.colorBy === (plan.scene.array ?? view.array)) delete plan.scene.colorBy;
  if (!view.texture && plan.scene.texture === (plan.scene.colorBy || view.colorBy || plan.scene.array || view.array)) delete plan.scene.texture;
  for (const [id, fields] of changes.fields) {
    const layer = view.intervals.find((interval) => interval.id === id);
    if (!layer) continue; // somebody has deleted it
    const patch = [...fields].filter(([field, sides]) => decide(layer[field] ?? null, sides, `${words[field]} of ${nameIn(view, id)}`));
    if (patch.length > 0) plan.patches.set(id, Object.fromEntries(patch.map(([field, sides]) => [field, sides[to]])));
  }
  planLayers(plan, changes, view, to);
  if (changes.order) {
    const now = priorityOrder(view.intervals);
    const target = among(changes.order[to], now);
    const expected = among(changes.order[from], now);
    if (target.join() !== among(now, target).join()) {
      if (expected.join() === among(now, expected).join()) plan.order = now.map((id) => (target.includes(id) ? (target[among(now, target).indexOf(id)] as number) : id));
      else plan.kept.push(words.order);
    }
  }
  return plan;
}
function planLayers(plan: Plan, changes: Changes, view: SceneState, to: Side): void {
  const back: Interval[] = [];
  for (const [id, sides] of changes.layers) {
    const now = view.intervals.find((interval) => interval.id === id);
    const [target, was] = [sides[to], sides[to === 'before' ? 'after' : 'before']];
    if (!target && now) {
      if (was && layerFields.every((field) => asLong(now[field] ?? null, was[field] ?? null))) plan.removed.push(id);
      else plan.kept.push(nameIn(view, id));
    } else if (target && !now) back.push({ ...target, id });
  }
  if (back.length === 0) return;
  const stays = view.intervals.filter(({ id }) => !plan.removed.includes(id));
  const all = [...stays, ...back];
  const wanted = withReturned(idsOf({ intervals: stays }), idsOf({ intervals: back }), changes.listed[to]);
  plan.intervals = wanted.map((id) => all.find((layer) => layer.id === id) as Interval);
  // Priorities are kept as numbers as long as these say the right order.
  const ranked = withReturned(priorityOrder(stays), idsOf({ intervals: back }), changes.ranked[to]);
  if (priorityOrder(plan.intervals).join() !== ranked.join())
    plan.intervals = plan.intervals.map((layer) => ({ ...layer, priority: ranked.length - 1 - ranked.indexOf(layer.id) }));
}
/** Each behind the nearest of those that stood before it and are there. */
function withReturned(there: readonly number[], back: readonly number[], stood: readonly number[]): number[] {
  const all = [...there];
  for (const id of [...back].sort((a, b) => stood.indexOf(a) - stood.indexOf(b))) {
    const earlier = stood.slice(0, stood.indexOf(id)).reverse().find((other) => all.includes(other));
    all.splice(earlier === undefined ? 0 : all.indexOf(earlier) + 1, 0, id);
  }
  return all;
}
export const doesNothing = ({ scene, patches, intervals, removed, order }: Plan): boolean =>
  Object.keys(scene).length + patches.size + removed.length === 0 && !intervals && !order;

const words: Record<SceneField | keyof IntervalPatch | 'order', string> = {
  array: 'the array', values: 'the values', colorBy: 'the array of colours', texture: 'the array of textures', step: 'the time step', time: 'the time',
  timeMode: 'what is between steps', terms: 'the combination', mode: 'the mode', smear: 'the smear', clipPlanes: 'the cuts', annotations: 'what is drawn in',
  colorRange: 'the range of colours', background: 'the background', unitDistance: 'the unit distance', occlusion: 'the occlusion', depthFade: 'the depth fade',
  bodyShading: 'the body shading', axisScale: "the axes' scale", lower: 'the range', upper: 'the range', color: 'the colour', colorMap: 'the colour', opacity: 'the opacity', visible: 'the visibility',
  opacityUpper: 'the opacity', ownRange: 'the range of colours', surface: 'the surface', name: 'the name', transfer: 'the function', order: 'the order of the layers',
};
const nameIn = (state: Pick<SceneState, 'intervals'>, id: number) =>
  state.intervals.find((interval) => interval.id === id)?.name || layerNumber(state.intervals, id);

/** What the step was, for a person: "the range of Layer 2". */
export function wordsOf(changes: Changes, view: Pick<SceneState, 'intervals'>): string {
  const [field] = changes.scene.keys();
  if (field) return words[field];
  const [came] = changes.layers;
  if (came && changes.layers.size > 1) return 'the layers';
  if (came) return `${came[1].before ? 'deleting' : 'adding'} ${nameIn({ intervals: [came[1].before ?? came[1].after].filter((layer) => layer !== null) }, came[0])}`;
  const [changed] = changes.fields;
  if (!changed) return words.order;
  return changes.fields.size > 1 ? 'the layers' : `${words[[...changed[1].keys()][0] as keyof IntervalPatch]} of ${nameIn(view, changed[0])}`;
}
