import { describe, expect, test } from 'vitest';
import { clockOf, dateOf, type Clock } from '../src/lib/dates';

const of = (units: string) => clockOf(['another note', `times are in ${units}`]);
const dates = (units: string, ...times: number[]) => times.map((time) => dateOf(time, of(units) as Clock, times));

describe('dates of times', () => {
  test('are those of the calendar, by days, hours and seconds', () => {
    expect(dates('days since 2001-01-01', 0, 59, 365)).toEqual(['2001-01-01', '2001-03-01', '2002-01-01']);
    expect(dates('days since 2000-01-01 00:00:00', 59, 366)).toEqual(['2000-02-29', '2001-01-01']);
    expect(dates('hours since 1999-12-31 18:00', 0, 6.5)).toEqual(['1999-12-31 18:00', '2000-01-01 00:30']);
    expect(dates('seconds since 1970-1-1T0:0:0Z', 86399, 86400)).toEqual(['1970-01-01 23:59:59', '1970-01-02 00:00:00']);
    expect(dates('days since 2001-01-01 12:00', -1, 0)).toEqual(['2000-12-31 12:00', '2001-01-01 12:00']);
  });

  test('of models are those of their own years', () => {
    expect(dates('days since 2000-01-01, calendar noleap', 59, 365)).toEqual(['2000-03-01', '2001-01-01']);
    expect(dates('days since 2001-01-01, calendar all_leap', 59, 366)).toEqual(['2001-02-29', '2002-01-01']);
    expect(dates('days since 0001-01-01, calendar 360_day', 29, 30, 360)).toEqual(['0001-01-30', '0001-02-01', '0002-01-01']);
  });

  test('go on by one day after another in every calendar', () => {
    for (const calendar of ['standard', 'noleap', 'all_leap', '360_day']) {
      const clock = of(`days since 1999-02-25, calendar ${calendar}`) as Clock;
      const all = Array.from({ length: 3000 }, (_, i) => dateOf(i, clock));
      expect(new Set(all).size, calendar).toBe(3000);
      expect([...all].sort(), calendar).toEqual(all);
    }
  });

  test('are not guessed', () => {
    for (const units of ['sec', 'days', 'months since 2001-01-01', 'days since the storm', 'days since 2001-01-01, calendar julian', 'days since 0001-01-01', 'days since 2001-13-01', 'days since 2001-01-01 00:00 +05:30'])
      expect(of(units), units).toBe(null);
    expect(clockOf([])).toBe(null);
    expect(dateOf(1e12, of('days since 2001-01-01') as Clock)).toBe('');
  });
});
