import { describe, expect, test } from 'vitest';
import { noSurface, stepRange, type SceneState } from '../src/lib/model';
import { datasetHere } from '../src/lib/dataset-here';
import { viewOf, viewText } from '../src/lib/view-file';
import { seeded } from './random';

/** With everything that a state can have. */
function rich(random: () => number): SceneState {
  const f32 = () => Math.fround(random());
  const rgb = () => [f32(), f32(), f32()] as const;
  const pick = <T>(...of: T[]) => of[Math.floor(random() * of.length)] as T;
  return {
    revision: Math.floor(random() * 1e6), dataset: 'a/b.vti', array: 'ρ', colorBy: pick('', 'p'), texture: pick('', 'q'), step: 3, time: pick(null, random()),
    timeMode: pick('step', 'interpolate', 'spacetime'), values: pick('interpolated', 'whole'), mode: pick('sorted', 'prioritized', 'cycled', 'smear'),
    background: rgb(), unitDistance: random(), occlusion: random(), depthFade: random(), bodyShading: random(), axisScale: [1, 1 + random(), random()],
    camera: pick(null, { eye: [random(), 1, 2], at: [0, random(), 0], up: [0, 0, 1], fovDeg: 25, orthographic: pick(true, false) }),
    annotations: { axes: pick(true, false), box: true, legend: false }, clipPlanes: pick([], [{ normal: [0, random(), 1], offset: random() }]),
    colorRange: pick(stepRange, { span: 'own' as const, lower: 1, upper: 2 + random(), log: true }),
    cycle: { seconds: 2, phase: random(), playing: false }, smear: { steps: pick([], [1, 2]), times: [], colors: [rgb()] },
    terms: pick([], [{ op: 'subtract' as const, array: 'p', lower: -Infinity, upper: random(), color: pick(null, rgb()), colorMap: '', opacity: pick(null, 0.5), priority: pick(null, -2), hidden: true }]),
    intervals: [
      { id: 4, lower: pick(-Infinity, 0.5), upper: pick(Infinity, 2), color: rgb(), colorMap: 'viridis', opacity: random(), opacityUpper: pick(null, 0, 1), priority: -1, visible: false,
        ownRange: true, name: 'Haut', number: 2, surface: pick(null, { ...noSurface, lower: true, color: pick(null, rgb()), silhouette: random() }),
        transfer: pick(null, [{ value: 0, color: rgb(), opacity: 0 }, { value: 1, color: rgb(), opacity: 1 }]) },
    ],
  };
}

describe('a view as a file', () => {
  test('is read as it was written, whatever is in it', () => {
    for (let seed = 1; seed <= 200; seed++) {
      const state = rich(seeded(seed));
      expect(viewOf(viewText(state)), `seed ${seed}`).toEqual(state);
    }
  });

  test('takes ends as scripts write them, and fields of a later version', () => {
    const view = viewOf('{"dataset":"d","array":"a","later":1,"intervals":[{"lower":"-inf","upper":null,"opacity":1}]}');
    expect(view).toMatchObject({ intervals: [{ lower: -Infinity, upper: Infinity }] });
  });

  test('finds its dataset on another machine by the name of the file, if only one has it', () => {
    const entries = (...ids: string[]) => ids.map((id) => ({ id, name: id }));
    const here = entries('can-c51c90', 'head-000001', 'head-000002');
    expect(datasetHere('can-c51c90', here, '')?.id).toBe('can-c51c90');
    expect(datasetHere('can-0a0a0a', here, '')?.id).toBe('can-c51c90');
    expect(datasetHere('head-0a0a0a', here, '')).toBe(null);
    expect(datasetHere('head-0a0a0a', here, 'head-000002')?.id).toBe('head-000002');
    expect(datasetHere('other-c51c90', here, '')).toBe(null);
    expect(datasetHere('can-c51c90@0:4,:,:', here, '')?.id).toBe('can-c51c90');
  });

  test('says what is wrong with another file', () => {
    for (const [text, words] of [
      ['not json', /no JSON/],
      ['[1]', /no view/],
      ['"x"', /no view/],
      ['{}', /no dataset/],
      ['{"dataset":"d"}', /no array/],
      ['{"dataset":"d","array":"a","step":"soon"}', /no view \(.*State\.step.*soon/],
      ['{"dataset":"d","array":"a","intervals":[{"lower":5,"upper":3}]}', /layer 1 begins at 5 and ends at 3/],
      ['{"dataset":"d","array":"a","intervals":[{"lower":"NaN","upper":3}]}', /layer 1 begins at NaN/],
      ['{"dataset":"d","array":"a","intervals":[{"lower":1,"upper":3,"opacity":7,"number":4}]}', /layer 4 has the opacity 7/],
      ['{"dataset":"d","array":"a","intervals":[{"lower":[]}]}', /no view \(.*Interval\.lower/],
    ] as const) {
      const problem = viewOf(text);
      expect(problem, text).toEqual(expect.stringMatching(words));
      expect(problem, text).not.toContain('isostrata.v1');
    }
  });
});
