// Frames in, pictures out: each frame is decoded, drawn unless a newer one already is, and acknowledged.
import type { Frame } from './model';

export interface FrameDoors {
  decode(frame: Frame): Promise<ImageBitmap>;
  draw(bitmap: ImageBitmap, frame: Frame): void;
  ack(frameId: bigint, decodeMs: number): void;
  failed(frame: Frame, problem: unknown): void;
  now(): number;
}

export class FramePlayer {
  private drawnId = -1n;
  private epoch = 0;

  constructor(private readonly doors: FrameDoors) {}

  /** Frame ids start again with a new connection; what is still being decoded belongs to the old one. */
  reset(): void {
    this.drawnId = -1n;
    this.epoch += 1;
  }

  async show(frame: Frame): Promise<void> {
    const epoch = this.epoch;
    const begun = this.doors.now();
    let bitmap: ImageBitmap | null = null;
    try {
      bitmap = await this.doors.decode(frame);
    } catch (problem) {
      if (epoch === this.epoch) this.doors.failed(frame, problem);
    }
    const decodeMs = this.doors.now() - begun;
    if (epoch === this.epoch) {
      if (bitmap && frame.frameId > this.drawnId) {
        this.drawnId = frame.frameId;
        this.doors.draw(bitmap, frame);
      }
      // Also a frame that could not be shown has used up its credit.
      this.doors.ack(frame.frameId, decodeMs);
    }
    bitmap?.close();
  }
}

/** The browser's decoder, with the bytes taken as display values: no colour management between the server's picture and the page's. */
export function decodeFrame(frame: Frame): Promise<ImageBitmap> {
  const blob = new Blob([frame.payload], { type: `image/${frame.format}` });
  return createImageBitmap(blob, { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
}
