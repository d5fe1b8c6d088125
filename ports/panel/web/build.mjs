// Builds the page from its sources into `dist`, which is committed: `npm ci && npm run build`. With `--check` nothing is written; it
// fails if `dist` is not what the sources give.

import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { build } from 'esbuild';

const bundle = await build({
  entryPoints: ['src/main.js'], bundle: true, minify: true, format: 'esm', target: 'es2022', outfile: 'dist/panel.js',
  legalComments: 'none', write: false, charset: 'utf8',
});
const of = (end) => bundle.outputFiles.find(({ path }) => path.endsWith(end)).text;
const licence = async (name, file) => {
  const { version } = JSON.parse(await readFile(`node_modules/${name}/package.json`, 'utf8'));
  return `${name} ${version}\n\n${await readFile(`node_modules/${name}/${file}`, 'utf8')}`;
};
const files = {
  'panel.js': of('.js'),
  'panel.css': `${of('.css')}${await readFile('panel.css', 'utf8')}`,
  'index.html': await readFile('index.html', 'utf8'),
  'icon.svg': await readFile('icon.svg', 'utf8'),
  'notices.txt': `The panel's page contains the following.\n\n${[await licence('three', 'LICENSE'), await licence('uplot', 'LICENSE')].join('\n\n')}`,
};
const check = process.argv.includes('--check');
await mkdir('dist', { recursive: true });
for (const [name, text] of Object.entries(files)) {
  if (!check) {
    await writeFile(`dist/${name}`, text);
  } else if ((await readFile(`dist/${name}`, 'utf8')) !== text) {
    console.error(`dist/${name} is not what its sources give\n help: npm ci && npm run build`);
    process.exitCode = 1;
  }
}
const kilobytes = Object.values(files).reduce((sum, text) => sum + Buffer.byteLength(text), 0) / 1000;
console.log(`panel: ${kilobytes.toFixed(0)} kB, ${check ? 'compared' : 'built'}`);
