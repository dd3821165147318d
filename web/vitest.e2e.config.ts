import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vitest/config';

// The browser tests live beside the other tests, outside this folder; their imports are resolved from this one.
const here = (path: string) => fileURLToPath(new URL(path, import.meta.url));

export default defineConfig({
  root: here('..'),
  resolve: { alias: { 'playwright-core': here('./node_modules/playwright-core'), vitest: here('./node_modules/vitest') } },
  test: {
    include: ['tests/e2e/**/*.test.ts'],
    environment: 'node',
    fileParallelism: false,
    testTimeout: 120_000,
    hookTimeout: 120_000,
    reporters: ['verbose'],
  },
});
