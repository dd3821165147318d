// How fast frames come and how far away the server is.

/** Frames per second over the last two seconds. */
export class RateMeter {
  #times: number[] = [];

  constructor(private readonly windowMs = 2000) {}

  tick(nowMs: number): void {
    this.#times.push(nowMs);
    this.#trim(nowMs);
  }
  /** 0 if fewer than two frames have come lately: a still picture has no rate. */
  rate(nowMs: number): number {
    this.#trim(nowMs);
    const first = this.#times[0];
    const last = this.#times[this.#times.length - 1];
    if (first === undefined || last === undefined || last === first) return 0;
    return ((this.#times.length - 1) * 1000) / (last - first);
  }
  #trim(nowMs: number): void {
    this.#times = this.#times.filter((t) => nowMs - t <= this.windowMs);
  }
}

/** Smooths a jumpy number: each sample moves the value by a fifth. */
export class Smoothed {
  value: number | null = null;

  add(sample: number): number {
    this.value = this.value === null ? sample : this.value + 0.2 * (sample - this.value);
    return this.value;
  }
}
