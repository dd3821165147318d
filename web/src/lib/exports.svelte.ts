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
  ask(path: string, method: string, body?: string): Promise<Pick<Response, 'ok' | 'json' | 'blob'>>;
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

  constructor(private readonly doors: ExportDoors) {}

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
      const file = await this.doors.ask(`${of}/exports/${begun}`, 'GET');
      if (!file.ok) return 'the server does not have it any more';
      this.doors.save(await file.blob(), `${name}.${format}`);
      return '';
    } catch (problem) {
      return problem instanceof Refused ? problem.message : 'the connection was lost';
    } finally {
      this.waits = false;
      if (begun) this.doors.ask(`${of}/exports/${begun}`, 'DELETE').catch(() => {}); // the server keeps four
    }
  }

  async #told(path: string, method: string, body?: string): Promise<Operation> {
    const response = await this.doors.ask(path, method, body);
    const answer = (await response.json()) as Operation & { detail?: string };
    if (!response.ok) throw new Refused(answer.detail ?? 'the server refused it');
    return answer;
  }
}

class Refused extends Error {}
