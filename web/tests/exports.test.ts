import { describe, expect, test } from 'vitest';
import { Exports } from '../src/lib/exports.svelte';

/** A server that answers in turn; what it was asked, and what the browser was given. */
function exportsOf(answers: ({ ok?: boolean; body: object } | 'lost')[]) {
  const asked: string[] = [];
  const given: string[] = [];
  const exports = new Exports({
    ask: (path, method, body) => {
      asked.push([method, path, body ?? ''].join(' ').trim());
      if (method === 'DELETE') return Promise.resolve({ ok: false, json: () => Promise.resolve({}) });
      const answer = answers.shift();
      if (!answer || answer === 'lost') return Promise.reject(new TypeError('Failed to fetch'));
      return Promise.resolve({ ok: answer.ok ?? true, json: () => Promise.resolve(answer.body) });
    },
    give: (path) => given.push(path),
    wait: () => Promise.resolve(),
  });
  return { exports, asked, given };
}
const running = { body: { id: 'e1', status: 'running' } };

describe('a mesh file of the layers', () => {
  test('is asked for, waited for and given to the browser; the one before goes when the next is asked for', async () => {
    const { exports, asked, given } = exportsOf([running, running, { body: { id: 'e1', status: 'done' } }, { body: { id: 'e2', status: 'done' } }]);
    const saved = exports.save('s', 'ply');
    expect(exports.waits).toBe(true);
    expect(await saved).toBe('');
    expect(exports.waits).toBe(false);
    expect(asked).toEqual(['POST sessions/s/exports {"format":"ply"}', 'GET sessions/s/operations/e1', 'GET sessions/s/operations/e1']);
    expect(given).toEqual(['sessions/s/exports/e1']);
    asked.length = 0;
    expect(await exports.save('t', 'vtu')).toBe('');
    expect(asked).toEqual(['DELETE sessions/s/exports/e1', 'POST sessions/t/exports {"format":"vtu"}']); // whatever the DELETE is answered
    expect(given).toHaveLength(2);
  });

  test('that does not come says why, and the next one can be asked for', async () => {
    const refusal = { ok: false, body: { detail: 'this session has 4 exports already' } };
    for (const [answers, why] of [
      [[refusal], 'this session has 4 exports already'],
      [[running, { body: { id: 'e1', status: 'failed', error: { detail: 'no space' } } }], 'no space'],
      [[running, { body: { id: 'e1', status: 'cancelled' } }], 'Cancelled.'],
      [[running, 'lost'], 'the connection was lost'],
      [['lost'], 'the connection was lost'],
    ] as const) {
      const { exports, given } = exportsOf([...answers]);
      expect(await exports.save('s', 'vtu')).toBe(why);
      expect(given).toEqual([]);
      expect(exports.waits).toBe(false);
    }
  });
});
