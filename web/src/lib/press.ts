// A press that stays where it began: with a mouse or a pen a click, with a finger a long one.
import type { Point2 } from './trackball';

const still = 4; // pixels that a hand may stray
const stillFinger = 10;
const longMs = 500;

type PressEvent = Pick<PointerEvent, 'pointerId' | 'pointerType' | 'button' | 'shiftKey' | 'ctrlKey' | 'altKey' | 'metaKey'>;

export class Press {
  #down: { id: number; at: Point2; finger: boolean } | null = null;
  #timer: ReturnType<typeof setTimeout> | undefined;

  /** long: a finger has rested at a place. taps: whether a short touch is a click now. */
  constructor(
    private readonly long: (at: Point2) => void,
    private readonly taps: () => boolean = () => false,
  ) {}

  /** A second finger, another button or a key beside it means something else. */
  begin(event: PressEvent, at: Point2): void {
    const alone = !this.#down && event.button === 0 && !event.shiftKey && !event.ctrlKey && !event.altKey && !event.metaKey;
    this.end();
    if (!alone) return;
    const finger = event.pointerType === 'touch';
    this.#down = { id: event.pointerId, at, finger };
    if (finger)
      this.#timer = setTimeout(() => {
        this.end();
        this.long(at);
      }, longMs);
  }
  moveTo(at: Point2): void {
    const down = this.#down;
    if (down && Math.hypot(at.x - down.at.x, at.y - down.at.y) > (down.finger ? stillFinger : still)) this.end();
  }
  /** The place, if that pointer has clicked. */
  end(event?: Pick<PointerEvent, 'pointerId'>): Point2 | null {
    const down = this.#down;
    clearTimeout(this.#timer);
    this.#down = null;
    return down && (!down.finger || this.taps()) && event?.pointerId === down.id ? down.at : null;
  }
}
