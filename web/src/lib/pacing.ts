// Newest wins: what changes faster than it can be sent waits in one slot per key and goes out once per animation frame.
import type { Camera, IntervalPatch } from './model';

/** Cameras that the server has not answered yet, so that a slow link is not filled with cameras nobody will see. */
export class CameraCredits {
  #outstanding: number[] = [];
  #lastSentMs = -Infinity;

  constructor(
    private readonly most = 3,
    private readonly patienceMs = 250,
  ) {}

  /** A frame may be long in coming, or never come (nothing is open): after the patience one more may go. */
  open(nowMs: number): boolean {
    return this.#outstanding.length < this.most || nowMs - this.#lastSentMs >= this.patienceMs;
  }
  sent(seq: number, nowMs: number): void {
    this.#outstanding.push(seq);
    this.#lastSentMs = nowMs;
  }
  /** A frame has come that contains every input up to `seq`. */
  answered(seq: number): void {
    this.#outstanding = this.#outstanding.filter((s) => s > seq);
  }
  reset(): void {
    this.#outstanding = [];
    this.#lastSentMs = -Infinity;
  }
}

export interface OutboxDoors {
  sendCamera(camera: Camera): void;
  sendPatch(id: number, patch: IntervalPatch): void;
  sendOther(key: string, value: unknown): void;
  cameraMayGo(): boolean;
  /** Calls back once before the next picture of the screen: requestAnimationFrame, or a test's own. */
  schedule(callback: () => void): void;
}

/** One slot for the camera, one per interval (patches merge), one per other key. */
export class Outbox {
  #camera: Camera | null = null;
  #patches = new Map<number, IntervalPatch>();
  #others = new Map<string, unknown>();
  #scheduled = false;

  constructor(private readonly doors: OutboxDoors) {}

  putCamera(camera: Camera): void {
    this.#camera = camera;
    this.#wake();
  }
  putPatch(id: number, patch: IntervalPatch): void {
    this.#patches.set(id, { ...this.#patches.get(id), ...patch });
    this.#wake();
  }
  put(key: string, value: unknown): void {
    this.#others.delete(key); // what is put last goes out last
    this.#others.set(key, value);
    this.#wake();
  }

  /** Sends what waits, in any case: before a command that must come after it, or at the end of a drag. */
  flush(): void {
    const [patches, others, camera] = [this.#patches, this.#others, this.#camera];
    this.#patches = new Map();
    this.#others = new Map();
    this.#camera = null;
    for (const [id, patch] of patches) this.doors.sendPatch(id, patch);
    for (const [key, value] of others) this.doors.sendOther(key, value);
    if (camera) this.doors.sendCamera(camera);
  }
  /** Forgets what waits about an interval that is gone, or everything. */
  drop(id?: number): void {
    if (id !== undefined) {
      this.#patches.delete(id);
      return;
    }
    this.#patches.clear();
    this.#others.clear();
    this.#camera = null;
  }

  #wake(): void {
    if (this.#scheduled) return;
    this.#scheduled = true;
    this.doors.schedule(() => this.#tick());
  }
  #tick(): void {
    this.#scheduled = false;
    const held = this.#camera && !this.doors.cameraMayGo() ? this.#camera : null;
    if (held) this.#camera = null;
    this.flush();
    if (held) this.putCamera(held);
  }
}
