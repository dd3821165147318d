// Steps of a series one after the other. Each waits until the one before is in the picture: a slow line or a large mesh slows the play down, and no step is left out.

export interface PlaybackDoors {
  go(step: number): void;
  now(): number;
  after(ms: number, callback: () => void): void;
  /** Whether the person has asked for little motion: then three steps a second are the most. */
  calm(): boolean;
}

export const playSpeeds = [1, 2, 5, 10, 20] as const;
const calmSpeed = 3;

export class Playback {
  playing = $state(false);
  /** At most so many steps a second. */
  perSecond = $state<number>(10);
  #step = 0;
  #count = 0;
  #shown = false;
  #askedMs = -Infinity;
  #waits = false;

  constructor(private readonly doors: PlaybackDoors) {}

  toggle(): void {
    this.playing = !this.playing;
    this.#askedMs = -Infinity;
    this.#goOn();
  }
  /** To be called whenever one of these may have changed. shown: the picture is of this step. */
  told(step: number, count: number, shown: boolean): void {
    this.#step = step;
    this.#count = count;
    this.#shown = shown;
    this.#goOn();
  }

  #goOn(): void {
    if (!this.playing || !this.#shown || this.#waits || this.#count < 2) return;
    const { doors } = this;
    const leastMs = 1000 / (doors.calm() ? Math.min(this.perSecond, calmSpeed) : this.perSecond);
    this.#waits = true;
    doors.after(Math.max(0, this.#askedMs + leastMs - doors.now()), () => {
      this.#waits = false;
      if (!this.playing || !this.#shown) return; // somebody else has gone to another step meanwhile
      this.#askedMs = doors.now();
      doors.go((this.#step + 1) % this.#count);
    });
  }
}
