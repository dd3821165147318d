// A part of the program that comes over the line by itself: when it is wanted first, or before that when the line has nothing else to do.

export class OnDemand<Part> {
  part = $state.raw<Part | null>(null);
  /** How often it did not come, in a row. */
  failures = $state(0);
  #coming: Promise<Part> | null = null;

  constructor(private readonly load: () => Promise<Part>) {}

  /** Asks for it unless it is there or on its way; after a failure anew. */
  get(): Promise<Part> {
    return (this.#coming ??= this.load().then(
      (part) => {
        this.part = part;
        this.failures = 0;
        return part;
      },
      (problem: unknown) => {
        this.#coming = null;
        this.failures++;
        throw problem;
      },
    ));
  }
  /** The same, for who looks at `part` and `failures`. */
  want(): void {
    this.get().catch(() => {});
  }
}
