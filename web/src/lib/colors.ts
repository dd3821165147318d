// Colours of the page and of the wire.
import type { Rgb } from './model';

export function hexOf(color: Rgb): string {
  const byte = (x: number) => Math.round(Math.min(1, Math.max(0, x)) * 255).toString(16).padStart(2, '0');
  return `#${byte(color[0])}${byte(color[1])}${byte(color[2])}`;
}

/** Of "#rrggbb", as input type=color gives it; null for anything else. */
export function rgbOfHex(text: string): Rgb | null {
  const match = /^#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i.exec(text);
  if (!match) return null;
  const part = (i: number) => Number.parseInt(match[i] as string, 16) / 255;
  return [part(1), part(2), part(3)];
}

/** Relative luminance (WCAG 2.2): whether ink on this colour is to be dark or light. */
export function luminance(color: Rgb): number {
  const linear = (x: number) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
  return 0.2126 * linear(color[0]) + 0.7152 * linear(color[1]) + 0.0722 * linear(color[2]);
}

/** What the server gives its layers: red, green, blue, yellow, then further distinct ones. */
const palette = ['#e61f1f', '#26bf33', '#2659f2', '#f7d91a', '#f2800d', '#1accd9', '#d933bf', '#99e61a', '#804dd9', '#f299a6'];
export const usualColor = (index: number): Rgb => rgbOfHex(palette[index % palette.length] as string) as Rgb;

/** The first of them that no layer has. */
export function newIntervalColor(used: readonly Rgb[]): Rgb {
  const taken = new Set(used.map(hexOf));
  const free = palette.findIndex((hex) => !taken.has(hex));
  return usualColor(free >= 0 ? free : used.length);
}
