import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vitest/config';

// The browser tests live beside the other tests, outside this folder; what they import is resolved from this one.
const here = (path: string) => fileURLToPath(new URL(path, import.meta.url));

export default defineConfig({
  cacheDir: here('./node_modules/.vite-e2e'),
  resolve: { alias: { 'playwright-core': here('./node_modules/playwright-core/index.mjs') } },
  server: { fs: { allow: [here('..')] } },
  test: {
    dir: here('../tests/e2e'),
    include: ['**/*.test.ts'],
    environment: 'node',
    fileParallelism: false,
    testTimeout: 120_000,
    hookTimeout: 120_000,
    reporters: ['verbose'],
  },
});
