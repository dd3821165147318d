// What this browser decodes, found by decoding: a frame with a known picture goes in, and the right pixels must come out. A
// browser's own word (isConfigSupported) is not taken: decoders hold frames back, and read colours in a way of their own.
import { insideBlock, probeColor, probeSide, probeStream, type ProbeStream } from './probe-stream';
import { browserVideo, videoColor } from './video-decoder';

const patienceMs = 1500;

/** How far a block's middle may be from its colour, of 255. */
export const tolerance = 6;

export interface ProbeDoors {
  /** The picture's pixels, rgba, of probeSide x probeSide; rejects if it cannot be decoded. */
  decode(stream: ProbeStream): Promise<Uint8ClampedArray>;
  setTimeout(callback: () => void, ms: number): unknown;
}

/** Every pixel is what it should be, which takes full chroma. */
export function rightPixels(pixels: Uint8ClampedArray): boolean {
  for (let y = 0; y < probeSide; y++)
    for (let x = 0; x < probeSide; x++) {
      const color = probeColor(x, y);
      const inside = insideBlock(x, y);
      for (let c = 0; c < 3; c++) {
        const apart = Math.abs((pixels[4 * (y * probeSide + x) + c] as number) - (color[c] as number));
        if (apart > (inside ? tolerance : 4 * tolerance)) return false;
      }
    }
  return true;
}

/** The formats for frames in motion that this browser shows rightly, for Hello; JPEG is always among them. */
export async function probeDecoders(doors: ProbeDoors | null): Promise<string[]> {
  if (!doors) return ['jpeg'];
  const late = new Promise<false>((resolve) => doors.setTimeout(() => resolve(false), patienceMs));
  try {
    const pixels = await Promise.race([doors.decode(probeStream), late]);
    return pixels !== false && rightPixels(pixels) ? [probeStream.format, 'jpeg'] : ['jpeg'];
  } catch {
    return ['jpeg'];
  }
}

/** null if the browser has no VideoDecoder: an insecure context, or an old browser. */
export function browserProbe(): ProbeDoors | null {
  if (typeof VideoDecoder === 'undefined' || typeof EncodedVideoChunk === 'undefined') return null;
  return { decode: decodeInBrowser, setTimeout: (callback, ms) => window.setTimeout(callback, ms) };
}

function decodeInBrowser({ codec, base64 }: ProbeStream): Promise<Uint8ClampedArray> {
  return new Promise((resolve, reject) => {
    const decoder = browserVideo.create({
      output: (picture) => {
        const canvas = document.createElement('canvas');
        canvas.width = canvas.height = probeSide;
        const context = canvas.getContext('2d', { alpha: false, willReadFrequently: true });
        context?.drawImage(picture, 0, 0);
        picture.close();
        decoder.close();
        if (context) resolve(context.getImageData(0, 0, probeSide, probeSide).data);
        else reject(new Error('no canvas'));
      },
      error: reject,
    });
    decoder.configure({ codec, codedWidth: probeSide, codedHeight: probeSide, optimizeForLatency: true, colorSpace: videoColor });
    const data = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    decoder.decode(browserVideo.chunk({ type: 'key', timestamp: 1, data }));
  });
}
