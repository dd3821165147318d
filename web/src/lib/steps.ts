// Time steps as people write them: counted from 1, "1, 3, 5" or "2-6" or both; 0-based numbers inside.

export const mostSteps = 64; // that the server smears

/** The steps, or what is wrong with the text in words. */
export function parseSteps(text: string, count: number): number[] | string {
  const steps: number[] = [];
  for (const part of text.split(/[\s,;]+/).filter((p) => p !== '')) {
    const range = /^(\d+)(?:[-:–](\d+))?$/.exec(part);
    if (!range) return `“${part}” is not a step; expected 1, 3, 5 or 2-6.`;
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
    else for (let step = from; step <= to; ++step) parts.push(String(step));
    i = j + 1;
  }
  return parts.join(', ');
}
