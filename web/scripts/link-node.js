// Run by npm ci at its end: the pinned Node becomes node_modules/.bin/node, which npm's scripts find first. npm would link it itself, but npm 9
// takes the link away again together with the package that is for another kind of processor.
import { existsSync, mkdirSync, rmSync, symlinkSync } from 'node:fs';
import { join } from 'node:path';
import process from 'node:process';
import { fileURLToPath } from 'node:url';

const modules = fileURLToPath(new URL('../node_modules', import.meta.url));
const program = join('..', `node-${process.platform}-${process.arch}`, 'bin', 'node');
const link = join(modules, '.bin', 'node');
if (existsSync(join(modules, '.bin', program))) {
  mkdirSync(join(modules, '.bin'), { recursive: true });
  rmSync(link, { force: true });
  symlinkSync(program, link);
}
