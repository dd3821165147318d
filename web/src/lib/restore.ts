// A restarted server knows nothing of the old session: this says what to send so that the picture returns.
import { command, type Command } from './commands';
import type { Range, SceneState } from './model';
import type { DatasetEntry, DatasetInfo } from './told';

export type RestoreStep =
  | { kind: 'send'; commands: Command[]; done: boolean }
  | { kind: 'wait' } // for the dataset to be opened
  | { kind: 'impossible'; lacks: 'dataset' | 'array'; reason: string };

/** The next thing to do, given what was saved and where the new session stands. Called again with every State and DatasetInfo. */
export function restoreStep(
  saved: SceneState,
  current: SceneState,
  info: DatasetInfo | null,
  datasets: readonly Pick<DatasetEntry, 'id' | 'name'>[],
  opened: boolean,
  all = datasets.length, // that there are, of which these are the first
): RestoreStep {
  if (saved.dataset === '') return { kind: 'send', commands: [], done: true };
  if (current.dataset !== saved.dataset) {
    if (opened) return { kind: 'wait' };
    if (all <= datasets.length && !datasets.some((entry) => entry.id === saved.dataset.split('@')[0]))
      return { kind: 'impossible', lacks: 'dataset', reason: `The server no longer has the dataset “${saved.dataset}”.` };
    return { kind: 'send', commands: [command.openDataset(saved.dataset)], done: false };
  }
  if (info?.id !== saved.dataset) return { kind: 'wait' };

  const has = (name: string) => info.arrays.some((array) => array.name === name);
  if (!has(saved.array)) return { kind: 'impossible', lacks: 'array', reason: `The dataset no longer has the array “${saved.array}”.` };
  const commands: Command[] = clearing(current);
  // No name at all leaves the array that colours run over as it is.
  const colorBy = has(saved.colorBy) ? saved.colorBy : current.colorBy && saved.array;
  commands.push(command.selectArrays(saved.array, colorBy, '', saved.values ?? (current.values === 'whole' ? 'interpolated' : null)));
  const moved = saved.step !== current.step || (current.time ?? null) !== null;
  if (moved && saved.step < Math.max(info.times.length, 1)) commands.push(command.setTimeStep(saved.step));
  // New ids: those of the old session mean nothing to the new one.
  commands.push(command.setIntervals(saved.intervals.map((interval) => ({ ...interval, id: 0 }))));
  if (saved.texture && has(saved.texture)) commands.push(command.selectArrays('', '', saved.texture));
  if (saved.terms?.length && saved.terms.every((term) => has(term.array))) commands.push(command.setCombination(saved.terms));
  const last = info.times.at(-1) ?? 0;
  const timeFits = saved.time == null || (saved.time >= (info.times[0] ?? 0) && saved.time <= last);
  if (saved.timeMode && timeFits && ((saved.time ?? null) !== null || saved.timeMode !== 'step')) commands.push(command.setTime(saved.time ?? null, saved.timeMode));
  if (saved.cycle && saved.mode === 'cycled') commands.push(command.setCycle({ ...saved.cycle, seconds: Math.max(saved.cycle.seconds, 1 / 3) }));
  const smear = saved.smear ? { ...saved.smear, times: saved.smear.times ?? [] } : null; // of an older page without times
  const smearFits = smear?.steps.every((s) => s < info.times.length) && smear.times.every((t) => t >= (info.times[0] ?? 0) && t <= last);
  if (smear && smearFits && smear.steps.length + smear.times.length + current.smear.colors.length > 0) commands.push(command.setSmear(smear));
  commands.push(
    command.setAppearance({
      mode: saved.mode,
      background: saved.background,
      unitDistance: saved.unitDistance,
      occlusion: saved.occlusion ?? 0,
      depthFade: saved.depthFade ?? 0,
      bodyShading: saved.bodyShading ?? 0,
      axisScale: saved.axisScale ?? [1, 1, 1],
      ...(saved.colorRange ? { colorRange: saved.colorRange } : {}),
    }),
  );
  if (saved.clipPlanes?.length || current.clipPlanes?.length) commands.push(command.setClipPlanes(saved.clipPlanes ?? []));
  if (saved.annotations) commands.push(command.setAnnotations(saved.annotations));
  if (saved.camera) commands.push(command.setCamera(saved.camera));
  return { kind: 'send', commands, done: true };
}

/** What stands in the way of what is to come, where a scene is replaced and not begun. */
function clearing(current: SceneState): Command[] {
  const commands: Command[] = [];
  if (current.terms.length > 0) commands.push(command.setCombination([]));
  if (current.timeMode !== 'step') commands.push(command.setTime(null, 'step'));
  if (current.smear.steps.length + current.smear.times.length > 0) commands.push(command.setSmear({ steps: [], times: [], colors: [] }));
  if (current.intervals.some((interval) => interval.transfer)) commands.push(command.setIntervals([]));
  return commands;
}

/** As it is stored: JSON has no infinities, and an interval's end may be one. */
export const savedStateText = (state: SceneState): string =>
  JSON.stringify(state, (_, value) => (value === Infinity ? 'inf' : value === -Infinity ? '-inf' : value));
const openEnds = (key: string, value: unknown): unknown =>
  key !== 'lower' && key !== 'upper' ? value : value === 'inf' ? Infinity : value === '-inf' ? -Infinity : value;

/** A state out of storage, or null if it is not one: what was stored is not trusted. */
export function parseSavedState(text: string | null): SceneState | null {
  if (!text) return null;
  try {
    const value = JSON.parse(text, openEnds) as unknown;
    return isState(value) ? value : null;
  } catch {
    return null;
  }
}
export function isState(of: unknown): of is SceneState {
  const numbers = (...xs: unknown[]) => xs.every((x) => typeof x === 'number' && Number.isFinite(x));
  const value = of as SceneState;
  return (
    typeof of === 'object' &&
    of !== null &&
    typeof value.dataset === 'string' &&
    typeof value.array === 'string' &&
    typeof value.colorBy === 'string' &&
    Array.isArray(value.background) &&
    numbers(value.step, value.unitDistance, ...value.background) &&
    Array.isArray(value.intervals) &&
    value.intervals.every((i: Range & { opacity: number }) => typeof i.lower === 'number' && typeof i.upper === 'number' && numbers(i.opacity) && i.lower < i.upper)
  );
}
