// A histogram as a shape: heights in [0, 1], and an SVG path in a box of given size.

/** Heights relative to the fullest bin. With `log` they follow log(1 + count), so that rare values can be seen at all. */
export function barHeights(counts: readonly number[], log: boolean): number[] {
  const value = (count: number) => (log ? Math.log1p(count) : count);
  const top = counts.reduce((most, count) => Math.max(most, count), 0);
  return counts.map((count) => (top > 0 ? value(count) / value(top) : 0));
}

/** A closed path of steps over [0, width], standing on `height`. Bins with anything in them are at least half a pixel tall. */
export function barPath(heights: readonly number[], width: number, height: number): string {
  if (heights.length === 0) return '';
  const step = width / heights.length;
  const round = (x: number) => Math.round(x * 100) / 100;
  let path = `M0 ${height}`;
  heights.forEach((h, i) => {
    const y = round(height - (h > 0 ? Math.max(h * height, 0.5) : 0));
    path += `V${y}H${round((i + 1) * step)}`;
  });
  return `${path}V${height}Z`;
}
