// How many pixels to ask the server for.

export interface PixelSize {
  width: number;
  height: number;
}

const mostPixels = 4_200_000; // about 2560x1640: beyond that frames get slow and nobody sees the difference in a moving picture

/** Device pixels of a box given in CSS pixels, scaled down evenly if that is more than the server or we allow; at least 16x16. */
export function viewportPixels(cssWidth: number, cssHeight: number, pixelRatio: number, most: PixelSize): PixelSize {
  const width = Math.max(cssWidth, 1) * pixelRatio;
  const height = Math.max(cssHeight, 1) * pixelRatio;
  const fit = Math.min(1, most.width / width, most.height / height, Math.sqrt(mostPixels / (width * height)));
  return { width: Math.max(16, Math.floor(width * fit)), height: Math.max(16, Math.floor(height * fit)) };
}
