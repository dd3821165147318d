import { describe, expect, it } from 'vitest';
import { agoWords, factsOf, markOf, sizeWords, timesSaid } from '../src/lib/file-words';
import { fileName } from '../src/lib/save-blob';
import type { DatasetEntry } from '../src/lib/told';

const entry = (more: Partial<DatasetEntry> = {}): DatasetEntry => ({
  id: 'a', name: 'a.vtk', kind: 'legacy VTK', bytes: 0, changedMs: 0, files: 1, steps: 0, news: 'none', noticedMs: 0, writing: false, foundStep: 0, ...more,
});

describe('words of the list of files', () => {
  it('say a note of several files once', () => {
    expect(timesSaid(['a', 'b', 'a', 'a'])).toEqual(['a (× 3)', 'b']);
    expect(timesSaid([])).toEqual([]);
  });
  it('are names of files in every script', () => {
    expect(fileName('Ünïcode 数据 ordner/a_b-1.vtk-Dichte <b>')).toBe('Ünïcode_数据_ordner_a_b-1.vtk-Dichte_b_');
    expect(fileName('हिन्दी')).toBe('हिन्दी');
  });
  it('give sizes two digits and never 1000 of a unit', () => {
    expect([0, 999, 1000, 4200, 99_400, 99_600, 999_499, 999_501, 4.2e9, 5e15].map(sizeWords)).toEqual(
      ['0 B', '999 B', '1 KB', '4.2 KB', '99 KB', '100 KB', '999 KB', '1 MB', '4.2 GB', '5 PB'],
    );
  });
  it('say how long ago a change was, and the day once that says more', () => {
    const now = Date.UTC(2026, 10, 24, 12);
    expect([10e3, 5 * 60e3, 3 * 3600e3, 2 * 86400e3].map((ms) => agoWords(now - ms, now))).toEqual(['just now', '5 min ago', '3 h ago', '2 d ago']);
    expect(agoWords(Date.UTC(2025, 0, 2), now)).toBe('2025-01-02');
    expect(agoWords(0, now)).toBe('');
  });
  it('mark what happened lately, and what is gone for as long as it is listed', () => {
    const now = 1e12;
    expect(markOf(entry(), now)).toBe('');
    expect(markOf(entry({ news: 'appeared', noticedMs: now - 1000 }), now)).toBe('new');
    expect(markOf(entry({ news: 'appeared', noticedMs: now - 1e6 }), now)).toBe('');
    expect(markOf(entry({ news: 'grown', noticedMs: now, writing: true }), now)).toBe('being written');
    expect(markOf(entry({ news: 'gone', noticedMs: now - 1e6 }), now)).toBe('gone');
  });
  it('leave out what is not known', () => {
    expect(factsOf(entry({ kind: '' }), 1e12)).toBe('');
    expect(factsOf(entry({ steps: 1200, files: 1200, bytes: 5e6, changedMs: 1e12 - 1000 }), 1e12)).toBe('legacy VTK · 1,200 steps · 5 MB · just now');
    expect(factsOf(entry({ kind: 'DICOM', files: 40 }), 1e12)).toBe('DICOM · 40 slices');
  });
});
