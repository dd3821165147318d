// What a film is to be, as the server takes it (NewFilm of the protocol).
import type { Annotations } from './model';

export interface FilmChoice {
  turns: boolean;
  turnDeg: string;
  plays: boolean; // the steps of the series
  first: string; // steps as they are counted on the page, from 1
  last: string;
  seconds: string; // empty: as long as is usual
}
const most = { width: 3840, height: 2160, seconds: 3600, turnDeg: 36_000, rate: 60 };
const whole = (text: string): number => (/^\s*\d{1,9}\s*$/.test(text) ? Number(text) : NaN);
const real = (text: string): number => (text.trim() === '' ? NaN : Number(text.replace(',', '.')));

/** How long it is if nothing else is said. */
export const usualSeconds = ({ turns, first, last }: FilmChoice): number => (turns ? 6 : Math.max(Math.abs(whole(last) - whole(first)) + 1 || 1, 1) / 10);

/** Or what is wrong with it in words. steps: of the dataset. */
export function filmOf(choice: FilmChoice, size: { width: number; height: number } | string, steps: number, annotations: Annotations): object | string {
  if (typeof size === 'string') return size;
  if (size.width > most.width || size.height > most.height) return `A film has at most ${most.width}x${most.height} pixels: choose a size of its own.`;
  if (!choice.turns && !choice.plays) return 'Choose what moves.';
  const film: Record<string, unknown> = { ...size, annotations };
  if (choice.turns) {
    const turnDeg = real(choice.turnDeg);
    if (!turnDeg || Math.abs(turnDeg) > most.turnDeg) return `Expected degrees to turn by, as 360 or -90, at most ${most.turnDeg}.`;
    film.turnDeg = turnDeg;
  }
  if (choice.plays) {
    const [first, last] = [whole(choice.first), whole(choice.last)];
    if (![first, last].every((step) => step >= 1 && step <= steps)) return `Expected steps from 1 to ${steps}.`;
    Object.assign(film, { firstStep: first - 1, lastStep: last - 1 });
  }
  if (choice.seconds.trim() !== '') {
    const seconds = real(choice.seconds);
    if (!(seconds >= 0.1 && seconds <= most.seconds)) return `Expected seconds from 0.1 to ${most.seconds}.`;
    const shown = choice.plays ? Math.abs(whole(choice.last) - whole(choice.first)) + 1 : 0;
    if (shown / seconds > most.rate) return `${shown} steps take at least ${Math.ceil(shown / most.rate)} seconds.`;
    film.seconds = seconds;
  }
  return film;
}
