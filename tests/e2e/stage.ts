// What most browser tests stand on: one server and one browser for a file, and pages that each test opens and nobody need close.
import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll } from 'vitest';
import { Server } from './server';
import { launch, Viewer } from './viewer';

export class Stage {
  server!: Server;
  browser!: Browser;
  readonly #viewers: Viewer[] = [];

  /** For the file that calls it, before its tests. After each test the pages are closed, and the server must be alive. */
  constructor(options: Parameters<typeof Server.start>[0]) {
    beforeAll(async () => {
      this.server = await Server.start(options);
      this.browser = await launch();
    });
    afterAll(async () => {
      await this.browser?.close();
      await this.server?.stop();
    });
    afterEach(async () => {
      for (const viewer of this.#viewers.splice(0)) await viewer.close();
      this.server.checkAlive();
    });
  }

  async open(options?: Parameters<typeof Viewer.open>[2]): Promise<Viewer> {
    const viewer = await Viewer.open(this.browser, this.server.ready.url, options);
    this.#viewers.push(viewer);
    return viewer;
  }
}
