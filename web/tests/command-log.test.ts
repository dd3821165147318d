import { describe, expect, test } from 'vitest';
import { CommandLog } from '../src/lib/command-log';
import { command } from '../src/lib/commands';

const camera = (x: number) => command.setCamera({ eye: [x, 0, 9], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 30 });
const never = () => false;
const numbers = (log: CommandLog, last = 0) => log.missing(last).map(({ number }) => number);

describe('the log of commands', () => {
  test('holds the newest camera of thousands', () => {
    const log = new CommandLog();
    for (let i = 0; i < 5000; i++) log.add(camera(i));
    expect(log.missing(0)).toMatchObject([{ number: 5000, body: camera(4999) }]);
  });

  test('merges the patches of one interval, and opacity at the top set and cleared are not both said', () => {
    const log = new CommandLog();
    log.add(command.patchInterval(1, { upper: 5 }));
    log.add(command.patchInterval(2, { upper: 9 }));
    log.add(command.patchInterval(1, { lower: 4, opacityUpper: null }));
    log.add(command.patchInterval(1, { upper: 6, opacityUpper: 0.5 }));
    expect(log.missing(0).map(({ body }) => body.value)).toEqual([
      { id: 2, upper: 9 },
      { id: 1, lower: 4, upper: 6, opacityUpper: 0.5 },
    ]);
  });

  test('gives a connection that stands only what is new, and after a loss only the fields that are missing', () => {
    const log = new CommandLog();
    log.add(command.patchInterval(1, { lower: 1 }));
    log.add(command.patchInterval(1, { upper: 2 }));
    log.add(command.patchInterval(1, { upper: 3 }));
    // The first has arrived, and somebody else may have moved that end since.
    expect(log.missing(1).map(({ number, body }) => [number, body.value])).toEqual([[3, { id: 1, upper: 3 }]]);
  });

  test('keeps the order with commands that others may depend on', () => {
    const log = new CommandLog();
    log.add(command.patchInterval(1, { upper: 5 }));
    log.add(command.removeInterval(2));
    log.add(command.patchInterval(1, { upper: 6 }));
    log.add(camera(1));
    log.add(command.patchInterval(1, { upper: 7 }));
    expect(log.missing(0).map(({ number, body }) => [number, body.case])).toEqual([
      [1, 'patchInterval'],
      [2, 'removeInterval'],
      [4, 'setCamera'],
      [5, 'patchInterval'],
    ]);
  });

  test('does not take a change of one thing for a change of another of the same kind', () => {
    const log = new CommandLog();
    log.add(command.setAppearance({ background: [1, 1, 1] }));
    log.add(command.setAppearance({ unitDistance: 2 }));
    log.add(command.setAppearance({ unitDistance: 3 }));
    expect(numbers(log)).toEqual([1, 3]);
  });

  test('forgets what the server has had for a while, and nothing that was never sent', () => {
    const log = new CommandLog(200, 1000);
    const [first, second] = [log.add(command.setView('+x')), log.add(command.setView('+y'))];
    log.add(command.setView('+z'));
    first.sentMs = 0;
    second.sentMs = 500;
    log.heard(999, never);
    expect(log.length).toBe(3);
    log.heard(1000, never);
    expect(numbers(log)).toEqual([2, 3]);
    log.heard(1e9, never);
    expect(numbers(log)).toEqual([3]);
  });

  test('keeps what may still wait for a dataset, with all after it', () => {
    const log = new CommandLog(200, 0);
    for (const body of [command.setView('+x'), command.openDataset('big'), command.setView('+y')]) log.add(body).sentMs = 0;
    log.heard(1e9, (body) => body.case === 'openDataset');
    expect(numbers(log)).toEqual([2, 3]);
    log.heard(1e9, never);
    expect(log.length).toBe(0);
  });

  test('is bounded, and the oldest goes first', () => {
    const log = new CommandLog(10);
    for (let i = 1; i <= 25; i++) log.add(command.setView('+x'));
    expect(numbers(log)).toEqual([16, 17, 18, 19, 20, 21, 22, 23, 24, 25]);
  });

  test('keeps nothing that concerns one connection alone', () => {
    expect(CommandLog.keeps(command.ping(1))).toBe(false);
    expect(CommandLog.keeps(command.interaction(true))).toBe(false);
    expect(CommandLog.keeps(camera(1))).toBe(true);
  });
});
