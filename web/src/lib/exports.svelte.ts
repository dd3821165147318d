// The layers as a mesh file: the server writes it, the page waits for it and hands its address to the browser.

export const meshFormats = [
  ['vtu', 'Tetrahedra, .vtu'],
  ['vtkhdf', 'Tetrahedra, .vtkhdf'],
  ['ply', 'Surfaces, .ply'],
  ['stl', 'Surfaces, .stl'],
] as const;

export interface ExportDoors {
  /** Of the API. */
  ask(path: string, method: string, body?: string): Promise<Pick<Response, 'ok' | 'json'>>;
  /** Lets the browser fetch a file of the API. */
  give(path: string): void;
  wait(ms: number): Promise<void>;
}

interface Operation {
  id: string;
  status: 'running' | 'done' | 'failed' | 'cancelled';
  error?: { detail?: string };
}

export class Exports {
  waits = $state(false);
  #given = ''; // the newest export that the browser was told of

  constructor(private readonly doors: ExportDoors) {}

  /** All layers of the session, hidden ones too. Why there is no file; empty: the browser is told of it. */
  async save(session: string, format: string): Promise<string> {
    const of = `sessions/${session}`;
    this.waits = true;
    try {
      // The server keeps four. What of the one before is still on its way goes on.
      if (this.#given) await this.doors.ask(this.#given, 'DELETE');
      this.#given = '';
      let operation = await this.#told(`${of}/exports`, 'POST', JSON.stringify({ format }));
      for (let pause = 50; operation.status === 'running'; pause = Math.min(2 * pause, 500)) {
        await this.doors.wait(pause);
        operation = await this.#told(`${of}/operations/${operation.id}`, 'GET');
      }
      if (operation.status === 'cancelled') return 'Cancelled.';
      if (operation.status !== 'done') return operation.error?.detail ?? 'the server could not write it';
      this.#given = `${of}/exports/${operation.id}`;
      this.doors.give(this.#given);
      return '';
    } catch (problem) {
      return problem instanceof Refused ? problem.message : 'the connection was lost';
    } finally {
      this.waits = false;
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
