// The picture on the screen: how large it is to be, what is known of the frame that it shows, and how the frames are decoded and acknowledged.
import { command, type Command, type ViewportSize } from './commands';
import { FrameDecoder, FramePlayer, type Picture } from './frames';
import { RateMeter } from './meter';
import type { Frame } from './told';
import type { Outbox } from './pacing';
import { StreamLost } from './video-decoder';

/** A frame without its bytes, and what this side measured of it. */
export type FrameReadout = Omit<Frame, 'payload'> & { bytes: number; decodeMs: number; fps: number };

export interface FrameViewDoors {
  send(body: Command): void;
  slots: Pick<Outbox, 'put'>;
  /** On whatever connection there is: the server paces itself by these. */
  acknowledge(body: Command): void;
  say(text: string): void;
  now(): number;
}

export class FrameView {
  /** The newest frame; null: none has come on this connection. */
  frame = $state.raw<FrameReadout | null>(null);
  /** The newest one that was shown while something changed. */
  moving = $state.raw<FrameReadout | null>(null);
  /** Set by the viewport: the finished picture is all background. */
  blank = $state(false);
  /** In pixels of the device; frames in motion may have fewer. */
  viewport = $state.raw<ViewportSize>({ width: 800, height: 600, hidden: false });
  /** Set by the viewport. */
  draw: ((picture: Picture, frame: Frame, complete: boolean) => void) | null = null;

  readonly #player: FramePlayer;
  readonly #decoder = new FrameDecoder();
  readonly #rate = new RateMeter();

  constructor(private readonly doors: FrameViewDoors) {
    this.#player = new FramePlayer({
      decode: (frame) => this.#decoder.decode(frame),
      draw: (picture, frame, complete) => this.draw?.(picture, frame, complete),
      ack: (frameId, decodeMs) => {
        doors.acknowledge(command.frameAck(frameId, decodeMs));
        if (this.frame?.frameId === frameId) this.frame = { ...this.frame, decodeMs };
      },
      failed: (frame, problem) => {
        // Of video the server sends another stream; nobody needs to be told.
        if (problem instanceof StreamLost) doors.send(command.decoderFailed(problem));
        else if (frame.streamId === 0)
          doors.say(`A ${frame.format.toUpperCase()} frame of ${frame.payload.length} bytes could not be decoded: ${String(problem)}`);
      },
      now: doors.now,
    });
  }

  resize(size: { width: number; height: number }): void {
    if (size.width === this.viewport.width && size.height === this.viewport.height) return;
    this.viewport = { ...this.viewport, ...size };
    this.doors.slots.put('viewport', command.viewport(this.viewport));
  }
  setHidden(hidden: boolean): void {
    this.viewport = { ...this.viewport, hidden };
    this.tellViewport(); // at once: a hidden page has no pictures of the screen
  }
  tellViewport(): void {
    this.doors.send(command.viewport(this.viewport));
  }

  /** Another connection: what the server sends on it is all there is. */
  welcomed(): void {
    this.frame = null;
  }
  told(frame: Frame): void {
    if (!frame.band?.index) this.#rate.tick(this.doors.now());
    const more = continued(this.frame, frame);
    this.frame = more ?? begun(this.frame, frame, this.#rate.rate(this.doors.now()));
    if (!more && frame.phase === 'moving') this.moving = this.frame;
    void this.#player.show(frame);
  }
  lost(): void {
    this.#player.reset();
    this.#decoder.reset();
  }
}

/** The facts come with a picture's first band, and only with its last one it is whole. */
export function begun(before: FrameReadout | null, { payload, ...facts }: Frame, fps: number): FrameReadout {
  const part = (facts.band?.count ?? 1) > 1 ? { phase: 'settled' as const } : {};
  return { ...facts, ...part, bytes: payload.length, decodeMs: before?.decodeMs ?? 0, fps };
}
/** What is known of a picture with one more of its bands; null: the frame is not one. */
export function continued(before: FrameReadout | null, { band, payload, ...facts }: Frame): FrameReadout | null {
  if (!band?.index || !before) return null;
  const { phase } = band.index + 1 === band.count ? facts : before;
  return { ...before, frameId: facts.frameId, phase, bytes: before.bytes + payload.length };
}
