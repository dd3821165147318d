// A clock that stands until it is moved: what is due by then is called, in the order in which it is due.

export class TickedClock {
  now = 0;
  private due: { atMs: number; callback: () => void }[] = [];

  readonly after = (ms: number, callback: () => void): void => {
    this.due.push({ atMs: this.now + ms, callback });
    this.due.sort((a, b) => a.atMs - b.atMs);
  };
  advance(ms: number): void {
    const end = this.now + ms;
    for (let next = this.due[0]; next && next.atMs <= end; next = this.due[0]) {
      this.due.shift();
      this.now = next.atMs;
      next.callback();
    }
    this.now = end;
  }
}
