// Small pictures for the rows of a list, for as long as these are in sight. Two are asked for at a time, what is out of sight again is given up, and some
// hundreds are kept.
import type { DatasetEntry } from './told';

/** A picture's address; or why there is none. */
export type Thumbnail = { picture: string } | { why: string };

export interface ThumbnailDoors {
  ask(dataset: string, signal: AbortSignal): Promise<Response>;
  urlOf(picture: Blob): string;
  forget(url: string): void;
}

const atOnce = 2; // a browser has six connections to a server; and the server makes two pictures at a time
const most = 300;

interface Wish {
  dataset: string;
  key: string;
  show: (of: Thumbnail) => void;
  given: AbortController | null; // once it is asked for
}

/** What the picture is of; empty if none is asked for. Steps that follow make no other one. */
export function thumbnailKey(entry: DatasetEntry): string {
  if (entry.writing || entry.news === 'gone') return '';
  return `${entry.id} ${entry.news === 'grown' ? '' : entry.changedMs}`;
}

function plainText(letters: string): string {
  try {
    return decodeURIComponent(letters);
  } catch {
    return letters;
  }
}

export class Thumbnails {
  readonly #kept = new Map<string, Thumbnail>(); // the one used longest ago first
  readonly #wishes: Wish[] = []; // not asked for yet
  #asked = 0;

  constructor(private readonly doors: ThumbnailDoors) {}

  /** Shows it when it is there, until the function is called that this returns. */
  show(dataset: string, key: string, show: (of: Thumbnail) => void): () => void {
    const kept = this.#kept.get(key);
    if (kept) {
      this.#kept.delete(key);
      this.#kept.set(key, kept);
      show(kept);
      return () => undefined;
    }
    const wish: Wish = { dataset, key, show, given: null };
    this.#wishes.push(wish);
    this.#next();
    return () => {
      const at = this.#wishes.indexOf(wish);
      if (at >= 0) this.#wishes.splice(at, 1);
      wish.show = () => undefined;
      wish.given?.abort();
    };
  }

  #next(): void {
    while (this.#asked < atOnce) {
      const wish = this.#wishes.shift();
      if (!wish) return;
      this.#asked += 1;
      wish.given = new AbortController();
      void this.#fetch(wish, wish.given.signal).finally(() => {
        this.#asked -= 1;
        this.#next();
      });
    }
  }

  /** What is not answered for good is asked for when the row comes into sight again. */
  async #fetch(wish: Wish, signal: AbortSignal): Promise<void> {
    try {
      const answer = await this.doors.ask(wish.dataset, signal);
      if (answer.status === 204) this.#keep(wish, { why: plainText(answer.headers.get('Isostrata-Reason') ?? '') });
      else if (answer.ok) this.#keep(wish, { picture: this.doors.urlOf(await answer.blob()) });
    } catch {
      // given up, or the server is away
    }
  }

  #keep(wish: Wish, of: Thumbnail): void {
    this.#kept.set(wish.key, of);
    wish.show(of);
    for (const [key, oldest] of this.#kept) {
      if (this.#kept.size <= most) return;
      this.#kept.delete(key);
      if ('picture' in oldest) this.doors.forget(oldest.picture);
    }
  }
}
