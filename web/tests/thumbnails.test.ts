// Pictures of a list's rows: two at a time, given up when they are out of sight, asked for once.
import { describe, expect, test } from 'vitest';
import type { DatasetEntry } from '../src/lib/told';
import { thumbnailKey, Thumbnails, type Thumbnail } from '../src/lib/thumbnails';

const entry: DatasetEntry = {
  id: 'a',
  name: 'a.vtu',
  kind: 'XML VTK',
  bytes: 10,
  changedMs: 1000,
  files: 1,
  steps: 0,
  news: 'none',
  noticedMs: 0,
  writing: false,
  foundStep: 0,
};

/** A server that answers when the test says so. */
class Answers {
  asked: { dataset: string; signal: AbortSignal; answer: (response: Response) => void }[] = [];
  urls: string[] = [];
  forgotten: string[] = [];
  readonly thumbnails = new Thumbnails({
    ask: (dataset, signal) =>
      new Promise((answer, refuse) => {
        this.asked.push({ dataset, signal, answer });
        signal.addEventListener('abort', () => refuse(new Error('aborted')));
      }),
    urlOf: () => {
      this.urls.push(`blob:${this.urls.length}`);
      return this.urls[this.urls.length - 1] as string;
    },
    forget: (url) => this.forgotten.push(url),
  });
  open = (): string[] => this.asked.filter((of) => !of.signal.aborted).map((of) => of.dataset);
}
const settled = () => new Promise((done) => setTimeout(done, 0));
const png = () => new Response(new Blob(['png']), { status: 200 });

describe('Thumbnails', () => {
  test('are asked for two at a time, once each', async () => {
    const server = new Answers();
    const shown: Thumbnail[] = [];
    for (const id of ['a', 'b', 'c']) server.thumbnails.show(id, `${id} 1`, (of) => shown.push(of));
    expect(server.open()).toEqual(['a', 'b']);
    server.asked[0]?.answer(png());
    await settled();
    expect(shown).toEqual([{ picture: 'blob:0' }]);
    expect(server.open()).toEqual(['a', 'b', 'c']);
    server.thumbnails.show('a', 'a 1', (of) => shown.push(of));
    expect(shown).toEqual([{ picture: 'blob:0' }, { picture: 'blob:0' }]);
    expect(server.asked.length).toBe(3);
  });

  test('of rows that are out of sight are given up, also while they are made', async () => {
    const server = new Answers();
    const shown: Thumbnail[] = [];
    const ends = ['a', 'b', 'c', 'd'].map((id) => server.thumbnails.show(id, `${id} 1`, (of) => shown.push(of)));
    ends[0]?.();
    ends[2]?.();
    await settled();
    expect(server.asked[0]?.signal.aborted).toBe(true);
    expect(server.open()).toEqual(['b', 'd']);
    expect(shown).toEqual([]);
  });

  test('that there are none is kept with its reason; what failed is asked for again', async () => {
    const server = new Answers();
    const shown: Thumbnail[] = [];
    const show = (of: Thumbnail) => shown.push(of);
    server.thumbnails.show('a', 'a 1', show);
    server.asked[0]?.answer(new Response(null, { status: 204, headers: { 'Isostrata-Reason': 'f%C3%BCr.vtu: broken' } }));
    server.thumbnails.show('b', 'b 1', show);
    server.asked[1]?.answer(new Response('busy', { status: 503 }));
    await settled();
    expect(shown).toEqual([{ why: 'für.vtu: broken' }]);
    server.thumbnails.show('a', 'a 1', show);
    server.thumbnails.show('b', 'b 1', show);
    expect(server.asked.map((of) => of.dataset)).toEqual(['a', 'b', 'b']);
  });

  test('some hundreds are kept, the others forgotten', async () => {
    const server = new Answers();
    for (let i = 0; i < 310; i++) {
      server.thumbnails.show(`${i}`, `${i} 1`, () => undefined);
      server.asked[i]?.answer(png());
      await settled();
    }
    expect(server.forgotten).toEqual(server.urls.slice(0, 10));
  });

  test('a changed file has another one, steps that follow make none', () => {
    const key = thumbnailKey(entry);
    expect(thumbnailKey({ ...entry, changedMs: 2000, news: 'changed' })).not.toBe(key);
    expect(thumbnailKey({ ...entry, changedMs: 2000, news: 'grown' })).toBe(thumbnailKey({ ...entry, changedMs: 3000, news: 'grown' }));
    expect(thumbnailKey({ ...entry, writing: true })).toBe('');
    expect(thumbnailKey({ ...entry, news: 'gone' })).toBe('');
  });
});
