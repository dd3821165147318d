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
const palette: Rgb[] = [
  [0.90, 0.12, 0.12],
  [0.15, 0.75, 0.20],
  [0.15, 0.35, 0.95],
  [0.97, 0.85, 0.10],
  [0.95, 0.50, 0.05],
  [0.10, 0.80, 0.85],
  [0.85, 0.20, 0.75],
  [0.60, 0.90, 0.10],
  [0.50, 0.30, 0.85],
  [0.95, 0.60, 0.65],
].map(([r, g, b]) => [Math.fround(r!), Math.fround(g!), Math.fround(b!)]);  // as the server has them, to the last bit
export const usualColor = (index: number): Rgb => palette[index % palette.length] as Rgb;

/** The first of them that no layer has. */
export function newIntervalColor(used: readonly Rgb[]): Rgb {
  const taken = new Set(used.map(hexOf));
  const free = palette.findIndex((color) => !taken.has(hexOf(color)));
  return usualColor(free >= 0 ? free : used.length);
}
