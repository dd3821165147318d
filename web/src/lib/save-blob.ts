// Hands a file to the person.

export function saveBlob(blob: Blob, name: string): void {
  const url = URL.createObjectURL(blob);
  const link = document.createElement('a');
  link.href = url;
  link.download = name;
  link.click();
  // The browser has to have begun reading before the address goes.
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** Letters and digits of every script stay what they are; what a name of a file had better not have becomes a _. */
export const fileName = (words: string): string => words.replace(/[^\p{L}\p{M}\p{N}_.-]+/gu, '_');
