// A layer in numbers: who asks, what is kept, when it is of what was.
import { create, toBinary } from '@bufbuild/protobuf';
import { describe, expect, test } from 'vitest';
import { ServerMessageSchema } from '../src/gen/isostrata/v1/isostrata_pb';
import type { Command } from '../src/lib/commands';
import { decodeEvent } from '../src/lib/events';
import { measureKey, Measures, statisticsTable, statisticsText } from '../src/lib/measures.svelte';
import { emptyState, type Interval, type SceneState } from '../src/lib/model';
import type { LayerStatistics } from '../src/lib/told';
import { seeded } from './random';

const layer = (id: number, more: Partial<Interval> = {}): Interval => ({ id, lower: 0, upper: 1, color: [1, 0, 0], colorMap: '', opacity: 0.5, priority: id, visible: true, number: id, ...more });
const scene = (more: Partial<SceneState> = {}): SceneState => ({ ...emptyState, dataset: 'd', array: 'f', ...more });
const numbers = (more: Partial<LayerStatistics> = {}): LayerStatistics => ({
  revision: 3, interval: 1, array: 'f', flat: false, volume: 2, centroid: [0, 1 / 3, 0], pieces: 2, largest: 1.5, valued: 2, lower: 0, upper: 1, mean: 0.25, standardDeviation: 0.125, ...more,
});

describe("a layer's numbers", () => {
  test('go to the layer that was asked of, of its newest question', () => {
    const sent: Command[] = [];
    const one = new Measures((body) => sent.push(body));
    one.ask(scene(), layer(1), '');
    one.ask(scene(), layer(2), 'g');
    expect(sent).toEqual([{ case: 'requestLayerStatistics', value: { interval: 1, array: '' } }]); // a second one would end the first
    one.ask(scene(), layer(1), 'g');
    expect(sent[1]).toEqual({ case: 'requestLayerStatistics', value: { interval: 1, array: 'g' } });
    expect(one.answered(1, 'another took its place')).toBe(true);
    expect(one.list.get(1)?.answer).toBeNull();
    expect(sent).toHaveLength(2);
    expect(one.answered(2, numbers())).toBe(true);
    expect(one.list.get(1)?.answer).toEqual(numbers());
    expect(sent[2]).toEqual({ case: 'requestLayerStatistics', value: { interval: 2, array: 'g' } });
    one.close(2);
    expect(one.answered(3, numbers())).toBe(true);
    expect([...one.list.keys()]).toEqual([1]);
    expect(one.answered(9, 'of something else')).toBe(false);
    one.ask(scene(), layer(2), '');
    one.lost();
    expect(one.list.get(1)?.answer).toEqual(numbers());
    one.restore(scene({ intervals: [layer(1), layer(2), layer(5)] }), [...one.open, [5, 'g'], [6, '']]);
    expect(one.answered(5, numbers())).toBe(true);
    expect(sent.slice(4)).toEqual([
      { case: 'requestLayerStatistics', value: { interval: 2, array: '' } },
      { case: 'requestLayerStatistics', value: { interval: 5, array: 'g' } }, // there is no layer 6
    ]);
    one.clear();
    expect([one.open, one.answered(6, numbers())]).toEqual([[], false]);
  });

  test('have all their answers in the end, whoever asks how often and closes what, and no two questions are on their way', () => {
    for (let seed = 1; seed <= 100; seed++) {
      const random = seeded(seed);
      const open = new Map<number, number>(); // on their way: of which layer
      let seq = 0;
      const one = new Measures((body) => {
        const { interval } = body.value as { interval: number };
        open.set(++seq, interval);
        expect(new Set(open.values()).size, `seed ${seed}`).toBe(1);
        return seq;
      });
      const answer = () => {
        const [first, interval] = [...open][0]!;
        open.delete(first);
        one.answered(first, numbers({ interval }));
      };
      for (let i = 0; i < 40; i++) {
        const id = 1 + Math.floor(4 * random());
        const what = random();
        if (what < 0.5) one.ask(scene(), layer(id), random() < 0.5 ? 'g' : '');
        else if (what < 0.7) one.close(id);
        else if (open.size) answer();
      }
      while (open.size) answer();
      for (const [id, { answer }] of one.list) expect(answer, `seed ${seed}, layer ${id}`).toMatchObject({ interval: id });
    }
  });

  test('are old when what they were measured of changes, and not when it looks otherwise', () => {
    const key = measureKey(scene(), layer(1), '');
    expect(measureKey(scene({ revision: 9, colorBy: 'g' }), layer(1, { opacity: 1, name: 'x' }), 'f')).toBe(key);
    for (const other of [measureKey(scene({ step: 1 }), layer(1), ''), measureKey(scene(), layer(1, { upper: Infinity }), ''), measureKey(scene({ array: 'g' }), layer(1), ''), measureKey(scene(), layer(1), '', 1)])
      expect(other).not.toBe(key);
  });

  test('come as the server says them and go as a table', () => {
    const value = { inReplyTo: 5n, revision: 3n, interval: 1, array: 'f', volume: 2, centroid: { x: 0, y: 1 / 3, z: 0 }, pieces: 2n, largest: 1.5, valued: 2, upper: 1, mean: 0.25, standardDeviation: 0.125 };
    const event = decodeEvent(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body: { case: 'layerStatistics', value } })));
    expect(event).toMatchObject({ kind: 'layerStatistics', inReplyTo: 5, statistics: numbers() });
    expect(statisticsText(numbers(), 'shell').split('\n')).toEqual([
      'layer\tshell', 'volume\t2', 'centroid\t0\t0.3333333333333333\t0', 'pieces\t2', 'volume of the largest piece\t1.5', 'array\tf', 'mean\t0.25', 'standard deviation\t0.125', 'least\t0', 'greatest\t1',
    ]);
    const box = { lower: [-1, -1, -1] as const, upper: [1, 1, 1] as const };
    expect(statisticsText(numbers({ centroid: [5.6e-15, -3e-13, 1e-9] }), 'shell', { bounds: box })).toContain('centroid\t0\t0\t1e-9\n');
    const axes = [false, false, true].map((downward) => ({ name: '', unit: '', downward }));
    expect(statisticsText(numbers({ centroid: [1, 2, -850] }), 'shell', { bounds: box, axes })).toContain('centroid\t1\t2\t850\n');
    expect(statisticsText(numbers({ flat: true, valued: 0 }), 'shell')).toContain('area with values\t0');
    expect(statisticsText(numbers({ valued: 0 }), 'shell')).not.toContain('mean');
  });

  test('of several layers are a table: a row for each, and nothing where there is no value', () => {
    const lines = statisticsTable(
      [
        { name: 'shell, outer', lower: 0.1, upper: Infinity, of: numbers() },
        { name: 'core', lower: 0, upper: 0.1, of: numbers({ volume: 0, valued: 0, pieces: 0, largest: 0 }) },
      ],
      null,
    ).split('\r\n');
    expect(lines).toEqual([
      'layer,lower end,upper end,array,mean,standard deviation,least,greatest,volume or area,with values,centroid x,centroid y,centroid z,pieces,largest piece',
      '"shell, outer",0.1,,f,0.25,0.125,0,1,2,2,0,0.3333333333333333,0,2,1.5',
      'core,0,0.1,f,,,,,0,0,,,,0,0',
      '',
    ]);
    expect(new Set(lines.slice(2, 3).map((line) => line.split(',').length))).toEqual(new Set([lines[0]!.split(',').length]));
  });
});
