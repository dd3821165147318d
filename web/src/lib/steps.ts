// Time steps as people write them: counted from 1, "1, 3, 5" or "2-6" or both; 0-based numbers inside. "2.5" is half way from the second to the third.

export const mostSteps = 64; // that the server smears

/** The steps, some of them perhaps between two, or what is wrong with the text in words. */
export function parseSteps(text: string, count: number): number[] | string {
  const steps: number[] = [];
  for (const part of text.split(/[\s,;]+/).filter((p) => p !== '')) {
    const range = /^(\d+)(?:[-:–](\d+))?$/.exec(part) ?? /^(\d*\.\d+)$/.exec(part);
    if (!range) return `“${part}” is not a step; expected 1, 3, 5 or 2-6, or 2.5 between two.`;
    const from = Number(range[1]);
    const to = range[2] === undefined ? from : Number(range[2]);
    for (const end of [from, to]) if (end < 1 || end > count) return `Step ${end} is not there; there are 1 to ${count}.`;
    for (let step = from; from <= to ? step <= to : step >= to; step += from <= to ? 1 : -1) steps.push(step - 1);
  }
  if (steps.length === 0) return 'At least one step is expected.';
  if (steps.length > mostSteps) return `${steps.length} steps; the server takes at most ${mostSteps}.`;
  return steps;
}

/** Runs of three and more as 2-6. */
export function stepsText(steps: readonly number[]): string {
  const parts: string[] = [];
  for (let i = 0; i < steps.length; ) {
    let j = i;
    while (j + 1 < steps.length && steps[j + 1] === (steps[j] as number) + 1) ++j;
    const from = (steps[i] as number) + 1;
    const to = (steps[j] as number) + 1;
    if (j - i >= 2) parts.push(`${from}-${to}`);
    else for (let step = from; step <= to; ++step) parts.push(String(Number(step.toPrecision(9))));
    i = j + 1;
  }
  return parts.join(', ');
}

/** The time of a step, or of a place between two: linear from one to the next. */
export function timeOfStep(step: number, times: readonly number[]): number {
  const before = Math.min(Math.floor(step), times.length - 1);
  const from = times[before] ?? 0;
  return from + (step - before) * ((times[before + 1] ?? from) - from);
}

/** The inverse; of steps at one time the first. */
export function stepOfTime(time: number, times: readonly number[]): number {
  const next = times.findIndex((t) => t >= time);
  if (next <= 0) return next < 0 ? Math.max(times.length - 1, 0) : 0;
  const from = times[next - 1] as number;
  return next - 1 + (time - from) / ((times[next] as number) - from);
}
