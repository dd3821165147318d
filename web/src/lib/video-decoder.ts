// A video stream's frames, one in and one out, by the browser's VideoDecoder. It exists only in secure contexts: https, or http to localhost,
// which is what an ssh tunnel gives.
import type { Frame } from './told';

/** How the server means Y, Cb and Cr; also in the bitstream, but Firefox and older browsers listen only here. */
export const videoColor = { primaries: 'bt709', transfer: 'iec61966-2-1', matrix: 'smpte170m', fullRange: false } as const;

export interface VideoDoors {
  create(init: VideoDecoderInit): VideoDecoder;
  chunk(init: EncodedVideoChunkInit): EncodedVideoChunk;
}

export const browserVideo: VideoDoors = {
  create: (init) => new VideoDecoder(init),
  chunk: (init) => new EncodedVideoChunk(init),
};

/** Why a stream goes on no more. `again`: a new stream of the same format will do. */
export class StreamLost extends Error {
  constructor(
    message: string,
    readonly streamId: number,
    readonly again: boolean,
  ) {
    super(message);
  }
}

interface Waiting {
  resolve(picture: VideoFrame): void;
  reject(problem: unknown): void;
}

/** Decodes what it is given, in order; whoever gets a picture closes it. */
export class StreamDecoder {
  #decoder: VideoDecoder | null = null;
  #streamId = 0;
  #configured = '';
  #failed: StreamLost | null = null; // of the newest stream
  #told = false;
  readonly #waiting = new Map<number, Waiting>(); // by timestamp, which is the frame's id: in order

  constructor(private readonly doors: VideoDoors = browserVideo) {}

  /** Rejects with StreamLost for one frame of a stream that is lost, and with a plain Error for the others. */
  decode(frame: Frame): Promise<VideoFrame> {
    return new Promise((resolve, reject) => {
      if (frame.streamId === this.#failed?.streamId) return reject(this.#tell());
      const id = Number(frame.frameId);
      this.#waiting.set(id, { resolve, reject });
      try {
        this.#prepare(frame);
        const type = frame.key ? 'key' : 'delta';
        this.#decoder?.decode(this.doors.chunk({ type, timestamp: id, data: frame.payload }));
      } catch (problem) {
        this.#lost(problem, false);
      }
    });
  }

  /** Forgets everything; what waits is rejected. */
  reset(): void {
    const waiting = [...this.#waiting.values()];
    this.#waiting.clear();
    if (this.#decoder && this.#decoder.state !== 'closed') this.#decoder.close();
    this.#decoder = null;
    this.#streamId = 0;
    this.#failed = null;
    this.#configured = '';
    for (const { reject } of waiting) reject(new Error('the connection has ended'));
  }

  #prepare(frame: Frame): void {
    if (frame.streamId !== this.#streamId) {
      if (this.#decoder && this.#decoder.state !== 'closed') this.#decoder.close();
      this.#streamId = frame.streamId;
      this.#configured = '';
      const streamId = frame.streamId;
      this.#decoder = this.doors.create({
        output: (picture) => (streamId === this.#streamId ? this.#out(picture) : picture.close()),
        // Browsers take decoders away from pages that nobody sees: QuotaExceededError.
        error: (problem) => streamId === this.#streamId && this.#lost(problem, problem.name === 'QuotaExceededError'),
      });
    }
    if (!frame.key) {
      if (this.#configured === '') throw new Error('the stream does not begin with a key frame');
      return;
    }
    const wanted = `${frame.decoder} ${frame.width}x${frame.height}`;
    if (wanted === this.#configured) return;
    this.#decoder?.configure({
      codec: frame.decoder,
      codedWidth: frame.width,
      codedHeight: frame.height,
      optimizeForLatency: true, // else Chromium holds a frame back
      colorSpace: videoColor,
    });
    this.#configured = wanted;
  }

  #out(picture: VideoFrame): void {
    for (const [id, waiting] of [...this.#waiting]) {
      if (id > picture.timestamp) break;
      this.#waiting.delete(id);
      if (id === picture.timestamp) return waiting.resolve(picture);
      waiting.reject(new Error('the decoder gave no picture for it'));
    }
    picture.close();
  }

  #lost(problem: unknown, again: boolean): void {
    if (this.#failed?.streamId === this.#streamId) return;
    const text = problem instanceof Error ? `${problem.name}: ${problem.message}` : String(problem);
    this.#failed = new StreamLost(text, this.#streamId, again);
    this.#told = false; // where nothing waits, the next frame tells
    const waiting = [...this.#waiting.values()];
    this.#waiting.clear();
    for (const { reject } of waiting) reject(this.#tell());
    if (this.#decoder && this.#decoder.state !== 'closed') this.#decoder.close();
  }

  #tell(): Error {
    const problem = this.#told || !this.#failed ? new Error('its stream was lost') : this.#failed;
    this.#told = true;
    return problem;
  }
}
