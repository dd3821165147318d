// What this browser decodes, found by decoding: a frame of each format with a known picture goes in, and the right pixels must come out. A
// browser's own word (isConfigSupported) is not taken: decoders hold frames back, and read colours in a way of their own.
import { insideBlock, probeColor, probeSide, probeStreams, type ProbeStream } from './probe-streams';
import { browserVideo, videoColor } from './video-decoder';

const patienceMs = 1500;

/** How far a block's middle may be from its colour, of 255. */
export const tolerance = 6;

export interface ProbeDoors {
  /** The picture's pixels, rgba, of probeSide x probeSide; rejects where it cannot be decoded. */
  decode(stream: ProbeStream): Promise<Uint8ClampedArray>;
  setTimeout(callback: () => void, ms: number): unknown;
}

/** The blocks' middles, and with full chroma every pixel, are what they should be. */
export function rightPixels(pixels: Uint8ClampedArray, fullChroma: boolean): boolean {
  for (let y = 0; y < probeSide; y++)
    for (let x = 0; x < probeSide; x++) {
      const color = probeColor(x, y);
      const inside = insideBlock(x, y);
      if (!inside && !fullChroma) continue;
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
  const right = probeStreams.map(async (stream) => {
    try {
      const pixels = await Promise.race([doors.decode(stream), late]);
      return pixels !== false && rightPixels(pixels, stream.fullChroma);
    } catch {
      return false;
    }
  });
  const found = await Promise.all(right);
  return [...probeStreams.filter((_stream, i) => found[i]).map((stream) => stream.format), 'jpeg'];
}

/** null where the browser has no VideoDecoder: an insecure context, or an old browser. */
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
