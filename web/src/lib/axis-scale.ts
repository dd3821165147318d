// How many times as long an axis is drawn, as it is typed.

/** The number, or why it is none. A decimal comma is one. */
export function typedFactor(text: string): number | string {
  const plain = text.trim().replace(/^[×x]\s*/, '');
  const value = Number(/^\d+,\d+$/.test(plain) ? plain.replace(',', '.') : plain || NaN);
  return value >= 1e-12 && value <= 1e12 ? value : `"${text}" is not a scale; expected a number above 0, as 50 or 0.1.`;
}
