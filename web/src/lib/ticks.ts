// Round numbers for axes, fields and readouts.

/** 1, 2 or 5 times a power of ten, at least `raw`. */
export function niceStep(raw: number): number {
  if (!(raw > 0) || !Number.isFinite(raw)) return 1;
  const power = 10 ** Math.floor(Math.log10(raw));
  const mantissa = raw / power;
  const step = mantissa <= 1 ? 1 : mantissa <= 2 ? 2 : mantissa <= 5 ? 5 : 10;
  return step * power;
}

/** Multiples of a nice step within [lower, upper], about `count` of them. */
export function ticks(lower: number, upper: number, count: number): number[] {
  if (!(upper > lower) || count < 1) return [];
  const step = niceStep((upper - lower) / count);
  const first = Math.ceil(lower / step - 1e-9);
  const last = Math.floor(upper / step + 1e-9);
  const result: number[] = [];
  for (let i = first; i <= last && result.length < 100; i++) result.push(Number((i * step).toPrecision(12)));
  return result;
}

/** Short, and exact to `digits` significant ones: 0.3125, 1.25e+8, 12 300 as 12300. */
export function formatNumber(value: number, digits = 5): string {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? 'NaN' : value > 0 ? '∞' : '−∞';
  if (value === 0) return '0';
  const short = Number(value.toPrecision(digits));
  const size = Math.abs(short);
  const [plain, power] = [String(short), short.toExponential().replace('e+', 'e')];
  // Many digits are easier to read in their places: 1000000.0001.
  return size < 1e-4 || (size >= 1e6 && plain.length + 1 >= power.length) ? power : plain;
}

/** All digits of a number, as it is typed: 0.25, 1.408e-6, inf. */
export function wholeText(value: number): string {
  if (!Number.isFinite(value)) return value > 0 ? 'inf' : '-inf';
  return value !== 0 && Math.abs(value) < 1e-4 ? value.toExponential() : String(value);
}

/** Of a tick, which is round: the whole of it. */
export const tickText = (value: number): string => formatNumber(value, 12);

/** Both with as many digits as show how far they are apart, at least so many. */
export function formatRange(lower: number, upper: number, digits = 5): [string, string] {
  let texts: [string, string];
  do texts = [formatNumber(lower, digits), formatNumber(upper, digits)];
  while (Math.abs(Number(texts[1]) - Number(texts[0]) - (upper - lower)) > 0.1 * Math.abs(upper - lower) && ++digits <= 17);
  return texts;
}

/** A time, with as many digits as tell it apart from the others. */
export function timeText(time: number, times: readonly number[]): string {
  const apart = times.reduce((least, of) => (of === time ? least : Math.min(least, Math.abs(of - time))), Infinity);
  let digits = Number.isFinite(apart) ? 6 : 12;
  while (digits < 17 && Math.abs(Number(time.toPrecision(digits)) - time) > 0.01 * apart) ++digits;
  return formatNumber(time, digits);
}

/** The nearest multiple of step, without the tail that binary arithmetic leaves. */
export function roundTo(value: number, step: number): number {
  return Number((Math.round(value / step) * step).toPrecision(12));
}

/** 1.2 M, 60.4 k, 812. */
export function formatCount(value: number): string {
  if (value >= 1e9) return `${(value / 1e9).toPrecision(3)} G`;
  if (value >= 1e6) return `${(value / 1e6).toPrecision(3)} M`;
  if (value >= 1e4) return `${(value / 1e3).toPrecision(3)} k`;
  return value.toLocaleString('en');
}

export function formatBytes(value: number): string {
  return value >= 1048576 ? `${(value / 1048576).toFixed(1)} MiB` : value >= 1024 ? `${Math.round(value / 1024)} KiB` : `${value} B`;
}

export function formatMs(value: number): string {
  return value >= 1000 ? `${(value / 1000).toFixed(2)} s` : value >= 100 ? `${Math.round(value)} ms` : `${value.toFixed(1)} ms`;
}
