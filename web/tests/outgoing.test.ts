import { expect, test } from 'vitest';
import { command, type Command } from '../src/lib/commands';
import { Outgoing } from '../src/lib/outgoing';
import { seeded } from './random';

/** A line that can break, on a ticked clock: what went over it, with the numbers of what may go again. */
function harness() {
  const sent: { body: Command; number: number }[] = [];
  const clock = { now: 0 };
  let due: (() => void)[] = [];
  const out = new Outgoing({
    send: (body, number) => sent.push({ body, number }),
    now: () => clock.now,
    schedule: (callback) => due.push(callback),
  });
  const screen = () => {
    const now = due;
    due = [];
    for (const callback of now) callback();
  };
  const numbers = () => sent.flatMap(({ number }) => (number ? [number] : []));
  return { out, sent, clock, screen, numbers };
}
const step = (n: number) => command.setTimeStep(n);

test('nothing goes before the welcome, and what changes the session goes after it', () => {
  const { out, sent, numbers } = harness();
  expect(out.send(command.removeInterval(1))).toBe(0);
  expect(out.send(command.requestHistogram('Density', 8))).toBe(0);
  out.welcomed(true);
  out.resend(0);
  expect(sent.map(({ body }) => body.case)).toEqual(['removeInterval']);
  expect(numbers()).toEqual([1]);
});

test('whenever the line breaks, the session has every command at the end, each once and in order', () => {
  for (let seed = 1; seed <= 200; seed++) {
    const random = seeded(seed);
    const { out, sent } = harness();
    let judged = 0; // by the session, which ignores what it has judged
    const done: number[] = [];
    const arrives = () => {
      for (const { body, number } of sent.splice(0))
        if (number > judged && body.case === 'removeInterval') {
          judged = number;
          done.push(body.value.id ?? 0);
        }
    };
    out.welcomed(true);
    for (let id = 1; id <= 20; id++) {
      if (random() < 0.2) {
        if (random() < 0.5) arrives(); // or is lost on the way
        sent.length = 0;
        out.lost();
      }
      if (!out.live && random() < 0.5) {
        out.welcomed(true);
        out.resend(judged);
      }
      out.send(command.removeInterval(id));
    }
    arrives();
    out.lost();
    out.welcomed(true);
    out.resend(judged);
    arrives();
    expect(done, `seed ${seed}`).toEqual(Array.from({ length: 20 }, (_, i) => i + 1));
  }
});

test('another session gets nothing of what was meant for the old one, waiting or sent', () => {
  const { out, sent, screen } = harness();
  out.welcomed(true);
  out.send(command.removeInterval(1));
  out.slots.put('step', step(3));
  out.lost();
  sent.length = 0;
  out.welcomed(false);
  out.resend(0);
  screen();
  expect(sent).toEqual([]);
});

test('what must come after a stream takes it along', () => {
  const { out, sent, screen } = harness();
  out.welcomed(true);
  out.slots.put('step', step(3));
  out.sendInOrder(command.setView('+x'));
  screen();
  expect(sent.map(({ body }) => body.case)).toEqual(['setTimeStep', 'setView']);
});

test('a refusal is about what the message was about, and the command is not tried again', () => {
  const { out, sent } = harness();
  out.welcomed(true);
  const seq = out.send(command.patchInterval(7, { upper: 2 }));
  expect(out.refused(seq)).toEqual({ place: 'layers', interval: 7 });
  expect(out.refused(999)).toEqual({ place: 'page', interval: null });
  out.lost();
  sent.length = 0;
  out.welcomed(true);
  out.resend(0);
  expect(sent).toEqual([]);
});

test('cameras wait for frames, for a quarter of a second at most', () => {
  const { out, sent, screen, clock } = harness();
  out.welcomed(true);
  const turn = (x: number) => {
    out.slots.putCamera({ eye: [x, 0, 5], at: [0, 0, 0], up: [0, 1, 0], fovDeg: 30 });
    screen();
  };
  for (let x = 1; x <= 5; x++) turn(x);
  expect(sent).toHaveLength(3);
  out.answered(1);
  screen();
  expect(sent).toHaveLength(4);
  turn(6);
  expect(sent).toHaveLength(4);
  clock.now += 250;
  screen();
  expect(sent).toHaveLength(5);
});
