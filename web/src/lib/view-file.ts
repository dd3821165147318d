// A view as a file: the State as canonical JSON, as REST gives it and `isostrata render --state` takes it.
import { fromJson, toJson, type JsonValue } from '@bufbuild/protobuf';
import { StateSchema } from '../gen/isostrata/v1/isostrata_pb';
import type { SceneState } from './model';
import { stateOf, wireState } from './wire-scene';

export const viewText = (state: SceneState): string => `${JSON.stringify(toJson(StateSchema, wireState(state)), null, 1)}\n`;

/** The scene of such a text, or why there is none. */
export function viewOf(text: string): SceneState | string {
  let json: JsonValue;
  try {
    json = JSON.parse(text) as JsonValue;
  } catch {
    return 'it is no JSON. Expected a file that Save view has written.';
  }
  try {
    const state = stateOf(fromJson(StateSchema, shortEnds(json), { ignoreUnknownFields: true }));
    if (!state.dataset || !state.array) return `it names no ${state.dataset ? 'array' : 'dataset'}. Expected a file that Save view has written.`;
    return problemIn(state) ?? state;
  } catch (problem) {
    const words = problem instanceof Error ? problem.message.replaceAll('isostrata.v1.', '') : '';
    return `it is no view${words ? ` (${words.slice(0, 200)})` : ''}.`;
  }
}

/** What the server would refuse after it has taken the half of it. */
function problemIn({ intervals }: SceneState): string | null {
  for (const [i, { lower, upper, opacity, transfer, number }] of intervals.entries()) {
    const name = `layer ${number || i + 1}`;
    if (!transfer && !(lower < upper)) return `${name} begins at ${lower} and ends at ${upper}. Expected an end above the beginning.`;
    if (!(opacity >= 0 && opacity <= 1)) return `${name} has the opacity ${opacity}. Expected one from 0 to 1.`;
  }
  return null;
}

/** Ends may be written "inf", "-inf" or null, as scripts do. */
function shortEnds(value: JsonValue, key = ''): JsonValue {
  if (Array.isArray(value)) return value.map((item) => shortEnds(item));
  if (value && typeof value === 'object') return Object.fromEntries(Object.entries(value).map(([name, item]) => [name, shortEnds(item, name)]));
  if (key !== 'lower' && key !== 'upper') return value;
  if (value === null) return key === 'lower' ? '-Infinity' : 'Infinity';
  return value === 'inf' ? 'Infinity' : value === '-inf' ? '-Infinity' : value;
}
