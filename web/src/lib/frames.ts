// Frames in, pictures out: each frame is decoded, drawn unless a newer one already is, and acknowledged.
import type { Frame } from './told';
import { StreamDecoder } from './video-decoder';

export type Picture = ImageBitmap | VideoFrame;

export interface FrameDoors {
  decode(frame: Frame): Promise<Picture>;
  /** `complete`: nothing of what it belongs to is missing any more. */
  draw(picture: Picture, frame: Frame, complete: boolean): void;
  ack(frameId: bigint, decodeMs: number): void;
  failed(frame: Frame, problem: unknown): void;
  now(): number;
}

export class FramePlayer {
  #drawnId = -1n; // of a picture in bands: its first band's
  #bandsDrawn = 0;
  #epoch = 0;

  constructor(private readonly doors: FrameDoors) {}

  /** Frame ids start again with a new connection; what is still being decoded belongs to the old one. */
  reset(): void {
    this.#drawnId = -1n;
    this.#epoch += 1;
  }

  async show(frame: Frame): Promise<void> {
    const epoch = this.#epoch;
    const begun = this.doors.now();
    let picture: Picture | null = null;
    try {
      picture = await this.doors.decode(frame);
    } catch (problem) {
      if (epoch === this.#epoch) this.doors.failed(frame, problem);
    }
    const decodeMs = this.doors.now() - begun;
    if (epoch === this.#epoch) {
      if (picture) this.#draw(picture, frame);
      // Also a frame that could not be shown has used up its credit.
      this.doors.ack(frame.frameId, decodeMs);
    }
    picture?.close();
  }

  #draw(picture: Picture, frame: Frame): void {
    const first = firstOf(frame);
    if (first < this.#drawnId || (first === this.#drawnId && !frame.band)) return;
    // Bands of one picture come in any order: they are decoded side by side.
    this.#bandsDrawn = first === this.#drawnId ? this.#bandsDrawn + 1 : 1;
    this.#drawnId = first;
    this.doors.draw(picture, frame, this.#bandsDrawn === (frame.band?.count ?? 1));
  }
}

/** The picture that a frame belongs to, by the id of its first band. */
const firstOf = (frame: Frame): bigint => frame.frameId - BigInt(frame.band?.index ?? 0);

/** The browser's decoders: video by its stream, all else by itself. */
export class FrameDecoder {
  readonly #stream = new StreamDecoder();

  decode(frame: Frame): Promise<Picture> {
    return frame.streamId !== 0 ? this.#stream.decode(frame) : decodeImage(frame);
  }
  /** Stream ids start again with a new connection. */
  reset(): void {
    this.#stream.reset();
  }
}

/** With the bytes taken as display values: no colour management between the server's picture and the page's. */
function decodeImage(frame: Frame): Promise<ImageBitmap> {
  const blob = new Blob([frame.payload], { type: `image/${frame.format}` });
  return createImageBitmap(blob, { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
}
