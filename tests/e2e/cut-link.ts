// A line between the page and a server that a test can cut: the connections on it break, and new ones are refused until it is mended.
import { createServer, connect, type Server, type Socket } from 'node:net';
import type { AddressInfo } from 'node:net';

export class CutLink {
  private readonly open = new Set<Socket>();
  private whole = true;

  private constructor(private readonly listener: Server) {}

  static async to(port: number): Promise<CutLink> {
    const listener = createServer();
    const link = new CutLink(listener);
    listener.on('connection', (near) => {
      if (!link.whole) return void near.destroy();
      const far = connect(port, '127.0.0.1');
      for (const [one, other] of [
        [near, far],
        [far, near],
      ] as const) {
        link.open.add(one);
        one.setNoDelay(true);
        one.pipe(other);
        one.on('error', () => other.destroy());
        one.on('close', () => {
          link.open.delete(one);
          other.destroy();
        });
      }
    });
    await new Promise<void>((done) => listener.listen(0, '127.0.0.1', done));
    return link;
  }

  get port(): number {
    return (this.listener.address() as AddressInfo).port;
  }
  cut(): void {
    this.whole = false;
    for (const socket of this.open) socket.resetAndDestroy();
  }
  mend(): void {
    this.whole = true;
  }
  async close(): Promise<void> {
    this.cut();
    await new Promise((done) => this.listener.close(done));
  }
}
