import { describe, expect, test } from 'vitest';
import { MadeFile } from '../src/lib/made-file.svelte';

/** A server that answers in turn; what it was asked, and what was saved. */
function exportsOf(answers: ({ ok?: boolean; body: object | ReadableStream; bytes?: number } | 'lost')[]) {
  const asked: string[] = [];
  const saved: string[] = [];
  const exports = new MadeFile({
    ask: (path, method, body, signal) => {
      asked.push([method, path, body ?? ''].join(' ').trim());
      const answer = method === 'DELETE' ? 'lost' : answers.shift();
      if (!answer || answer === 'lost') return Promise.reject(new TypeError('Failed to fetch'));
      const { body: told, ok = true, bytes = 0 } = answer;
      const options = { status: ok ? 200 : 409, headers: { 'Content-Length': String(bytes) } };
      if (!(told instanceof ReadableStream)) return Promise.resolve(new Response(JSON.stringify(told), options));
      const line = new TransformStream(); // which the signal cuts
      told.pipeTo(line.writable, { ...(signal ? { signal } : {}) }).catch(() => {});
      return Promise.resolve(new Response(line.readable, options));
    },
    save: (file, name) => saved.push(`${name}: ${file.size}`),
    wait: () => Promise.resolve(),
  });
  return { exports, asked, saved };
}
const running = { body: { id: 'e1', status: 'running' } };
const done = { body: { id: 'e1', status: 'done' } };
const file = { body: new Blob(['mesh']).stream(), bytes: 4 };
/** A file whose pieces come when they are given. */
function slowFile(bytes: number) {
  let give: (piece: number | null) => void = () => {};
  const body = new ReadableStream({ start: (to) => void (give = (piece) => (piece === null ? to.close() : to.enqueue(new Uint8Array(piece)))) });
  return { answer: { body, bytes }, give: async (piece: number | null) => (give(piece), await new Promise((rest) => setTimeout(rest, 5))) };
}

describe('a mesh file of the layers', () => {
  test('is asked for, waited for and saved, and the server need not keep it', async () => {
    const { exports, asked, saved } = exportsOf([running, running, done, file]);
    const answer = exports.save('s', 'exports', { format: 'ply' }, 'torus.ply');
    expect(exports.waits).toBe(true);
    expect(await answer).toBe('');
    expect(exports.waits).toBe(false);
    const [one, its] = ['sessions/s/operations/e1', 'sessions/s/exports/e1'];
    expect(asked).toEqual(['POST sessions/s/exports {"format":"ply"}', `GET ${one}`, `GET ${one}`, `GET ${its}`, `DELETE ${its}`]);
    expect(saved).toEqual(['torus.ply: 4']);
  });

  test('that does not come says why, and the next one can be asked for', async () => {
    const refusal = { ok: false, body: { detail: 'this session has 4 exports already' } };
    for (const [answers, why] of [
      [[refusal], 'this session has 4 exports already'],
      [[running, { body: { id: 'e1', status: 'failed', error: { detail: 'no space' } } }], 'no space'],
      [[running, { body: { id: 'e1', status: 'cancelled' } }], 'Cancelled.'],
      [[running, done, { ok: false, body: {} }], 'the server does not have it any more'],
      [[running, done, 'lost'], 'the connection was lost'],
      [[running, 'lost'], 'the connection was lost'],
      [['lost'], 'the connection was lost'],
    ] as const) {
      const { exports, asked, saved } = exportsOf([...answers]);
      expect(await exports.save('s', 'exports', { format: 'vtu' }, 'torus.vtu')).toBe(why);
      expect(saved).toEqual([]);
      expect(exports.waits).toBe(false);
      expect(asked.filter((of) => of.startsWith('DELETE'))).toHaveLength(answers.length > 1 ? 1 : 0);
    }
  });

  test('says how much of it has come over the line, which can be cancelled', async () => {
    for (const cancels of [false, true]) {
      const slow = slowFile(30);
      const { exports, asked, saved } = exportsOf([running, done, slow.answer]);
      const answer = exports.save('s', 'exports', { format: 'ply' }, 'torus.ply');
      await slow.give(10);
      expect(exports.coming).toEqual({ bytes: 10, of: 30 });
      await slow.give(15);
      expect(exports.coming).toEqual({ bytes: 25, of: 30 });
      if (cancels) exports.cancel();
      else {
        await slow.give(5);
        await slow.give(null);
      }
      expect(await answer).toBe(cancels ? 'Cancelled.' : '');
      expect(saved).toEqual(cancels ? [] : ['torus.ply: 30']);
      expect([exports.coming, exports.waits]).toEqual([null, false]);
      expect(asked.at(-1)).toBe('DELETE sessions/s/exports/e1');
    }
  });

  test('that is still being made says how far it is, and is ended by the server if it is cancelled', async () => {
    const part = (fraction: number) => ({ body: { id: 'f1', status: 'running', stage: '180 pictures', fraction } });
    const { exports: film, asked, saved } = exportsOf([part(0), part(0.25), part(0.5), part(0.75)]);
    const told: (number | undefined)[] = [];
    film['doors'].wait = () => {
      told.push(film.making?.fraction);
      if (told.length === 3) film.cancel();
      return Promise.resolve();
    };
    expect(await film.save('s', 'films', { turnDeg: 360 }, 'turn.webm')).toBe('Cancelled.');
    expect(told).toEqual([0, 0.25, 0.5]);
    expect([film.making, film.waits, saved]).toEqual([null, false, []]);
    expect(asked[0]).toBe('POST sessions/s/films {"turnDeg":360}');
    expect(asked.at(-1)).toBe('DELETE sessions/s/films/f1');
  });
});
