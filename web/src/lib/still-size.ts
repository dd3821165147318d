// How large a picture for keeping is.
export type SizeChoice = 'shown' | 'double' | 'typed';

interface Size {
  width: number;
  height: number;
}
const mostPixels = 2 ** 26; // as the server has it

/** In pixels, or what is wrong with it in words. */
export function stillSize(choice: SizeChoice, typed: string, shown: Size, limits: { maxWidth: number; maxHeight: number }): Size | string {
  const match = /^\s*(\d{1,6})\s*[x×*,; ]\s*(\d{1,6})\s*$/i.exec(typed);
  if (choice === 'typed' && !match) return 'Expected width x height, as 1920x1080.';
  const by = choice === 'double' ? 2 : 1;
  const [width, height] = choice === 'typed' ? [Number(match?.[1]), Number(match?.[2])] : [shown.width * by, shown.height * by];
  if (width < 1 || height < 1) return 'A picture has at least one pixel each way.';
  if (width > limits.maxWidth || height > limits.maxHeight) return `At most ${limits.maxWidth}x${limits.maxHeight} pixels.`;
  if (width * height > mostPixels) return `At most ${Math.round(mostPixels / 1e6)} million pixels in all.`;
  return { width, height };
}
