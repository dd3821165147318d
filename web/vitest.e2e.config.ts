import './scripts/node-version.js';
import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vitest/config';

// The browser tests live beside the other tests, outside this folder; what they import is resolved from this one.
const here = (path: string) => fileURLToPath(new URL(path, import.meta.url));

export default defineConfig({
  cacheDir: here('./node_modules/.vite-e2e'),
  resolve: {
    alias: {
      'playwright-core': here('./node_modules/playwright-core/index.mjs'),
      '@redocly/openapi-core': here('./node_modules/@redocly/openapi-core/lib/index.js'),
      'ajv/dist/2020': here('./node_modules/ajv/dist/2020.js'),
    },
  },
  server: { fs: { allow: [here('..')] } },
  test: {
    dir: here('../tests/e2e'),
    include: ['**/*.test.ts'],
    environment: 'node',
    fileParallelism: false,
    testTimeout: 120_000,
    expect: { poll: { timeout: 20_000 } }, // a slow machine is not a failure
    hookTimeout: 120_000,
    retry: 1, // deploy/test names each test that needed it
    reporters: ['verbose'],
  },
});
