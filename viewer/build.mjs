// Bundles src/ and three.js into dist/viewer.js, which is committed and embedded by src/view/.
// The banner names the sources' hash, so that a test notices a bundle older than its sources.
import { build } from 'esbuild';
import { createHash } from 'node:crypto';
import { copyFile, mkdir, readdir, readFile } from 'node:fs/promises';

const sources = (await readdir('src')).filter((name) => name.endsWith('.js')).sort();
const hash = createHash('sha256');
for (const name of sources) hash.update(await readFile(`src/${name}`));

const three = JSON.parse(await readFile('node_modules/three/package.json', 'utf8')).version;
await mkdir('dist', { recursive: true });
await build({
  entryPoints: ['src/main.js'],
  outfile: 'dist/viewer.js',
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2022',
  charset: 'ascii',
  legalComments: 'inline',
  banner: {
    js: `/* scandent viewer; sources sha256:${hash.digest('hex')}; contains three.js ${three} (MIT, see LICENSE.three) */`,
  },
});
await copyFile('node_modules/three/LICENSE', 'dist/LICENSE.three');
