// Frames in, pictures out: each frame is decoded, drawn unless a newer one already is, and acknowledged.
import type { Frame } from './model';
import { StreamDecoder } from './video-decoder';

export type Picture = ImageBitmap | VideoFrame;

export interface FrameDoors {
  decode(frame: Frame): Promise<Picture>;
  draw(picture: Picture, frame: Frame): void;
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
    let picture: Picture | null = null;
    try {
      picture = await this.doors.decode(frame);
    } catch (problem) {
      if (epoch === this.epoch) this.doors.failed(frame, problem);
    }
    const decodeMs = this.doors.now() - begun;
    if (epoch === this.epoch) {
      if (picture && frame.frameId > this.drawnId) {
        this.drawnId = frame.frameId;
        this.doors.draw(picture, frame);
      }
      // Also a frame that could not be shown has used up its credit.
      this.doors.ack(frame.frameId, decodeMs);
    }
    picture?.close();
  }
}

/** The browser's decoders: video by its stream, all else by itself. */
export class FrameDecoder {
  private readonly stream = new StreamDecoder();

  decode(frame: Frame): Promise<Picture> {
    return frame.streamId !== 0 ? this.stream.decode(frame) : decodeImage(frame);
  }
  /** Stream ids start again with a new connection. */
  reset(): void {
    this.stream.reset();
  }
}

/** With the bytes taken as display values: no colour management between the server's picture and the page's. */
function decodeImage(frame: Frame): Promise<ImageBitmap> {
  const blob = new Blob([frame.payload], { type: `image/${frame.format}` });
  return createImageBitmap(blob, { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
}
