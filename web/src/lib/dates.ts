// The date of a time of the data, if a note of the dataset says from when and in what its times are counted (the CF conventions' "days since
// 2001-01-01, calendar noleap"), and in which calendar.

type Calendar = 'real' | 'noleap' | 'all_leap' | '360_day';
const calendars: Record<string, Calendar> = {
  '': 'real', standard: 'real', gregorian: 'real', proleptic_gregorian: 'real', noleap: 'noleap', '365_day': 'noleap', all_leap: 'all_leap', '366_day': 'all_leap', '360_day': '360_day',
};
const secondsOf: [RegExp, number][] = [
  [/^(s|secs?|seconds?)$/, 1],
  [/^(min|mins|minutes?)$/, 60],
  [/^(h|hr|hrs|hours?)$/, 3600],
  [/^(d|days?)$/, 86400],
];
const day = 86400;
const usualMonths = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
const monthsOf = (calendar: Calendar) =>
  calendar === '360_day' ? usualMonths.map(() => 30) : usualMonths.map((days, month) => (calendar === 'all_leap' && month === 1 ? 29 : days));
const sum = (all: readonly number[]) => all.reduce((a, b) => a + b, 0);

export interface Clock {
  unitSeconds: number;
  calendar: Calendar;
  since: { year: number; month: number; day: number; seconds: number }; // month from 0
}

/** What the notes say of the dataset's times; null: no date follows from it. */
export function clockOf(notes: readonly string[]): Clock | null {
  for (const note of notes) {
    const found = /^times are in (\S+) since (-?\d{1,4})-(\d{1,2})-(\d{1,2})(?:[T ]+(\d{1,2}):(\d{1,2})(?::(\d{1,2}(?:\.\d*)?))?)?\s*(Z|UTC|GMT|[+-]?0{1,2}:?0{0,2})?(?:, calendar (\S+))?$/i.exec(note.trim());
    const unitSeconds = found && secondsOf.find(([word]) => word.test((found[1] as string).toLowerCase()))?.[1];
    const calendar = found && calendars[(found[9] ?? '').toLowerCase()];
    if (!found || !unitSeconds || !calendar) continue;
    const [year, month, date, hours, minutes, seconds] = found.slice(2, 8).map((text) => Number(text ?? 0)) as [number, number, number, number, number, number];
    // "standard" is Julian before 1582, and years before 1 are counted in two ways.
    if (month < 1 || month > 12 || date < 1 || date > 31 || (calendar === 'real' && year < 1583) || year < 0) continue;
    return { unitSeconds, calendar, since: { year, month: month - 1, day: date, seconds: hours * 3600 + minutes * 60 + seconds } };
  }
  return null;
}

/** "2001-03-01", or "2001-03-01 06:00" where not all of `times` are at midnight; '' if there is none. */
export function dateOf(time: number, clock: Clock, times: readonly number[] = [time]): string {
  const { calendar, since, unitSeconds } = clock;
  const seconds = (of: number) => Math.round(since.seconds + of * unitSeconds);
  const total = seconds(time);
  const days = Math.floor(total / day);
  const two = (value: number) => String(value).padStart(2, '0');
  const date = calendar === 'real' ? realDate(since, days) : modelDate(since, days, monthsOf(calendar));
  if (!date) return '';
  if (times.every((of) => seconds(of) % day === 0)) return date;
  const within = total - days * day;
  const clockTime = `${two(Math.floor(within / 3600))}:${two(Math.floor(within / 60) % 60)}`;
  return `${date} ${clockTime}${times.every((of) => seconds(of) % 60 === 0) ? '' : `:${two(within % 60)}`}`;
}
function realDate({ year, month, day: date }: Clock['since'], days: number): string {
  const ms = new Date(0).setUTCFullYear(year, month, date + days);
  if (!Number.isFinite(ms)) return '';
  const at = new Date(ms);
  // Before the Gregorian calendar "standard" and "proleptic_gregorian" differ.
  return at.getUTCFullYear() < 1583 || at.getUTCFullYear() > 9999 ? '' : at.toISOString().slice(0, 10);
}
function modelDate({ year, month, day: date }: Clock['since'], days: number, months: readonly number[]): string {
  const length = sum(months);
  const total = year * length + sum(months.slice(0, month)) + date - 1 + days;
  const years = Math.floor(total / length);
  if (!(years >= 0 && years <= 9999)) return '';
  let left = total - years * length;
  let at = 0;
  while (left >= (months[at] as number)) left -= months[at++] as number;
  return `${String(years).padStart(4, '0')}-${String(at + 1).padStart(2, '0')}-${String(left + 1).padStart(2, '0')}`;
}
