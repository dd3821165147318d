// The layers as a mesh file: the server writes it, the page fetches it and hands it to the person. Not by its address: that has the token in it, and
// browsers list where files came from.

export const meshFormats = [
  ['vtu', 'Tetrahedra, .vtu'],
  ['vtkhdf', 'Tetrahedra, .vtkhdf'],
  ['ply', 'Surfaces, .ply'],
  ['stl', 'Surfaces, .stl'],
] as const;

export interface ExportDoors {
  /** Of the API. */
  ask(path: string, method: string, body?: string, signal?: AbortSignal): Promise<Response>;
  save(file: Blob, name: string): void;
  wait(ms: number): Promise<void>;
}

interface Operation {
  id: string;
  status: 'running' | 'done' | 'failed' | 'cancelled';
  error?: { detail?: string };
}

export class Exports {
  waits = $state(false);
  /** Bytes of the file that have come over the line, and all; null: it is not on its way. */
  coming = $state.raw<{ bytes: number; of: number } | null>(null);
  #line = new AbortController();

  constructor(private readonly doors: ExportDoors) {}

  /** Of the file that is on its way. */
  cancel(): void {
    this.#line.abort();
  }
  /** All layers of the session, hidden ones too. Why there is no file; empty: it is saved. */
  async save(session: string, format: string, name: string): Promise<string> {
    const of = `sessions/${session}`;
    let begun = '';
    this.waits = true;
    try {
      let operation = await this.#told(`${of}/exports`, 'POST', JSON.stringify({ format }));
      begun = operation.id;
      for (let pause = 50; operation.status === 'running'; pause = Math.min(2 * pause, 500)) {
        await this.doors.wait(pause);
        operation = await this.#told(`${of}/operations/${operation.id}`, 'GET');
      }
      if (operation.status === 'cancelled') return 'Cancelled.';
      if (operation.status !== 'done') return operation.error?.detail ?? 'the server could not write it';
      this.#line = new AbortController();
      const file = await this.doors.ask(`${of}/exports/${begun}`, 'GET', undefined, this.#line.signal);
      if (!file.ok) return 'the server does not have it any more';
      this.doors.save(await this.#counted(file), `${name}.${format}`);
      return '';
    } catch (problem) {
      if (this.#line.signal.aborted) return 'Cancelled.';
      return problem instanceof Refused ? problem.message : 'the connection was lost';
    } finally {
      this.waits = false;
      this.coming = null;
      if (begun) this.doors.ask(`${of}/exports/${begun}`, 'DELETE').catch(() => {}); // the server keeps four
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
