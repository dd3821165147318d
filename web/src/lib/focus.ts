// Where the keyboard goes when what it is at goes away.
import { tick } from 'svelte';

/** From a control that is about to go: to the next one of its kind, else to the one before, else to the button that adds one. */
export function leave(control: Element, kind: string): void {
  const all = [...document.querySelectorAll<HTMLElement>(kind)];
  const at = all.indexOf(control as HTMLElement);
  (all[at + 1] ?? all[at - 1] ?? document.getElementById('add-layer'))?.focus();
}

/** What the keyboard was at has gone: it goes on there. */
export async function goOnAt(selector: string): Promise<void> {
  await tick();
  const lost = !document.activeElement || document.activeElement === document.body;
  if (lost) document.querySelector<HTMLElement>(selector)?.focus({ preventScroll: true });
}

/** Whether keys belong to the text that is being written there. A number that has been taken is none: its field waits for the next. */
export function isTyped(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) return false;
  return target.matches('textarea, [contenteditable], input:is(:not([type]), [type="text"], [type="search"], [type="number"]):not([data-taken])');
}
