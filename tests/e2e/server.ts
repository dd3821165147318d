// A real `isostrata serve` for a test: started on a free port, watched, stopped by its own process id.
import { spawn, type ChildProcess } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

export const repository = resolve(dirname(fileURLToPath(import.meta.url)), '..', '..');
export const binary = join(resolve(repository, process.env.ISOSTRATA_BIN_DIR ?? 'build/release/bin'), 'isostrata');
export const dataFolder = resolve(repository, process.env.ISOSTRATA_TEST_DATA ?? '../shared/data');

interface Ready {
  url: string;
  port: number;
  pid: number;
  device: string;
  worker: number | null; // the process that draws first
}

export interface ServerOptions {
  data: string[];
  token?: string;
  port?: number;
  more?: string[]; // further arguments
}

export class Server {
  ready!: Ready;
  log = '';

  private constructor(
    private readonly child: ChildProcess,
    readonly options: ServerOptions,
  ) {}

  /** Rejects with the server's own words if it does not come up within a minute. */
  static async start(options: ServerOptions): Promise<Server> {
    if (!existsSync(binary)) throw new Error(`${binary} is not there: build it, or set ISOSTRATA_BIN_DIR`);
    const webRoot = join(repository, 'web', 'dist');
    if (!existsSync(join(webRoot, 'index.html'))) throw new Error(`${webRoot} has no page: run npm run build`);
    const folder = mkdtempSync(join(tmpdir(), 'isostrata-e2e-ready-'));
    const readyFile = join(folder, 'ready.json');
    const port = String(options.port ?? 0);
    const more = [...(options.more ?? [])];
    if (!more.includes('--state-dir')) more.push('--state-dir', 'none'); // a test leaves nothing behind
    const args = ['serve', ...options.data, '--port', port, '--ready-file', readyFile, '--web-root', webRoot, ...more];
    const env = { ...process.env, ISOSTRATA_CACHE: 'off', ...(options.token ? { ISOSTRATA_TOKEN: options.token } : {}) };
    const child = spawn(binary, args, { cwd: repository, env, stdio: ['ignore', 'pipe', 'pipe'] });
    const server = new Server(child, options);
    for (const stream of [child.stdout, child.stderr]) stream?.on('data', (text) => (server.log += String(text)));
    const begun = Date.now();
    try {
      while (!existsSync(readyFile)) {
        if (child.exitCode !== null) throw new Error(`isostrata serve ended with status ${child.exitCode}:\n${server.log}`);
        if (Date.now() - begun > 60_000) throw new Error(`isostrata serve was not ready after a minute:\n${server.log}`);
        await new Promise((done) => setTimeout(done, 50));
      }
      server.ready = JSON.parse(readFileSync(readyFile, 'utf8')) as Ready;
    } catch (problem) {
      child.kill('SIGKILL');
      throw problem;
    } finally {
      rmSync(folder, { recursive: true, force: true });
    }
    return server;
  }

  get alive(): boolean {
    return this.child.exitCode === null && this.child.signalCode === null;
  }

  /** Throws with the server's last words if it has died on its own. */
  checkAlive(): void {
    if (this.alive) return;
    const how = this.child.signalCode ?? `status ${this.child.exitCode}`;
    throw new Error(`isostrata serve died (${how}):\n${this.log.slice(-4000)}`);
  }

  async stop(signal: 'SIGTERM' | 'SIGKILL' = 'SIGTERM'): Promise<void> {
    if (this.alive) {
      const ended = new Promise((done) => this.child.once('exit', done));
      this.child.kill(signal);
      const late = setTimeout(() => this.child.kill('SIGKILL'), 10_000);
      await ended;
      clearTimeout(late);
    }
  }
}
