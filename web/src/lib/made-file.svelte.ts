// A file that the server makes of a session, a mesh of its layers or a film: it is asked for, followed, fetched and handed to the person. Not by its address:
// that has the token in it, and browsers list where files came from.

export const meshFormats = [
  ['vtu', 'Tetrahedra, .vtu'],
  ['vtkhdf', 'Tetrahedra, .vtkhdf'],
  ['ply', 'Surfaces, .ply'],
  ['stl', 'Surfaces, .stl'],
] as const;

export interface FileDoors {
  /** Of the API. */
  ask(path: string, method: string, body?: string, signal?: AbortSignal): Promise<Response>;
  save(file: Blob, name: string): void;
  wait(ms: number): Promise<void>;
}

interface Operation {
  id: string;
  status: 'running' | 'done' | 'failed' | 'cancelled';
  stage?: string;
  fraction?: number;
  error?: { detail?: string };
}

/** One at a time. */
export class MadeFile {
  waits = $state(false);
  /** What the server does for it, and how far it is: 0 to 1. Null: it makes nothing. */
  making = $state.raw<{ stage: string; fraction: number } | null>(null);
  /** Bytes of the file that have come over the line, and all; null: it is not on its way. */
  coming = $state.raw<{ bytes: number; of: number } | null>(null);
  #line = new AbortController();

  constructor(private readonly doors: FileDoors) {}

  /** Of the file that is being made or is on its way. */
  cancel(): void {
    this.#line.abort();
  }
  /** As the server makes it of `wanted`, saved under this name. Why there is no file; empty: it is saved. */
  async save(session: string, kind: 'exports' | 'films', wanted: object, name: string): Promise<string> {
    const of = `sessions/${session}`;
    let begun = '';
    this.waits = true;
    this.#line = new AbortController();
    const { signal } = this.#line;
    try {
      let operation = await this.#told(`${of}/${kind}`, 'POST', JSON.stringify(wanted));
      begun = operation.id;
      for (let pause = 50; operation.status === 'running' && !signal.aborted; pause = Math.min(2 * pause, 500)) {
        this.making = { stage: operation.stage ?? '', fraction: operation.fraction ?? 0 };
        await this.doors.wait(pause);
        operation = await this.#told(`${of}/operations/${operation.id}`, 'GET');
      }
      this.making = null;
      if (operation.status === 'cancelled' || signal.aborted) return 'Cancelled.';
      if (operation.status !== 'done') return operation.error?.detail ?? 'the server could not write it';
      const file = await this.doors.ask(`${of}/${kind}/${begun}`, 'GET', undefined, signal);
      if (!file.ok) return 'the server does not have it any more';
      this.doors.save(await this.#counted(file), name);
      return '';
    } catch (problem) {
      if (signal.aborted) return 'Cancelled.';
      return problem instanceof Refused ? problem.message : 'the connection was lost';
    } finally {
      this.waits = false;
      this.making = null;
      this.coming = null;
      if (begun) this.doors.ask(`${of}/${kind}/${begun}`, 'DELETE').catch(() => {}); // it ends what is still being made, and the server keeps four
    }
  }

  /** Not as parts that the page puts together: the browser can keep a large file on the disk. */
  #counted(file: Response): Promise<Blob> {
    const of = Number(file.headers.get('Content-Length'));
    let bytes = 0;
    const transform = (chunk: Uint8Array, to: TransformStreamDefaultController<Uint8Array>) => {
      bytes += chunk.length;
      this.coming = { bytes, of };
      to.enqueue(chunk);
    };
    return new Response(file.body?.pipeThrough(new TransformStream({ transform }))).blob();
  }
  async #told(path: string, method: string, body?: string): Promise<Operation> {
    const response = await this.doors.ask(path, method, body);
    const answer = (await response.json()) as Operation & { detail?: string };
    if (!response.ok) throw new Refused(answer.detail ?? 'the server refused it');
    return answer;
  }
}

class Refused extends Error {}
