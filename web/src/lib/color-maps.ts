// Previews of the server's colour maps: a few stops each, for a swatch. The picture itself is coloured by the server.
import { hexOf, rgbOfHex } from './colors';
import type { Rgb, TransferPoint } from './model';

const stops: Record<string, string> = {
  viridis: '#440154 #472d7b #3b528b #2c728e #21918c #28ae80 #5ec962 #addc30 #fde725',
  plasma: '#0d0887 #4c02a1 #7e03a8 #a92395 #cc4778 #e56b5d #f89540 #fdc527 #f0f921',
  inferno: '#000004 #210c4a #57106e #8a226a #bc3754 #e45a31 #f98e09 #f9cb35 #fcffa4',
  magma: '#000004 #1c1044 #51127c #832681 #b73779 #e75263 #fc8961 #fec488 #fcfdbf',
  batlow: '#011959 #103f60 #1c5a62 #3c6d56 #687b3e #9d892b #d29343 #f8a17b #fdb7bc #faccfa',
  vik: '#001261 #034481 #307da6 #94bed2 #ebe5e0 #d9a98c #bd6432 #8b250a #590008',
  gray: '#000000 #ffffff',
  coolwarm: '#3b4cc0 #7b9ff9 #c0d4f5 #dddcdc #f2cbb7 #ee8468 #b40426',
};

function stopsOf(name: string): string[] | null {
  // A ramp is named by its colours: #rrggbb-#rrggbb.
  const ramp = /^#[0-9a-f]{6}(-#[0-9a-f]{6})+$/i.test(name) ? name.replaceAll('-', ' ') : undefined;
  const colors = (stops[name.replace(/_r$/, '')] ?? ramp)?.split(' ') ?? null;
  return colors && name.endsWith('_r') ? colors.reverse() : colors;
}

/** A CSS background for the named map; null for a map that has no preview here. */
export function colorMapGradient(name: string): string | null {
  const colors = stopsOf(name);
  return colors ? `linear-gradient(to right, ${colors.join(', ')})` : null;
}

/** Colours at equal distances, from the map's lower end to its upper one; null as above. */
export function colorMapColors(name: string): Rgb[] | null {
  return stopsOf(name)?.map((hex) => rgbOfHex(hex) as Rgb) ?? null;
}

/** A CSS background in the colours of a transfer function's points. */
export function transferGradient(points: readonly TransferPoint[]): string {
  const [first, last] = [points[0]?.value ?? 0, points[points.length - 1]?.value ?? 1];
  const stop = (p: TransferPoint) => `${hexOf(p.color)} ${(((p.value - first) / (last - first)) * 100).toFixed(1)}%`;
  return `linear-gradient(to right, ${points.map(stop).join(', ')})`;
}
