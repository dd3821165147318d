// How many times as long an axis is drawn, as it is typed.
import { typeNumber } from './intervals';

/** The number, or why it is none. */
export function typedFactor(text: string): number | string {
  const value = typeNumber(text.trim().replace(/^[×x]\s*/, ''));
  return typeof value === 'number' && value >= 1e-12 && value <= 1e12 ? value : `"${text}" is not a scale; expected a number above 0, as 50 or 0.1.`;
}
