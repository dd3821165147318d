// Which plot and which layers' numbers are open, as a text that a tab remembers over a reload. The values themselves are asked for again.
import type { CurvePlace } from './curves.svelte';
import type { Vec3 } from './model';

export interface OpenCurve {
  place: CurvePlace;
  array: string; // empty: the layers'
}
export interface SavedPlots {
  dataset: string;
  curve: OpenCurve | null;
  layers: [id: number, array: string][]; // that were measured
}

export const plotsText = (plots: SavedPlots): string => (plots.curve || plots.layers.length > 0 ? JSON.stringify(plots) : '');

/** Null if it is not such a text: what was stored is not trusted. */
export function parsePlots(text: string | null): SavedPlots | null {
  if (!text) return null;
  const isPlace = (of: unknown): of is Vec3 => Array.isArray(of) && of.length === 3 && of.every(Number.isFinite);
  try {
    const { dataset, curve, layers } = JSON.parse(text) as SavedPlots;
    const place = curve?.place;
    const good =
      typeof dataset === 'string' &&
      layers.every(([id, array]) => Number.isInteger(id) && typeof array === 'string') &&
      (!place || (typeof curve.array === 'string' && (place.kind === 'line' ? isPlace(place.from) && isPlace(place.to) : place.kind === 'steps' && isPlace(place.at))));
    return good ? { dataset, curve: place ? curve : null, layers } : null;
  } catch {
    return null;
  }
}
