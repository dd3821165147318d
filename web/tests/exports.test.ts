import { describe, expect, test } from 'vitest';
import { Exports } from '../src/lib/exports.svelte';

/** A server that answers in turn; what it was asked, and what was saved. */
function exportsOf(answers: ({ ok?: boolean; body: object } | 'lost')[]) {
  const asked: string[] = [];
  const saved: string[] = [];
  const exports = new Exports({
    ask: (path, method, body) => {
      asked.push([method, path, body ?? ''].join(' ').trim());
      const answer = method === 'DELETE' ? 'lost' : answers.shift();
      if (!answer || answer === 'lost') return Promise.reject(new TypeError('Failed to fetch'));
      return Promise.resolve({ ok: answer.ok ?? true, json: () => Promise.resolve(answer.body), blob: () => Promise.resolve(new Blob(['mesh'])) });
    },
    save: (file, name) => saved.push(`${name}: ${file.size}`),
    wait: () => Promise.resolve(),
  });
  return { exports, asked, saved };
}
const running = { body: { id: 'e1', status: 'running' } };
const done = { body: { id: 'e1', status: 'done' } };

describe('a mesh file of the layers', () => {
  test('is asked for, waited for and saved, and the server need not keep it', async () => {
    const { exports, asked, saved } = exportsOf([running, running, done, { body: {} }]);
    const answer = exports.save('s', 'ply', 'torus');
    expect(exports.waits).toBe(true);
    expect(await answer).toBe('');
    expect(exports.waits).toBe(false);
    const [one, file] = ['sessions/s/operations/e1', 'sessions/s/exports/e1'];
    expect(asked).toEqual(['POST sessions/s/exports {"format":"ply"}', `GET ${one}`, `GET ${one}`, `GET ${file}`, `DELETE ${file}`]);
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
      expect(await exports.save('s', 'vtu', 'torus')).toBe(why);
      expect(saved).toEqual([]);
      expect(exports.waits).toBe(false);
      expect(asked.filter((of) => of.startsWith('DELETE'))).toHaveLength(answers.length > 1 ? 1 : 0);
    }
  });
});
